use crate::nearest::Suggest;
use crate::nearest::nearest_name;
use crate::wording::has;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Member not declared by the component
///
/// A composite may list the ports, services, operations and references of a component for its readers. The list is
/// compared with the declarations of the component, and this entry is not among them.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { map = "nav/MapService" }
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
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C026, error)]
#[error("unknown {what} `{name}` of `{implementation}`")]
pub(crate) struct UndeclaredMember {
    pub implementation: String,
    pub what: &'static str,
    pub name: String,
    pub at: Span,
    pub made_of: Span,
    pub known: Vec<String>,
}

impl Finding for UndeclaredMember {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { name, what, .. } = self;
        diagnostic
            .label(self.at, "not declared by the component")
            .label(self.made_of, "component implemented here")
            .suggest_or(
                self.at,
                &nearest_name(name, self.known.iter().map(String::as_str)),
                has(what, self.known.iter().map(String::as_str)),
            )
    }
}
