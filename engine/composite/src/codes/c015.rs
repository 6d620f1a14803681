use crate::wording::label_or_outside;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid property value
///
/// A value must match the type and the choices of its property. Components declare their own
/// properties; those of the composite are declared under `[properties]`.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [properties]
/// period_ms = { type = "u32", default = "often" }
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
/// period_ms = { type = "u32", default = 50 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C015, error)]
pub(crate) enum InvalidSetting {
    #[error("mismatched types: expected {wanted} for `{name}`, found {found}")]
    WrongType {
        name: String,
        wanted: String,
        found: &'static str,
        at: Option<Span>,
        declared: Option<Span>,
    },
    #[error("invalid value {value} for `{name}`")]
    NoChoice {
        name: String,
        value: String,
        choices: String,
        at: Option<Span>,
    },
    #[error("invalid value for `{name}`: {reason}")]
    Refused {
        name: String,
        reason: String,
        at: Option<Span>,
    },
}

impl Finding for InvalidSetting {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self {
            Self::WrongType {
                wanted,
                at,
                declared,
                ..
            } => {
                let diagnostic = label_or_outside(diagnostic, *at, &format!("expected {wanted}"))
                    .help(format!("write {wanted}"));
                match declared {
                    Some(declared) => diagnostic.label(*declared, "declared here"),
                    None => diagnostic,
                }
            }
            Self::Refused { name, at, .. } => {
                label_or_outside(diagnostic, *at, "refused by the component")
                    .help(format!("the README of the component describes `{name}`"))
            }
            Self::NoChoice { choices, at, .. } => {
                label_or_outside(diagnostic, *at, "not an option").help(format!("write {choices}"))
            }
        }
    }
}
