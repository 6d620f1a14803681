use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unconnected reference
///
/// A call through this reference has no service to answer it. Wire the reference with `[[wires]]`,
/// promote it, or declare it `optional`.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
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
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = { interface = "nav/MapService", optional = true } }
/// ```
///
/// The corrected example has an optional reference.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C031, error)]
#[error("unconnected reference `{component}.{reference}`")]
pub(crate) struct DanglingReference {
    pub component: String,
    pub reference: String,
    pub interface: String,
    pub at: Span,
}

impl Finding for DanglingReference {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            component,
            reference,
            interface,
            ..
        } = self;
        diagnostic
                    .label(self.at, format!("needs a service with the interface `{interface}`"))
                    .help(format!(
                        "add `[[wires]]` with `reference = \"{component}.{reference}\"`, promote the reference, or write `{reference} = {{ interface = \"{interface}\", optional = true }}`"
                    ))
    }
}
