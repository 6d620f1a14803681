use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Listed type differs from the declaration
///
/// The composite lists another type or interface than the component declares.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/PlanService" }
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
#[code(C027, error)]
#[error("mismatched types: {what} `{name}` of `{implementation}` is `{declared}`, not `{written}`")]
pub(crate) struct DeclarationDiffers {
    pub implementation: String,
    pub what: &'static str,
    pub name: String,
    pub declared: String,
    pub written: String,
    pub at: Span,
    pub made_of: Span,
}

impl Finding for DeclarationDiffers {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { declared, .. } = self;
        diagnostic
            .label(self.at, "listed here")
            .label(
                self.made_of,
                format!("declared as `{declared}` by the component"),
            )
            .fix("write the declared type", self.at, declared)
    }
}
