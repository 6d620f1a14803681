use crate::nearest::Nearest;
use crate::nearest::Suggest;
use crate::wording::has;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown member of a component
///
/// The component has no port, service, reference or property of this name.
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
/// service = "Map.map"
/// timeout_ms = 1000
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
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C021, error)]
#[error("unknown {what} `{name}` of `{component}`")]
pub(crate) struct UnknownMember {
    pub what: &'static str,
    pub component: String,
    pub name: String,
    pub at: Span,
    /// Kind of the member that has this name instead.
    pub instead: Option<&'static str>,
    pub nearest: Option<Nearest>,
    pub known: Vec<String>,
}

impl Finding for UnknownMember {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            what,
            instead,
            nearest,
            known,
            name,
            ..
        } = self;
        let known = has(what, known.iter().map(String::as_str));
        match instead {
            Some(instead) => diagnostic
                .label(self.at, format!("`{name}` is {instead}"))
                .help(known),
            None => diagnostic
                .label(self.at, "not declared")
                .suggest_or(self.at, nearest, known),
        }
    }
}
