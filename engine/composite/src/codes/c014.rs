use crate::environment::is_secret;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing environment variable or secret
///
/// The composite can be checked without it, but not started. A variable whose name ends in `_FILE`
/// holds the path of a file with a secret.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [brokers.main]
/// url = "amqp://guest:guest@${EXAMPLE_HOST}:5672"
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
/// url = "amqp://guest:guest@${EXAMPLE_HOST:-localhost}:5672"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C014, warning)]
pub(crate) enum UnsetVariable {
    #[error("environment variable `{name}` is not set")]
    NotSet { name: String, at: Span },
    #[error("cannot read `{path}`, the value of `{name}`: {reason}")]
    NoSecret {
        name: String,
        path: String,
        reason: String,
        at: Span,
    },
}

impl Finding for UnsetVariable {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self {
            Self::NotSet { name, at } => {
                let help = match (name.ends_with("_FILE"), is_secret(name)) {
                    (true, _) => "set it to the path of the file with the secret".to_owned(),
                    (false, true) => "set it before the start".to_owned(),
                    (false, false) => format!("set it, or write a default: `${{{name}:-default}}`"),
                };
                diagnostic.label(*at, "required at start").help(help)
            }
            Self::NoSecret { at, .. } => diagnostic.label(*at, "required at start"),
        }
    }
}
