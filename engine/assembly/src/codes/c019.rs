use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A password that stands in the file
///
/// Whoever has the file has the password, and so has everybody who sees its history. Name a file that holds
/// it, by a variable.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [brokers.main]
/// url = "amqp://robot:topsecret@10.0.0.5:5672"
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
/// [brokers.main]
/// url = "amqp://robot:${AMQP_PASSWORD_FILE}@10.0.0.5:5672"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C019, warning)]
#[error("a password stands in the file")]
pub(crate) struct SecretInFile {
    pub at: Span,
}

impl Finding for SecretInFile {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "everybody who has the file has it")
            .help("name a file with it in a variable: `${AMQP_PASSWORD_FILE}`")
    }
}
