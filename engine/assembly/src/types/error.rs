//! What can be wrong with a type.

use asmotion_diagnostics::{Diagnostic, Span};

use super::build::{MAX_DEPTH, MAX_FIELDS};
use crate::finding::Finding;
use crate::nearest::{Nearest, Suggest, nearest_name};
use crate::read::error::has;

#[derive(Debug, thiserror::Error)]
pub(crate) enum TypeError {
    #[error("`{name}` is no type")]
    Unknown {
        name: String,
        at: Span,
        nearest: Option<Nearest>,
    },
    #[error("`{name}` contains itself")]
    Recursive { name: String, at: Span },
    #[error(
        "the types of this composite have more than {MAX_FIELDS} fields, or nest deeper than {MAX_DEPTH}"
    )]
    TooLarge { at: Span },
    #[error("`{name}` is described twice, and differently: {difference}")]
    Twice {
        name: String,
        at: Span,
        first: Span,
        difference: String,
    },
    #[error("`{name}` looks otherwise in this build: {difference}")]
    Differs {
        name: String,
        at: Span,
        difference: String,
    },
    #[error("`{name}` is a type that this build does not know")]
    NotInBuild {
        name: String,
        at: Span,
        nearest: Option<Nearest>,
    },
    #[error("`{name}` has no field `{field}`")]
    NoField {
        name: String,
        field: String,
        at: Span,
        known: Vec<String>,
        declared: Option<Span>,
    },
}

impl Finding for TypeError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Unknown { at, nearest, .. } => Diagnostic::error("C110", self)
                .label(
                    *at,
                    "not described in any file of `types`, nor known to this build",
                )
                .suggest_or(
                    *at,
                    nearest,
                    "for example `f64`, `u16[5]`, `string`, `time`, `geometry_msgs/Pose[]`",
                ),
            Self::Recursive { at, .. } => Diagnostic::error("C111", self)
                .label(*at, "so no message of this type ever ends")
                .help("name the inner one by a number or a text instead"),
            Self::TooLarge { at } => Diagnostic::error("C116", self)
                .label(*at, "given up here")
                .help("send what is that large as bytes, or by name"),
            Self::Twice { at, first, .. } => Diagnostic::error("C112", self)
                .label(*at, "described again here")
                .label(*first, "described here")
                .help("leave one of the two out"),
            Self::Differs { at, .. } => Diagnostic::error("C113", self)
                .label(*at, "described here")
                .help("leave the description out: the build knows the type"),
            Self::NotInBuild { at, nearest, .. } => Diagnostic::warning("C114", self)
                .label(*at, "its fields cannot be checked")
                .help("describe it in a file under `composite.types`")
                .suggest(*at, nearest),
            Self::NoField {
                field,
                at,
                known,
                declared,
                ..
            } => {
                let nearest = nearest_name(field, known.iter().map(String::as_str));
                let known = known.iter().map(String::as_str);
                let diagnostic = Diagnostic::error("C115", self).label(*at, "no such field");
                let diagnostic = match declared {
                    Some(declared) => diagnostic.label(*declared, "the type is described here"),
                    None => diagnostic,
                };
                diagnostic.suggest_or(*at, &nearest, has("fields", known))
            }
        }
    }
}
