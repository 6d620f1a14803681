//! What can be wrong with a value.

use std::net::SocketAddr;

use asmotion_diagnostics::{Diagnostic, Span};

use super::Range;
use crate::environment::is_secret;
use crate::finding::Finding;
use crate::nearest::{Nearest, Suggest};

#[derive(Debug, thiserror::Error)]
pub(crate) enum SettingError {
    #[error("the composite has no property `{name}`")]
    Unknown {
        name: String,
        at: Option<Span>,
        nearest: Option<Nearest>,
    },
    #[error("the environment variable `{name}` is not set here")]
    NotSet { name: String, at: Span },
    #[error("`{path}`, which `{name}` names, cannot be read: {reason}")]
    NoSecret {
        name: String,
        path: String,
        reason: String,
        at: Span,
    },
    #[error("`{name}` takes {wanted}, not {found}")]
    WrongType {
        name: String,
        wanted: String,
        found: &'static str,
        at: Option<Span>,
        declared: Option<Span>,
    },
    #[error("`{name}` is {value}, but must lie in {range}")]
    OutOfRange {
        name: String,
        value: String,
        range: Range,
        at: Option<Span>,
        declared: Option<Span>,
    },
    #[error("the property `{name}` must be set")]
    MustBeSet { name: String, at: Span },
    #[error("a password stands in the file")]
    SecretInFile { at: Span },
    #[error("gateway `{name}` cannot listen at `{text}`")]
    NoAddress {
        name: String,
        text: String,
        at: Span,
    },
    #[error("two gateways listen at {address}")]
    SameAddress {
        address: SocketAddr,
        at: Span,
        first: Span,
    },
}

impl Finding for SettingError {
    fn is_outside(&self) -> bool {
        match self {
            Self::Unknown { at, .. } | Self::WrongType { at, .. } | Self::OutOfRange { at, .. } => {
                at.is_none()
            }
            Self::NotSet { .. }
            | Self::NoSecret { .. }
            | Self::MustBeSet { .. }
            | Self::SecretInFile { .. }
            | Self::NoAddress { .. }
            | Self::SameAddress { .. } => false,
        }
    }

    fn diagnostic(&self) -> Diagnostic {
        let label = |diagnostic: Diagnostic, at: &Option<Span>, text: String| match at {
            Some(at) => diagnostic.label(*at, text),
            None => diagnostic.note("set from outside the file"),
        };
        match self {
            Self::Unknown { at, nearest, .. } => {
                let diagnostic = label(
                    Diagnostic::error("C013", self),
                    at,
                    "no such property".into(),
                );
                match (at, nearest) {
                    (Some(at), nearest) => diagnostic.suggest(*at, nearest),
                    (None, Some(nearest)) => {
                        diagnostic.help(format!("did you mean `{}`?", nearest.name))
                    }
                    (None, None) => diagnostic.help("`[properties]` of the composite lists them"),
                }
            }
            Self::NotSet { name, at } => {
                let help = match (name.ends_with("_FILE"), is_secret(name)) {
                    (true, _) => "set it to the path of the file that holds the secret".to_owned(),
                    (false, true) => "set it before the start".to_owned(),
                    (false, false) => format!("set it, or give a default: `${{{name}:-default}}`"),
                };
                Diagnostic::warning("C014", self)
                    .label(*at, "needed to start")
                    .help(help)
            }
            Self::NoSecret { at, .. } => {
                Diagnostic::warning("C014", self).label(*at, "needed to start")
            }
            Self::WrongType {
                wanted,
                at,
                declared,
                ..
            } => {
                let diagnostic = label(
                    Diagnostic::error("C015", self),
                    at,
                    format!("expected {wanted}"),
                );
                let diagnostic = diagnostic.help(format!("give it {wanted}"));
                match declared {
                    Some(declared) => diagnostic.label(*declared, "declared here"),
                    None => diagnostic,
                }
            }
            Self::OutOfRange {
                range,
                at,
                declared,
                ..
            } => {
                let diagnostic = label(
                    Diagnostic::error("C016", self),
                    at,
                    "out of range".to_owned(),
                )
                .help(format!("take a value in {range}"));
                match declared {
                    Some(declared) => diagnostic.label(*declared, "the range is declared here"),
                    None => diagnostic,
                }
            }
            Self::MustBeSet { name, at } => Diagnostic::error("C017", self)
                .label(*at, "has no default")
                .help(format!("give it a `default`, or set `{name}` from outside")),
            Self::SecretInFile { at } => Diagnostic::warning("C019", self)
                .label(*at, "everybody who has the file has it")
                .help("name a file with it in a variable: `${AMQP_PASSWORD_FILE}`"),
            Self::NoAddress { at, .. } => Diagnostic::error("C064", self)
                .label(*at, "not an address and a port")
                .help(
                    "write `127.0.0.1:8080` for this machine alone, `0.0.0.0:8080` for every network, \
                     port 0 for a free one",
                ),
            Self::SameAddress { at, first, .. } => Diagnostic::error("C065", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help("give one of them another port, or promote everything through one"),
        }
    }
}
