use std::borrow::Cow;

use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Key not supported by this version
///
/// The key is valid, but this version ignores it: `record` of `[deploy]`, `[bridges]` of kinds that this build does not
/// connect, operations of a ros-bridge that connects topics only, and how to start a program outside (`arguments`, `executable`, `name_service`).
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 1000
///
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Map"] },
///   { name = "desk", components = ["User"] },
/// ]
/// record = { dir = "runs/" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 1000
///
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Map"] },
///   { name = "desk", components = ["User"] },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C076, warning)]
#[error("`{key}` is not supported by this version")]
pub(crate) struct UnsupportedKey {
    pub key: &'static str,
    pub at: Span,
    /// Way out without the key.
    pub instead: Cow<'static, str>,
}

impl Finding for UnsupportedKey {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "has no effect")
            .help(self.instead.clone())
    }
}
