use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid substitution
///
/// `${properties.name}` is a property of the composite, `${VARIABLE}` an environment variable, and
/// `${VARIABLE:-default}` an environment variable with a default. Write `$$` for a dollar sign.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [properties]
/// folder = { type = "string", default = "maps" }
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// properties = { source = "${properties.folder" }
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
/// [properties]
/// folder = { type = "string", default = "maps" }
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// properties = { source = "${properties.folder}" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C012, error)]
#[error("invalid substitution: {reason}")]
pub(crate) struct InvalidSubstitution {
    pub reason: &'static str,
    pub at: Span,
}

impl Finding for InvalidSubstitution {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "starts here").help(
            "write `${properties.name}`, `${VARIABLE}` or `${VARIABLE:-default}`; write a dollar sign as `$$`",
        )
    }
}
