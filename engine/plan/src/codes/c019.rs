use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Password in the file
///
/// A password in the file is visible to everyone who can read the file or its version history. Refer to
/// a file that holds it through an environment variable instead.
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
/// Corrected:
///
/// ```toml corrected
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
#[error("{what} in the file")]
pub(crate) struct SecretInFile {
    /// `password` or `token`.
    pub what: &'static str,
    /// Environment variable for the name of a file that holds the secret.
    pub variable: &'static str,
    pub at: Span,
}

impl Finding for SecretInFile {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let help = format!(
            "store it in a file, and refer to the file with a variable: `${{{}}}`",
            self.variable
        );
        diagnostic
            .label(self.at, "visible to everyone who can read the file")
            .help(help)
    }
}
