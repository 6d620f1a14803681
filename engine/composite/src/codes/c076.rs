use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Recording not supported
///
/// The `record` key is valid, but this version does not record runs through the composite file. It has
/// no effect.
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
#[error("`record` is not supported by this version")]
pub(crate) struct RecordIgnored {
    pub at: Span,
}

impl Finding for RecordIgnored {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "has no effect")
            .help("record ports and topics with `asmotion run --record FILE --ports NAME`")
    }
}
