use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A reference that is neither wired nor promoted
///
/// A call over it would have nobody to answer. A reference that may stay open is declared `optional`.
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
/// Mended:
///
/// ```toml mended
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
/// Or wire it: `[[wires]]` with `reference` and `service`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C031, error)]
#[error("reference `{component}.{reference}` is neither wired nor promoted")]
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
                    .label(self.at, format!("who provides `{interface}`?"))
                    .help(format!(
                        "write `[[wires]]` with `reference = \"{component}.{reference}\"`, promote \
                         it, or say `{reference} = {{ interface = \"{interface}\", optional = true }}`"
                    ))
    }
}
