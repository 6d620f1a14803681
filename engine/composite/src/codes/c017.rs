use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Required property not set
///
/// A property without a `default` must be given a value, either on the command line (`--set
/// place=office`) or by the enclosing composite.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [properties]
/// place = { type = "string" }
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
/// place = { type = "string", default = "office" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C017, error)]
#[error("missing value for property `{name}`")]
pub(crate) struct MissingSetting {
    pub name: String,
    pub at: Span,
}

impl Finding for MissingSetting {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { name, .. } = self;
        diagnostic
            .label(self.at, "has no default")
            .help(format!("add a `default`, or set `{name}` from outside"))
    }
}
