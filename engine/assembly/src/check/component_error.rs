//! What can be wrong with a component.

use asmotion_diagnostics::{Diagnostic, Span};

use super::face::Named;
use crate::finding::Finding;
use crate::nearest::{Nearest, Suggest, nearest, nearest_name};
use crate::read::error::has;

#[derive(Debug, thiserror::Error)]
pub(crate) enum ComponentError {
    #[error("`{component}` has two {way}s `{name}`")]
    PortTwice {
        way: &'static str,
        component: String,
        name: String,
        at: Span,
        first: Span,
    },
    #[error("two components have the id `{id}`")]
    SameId { id: String, at: Span, first: Span },
    #[error("`{component}` would cycle after itself")]
    OwnMaster { component: String, at: Span },
    #[error("this build has no {what} `{name}`")]
    UnknownImplementation {
        what: &'static str,
        name: String,
        at: Span,
        nearest: Option<Nearest>,
    },
    #[error("{what} `{name}` is not in this build")]
    NotInBuild {
        what: &'static str,
        name: String,
        at: Span,
    },
    #[error("`{implementation}` has no {what} `{name}`")]
    NotDeclared {
        implementation: String,
        what: &'static str,
        name: String,
        at: Span,
        made_of: Span,
        known: Vec<String>,
    },
    #[error("{what} `{name}` of `{implementation}` is `{declared}`, not `{written}`")]
    DeclaredOtherwise {
        implementation: String,
        what: &'static str,
        name: String,
        declared: String,
        written: String,
        at: Span,
        made_of: Span,
    },
    #[error("`{component}` has no property `{name}`")]
    UnknownProperty {
        component: String,
        name: String,
        at: Span,
        made_of: Span,
        known: Vec<Named>,
    },
    #[error("`{implementation}` has no input `{name}`, so nobody reads what comes there")]
    NeverRead {
        implementation: String,
        name: String,
        at: Span,
        made_of: Span,
        known: Vec<String>,
    },
}

impl Finding for ComponentError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::PortTwice { at, first, .. } => Diagnostic::error("C018", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help("`ports.in` and `subscribe` share one set of names, and so do `ports.out` and `publish`"),
            Self::SameId { at, first, .. } => Diagnostic::error("C023", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help("the id names the component's queue, log and metrics; without `task.id` it is the component's name"),
            Self::OwnMaster { at, .. } => Diagnostic::error("C035", self)
                .label(*at, "leads back to it")
                .help("leave `master` out of one of them: it drives the others"),
            Self::UnknownImplementation { at, nearest, .. } => Diagnostic::error("C024", self)
                .label(*at, "not known")
                .suggest(*at, nearest),
            Self::NotInBuild { at, .. } => Diagnostic::warning("C025", self)
                .label(*at, "what the composite says of it is believed")
                .note("the composite can be checked, but not started here"),
            Self::NotDeclared { name, what, at, made_of, known, .. } => {
                Diagnostic::error("C026", self)
                    .label(*at, "not declared by the component")
                    .label(*made_of, "the component")
                    .suggest_or(
                        *at,
                        &nearest_name(name, known.iter().map(String::as_str)),
                        has(what, known.iter().map(String::as_str)),
                    )
            }
            Self::DeclaredOtherwise { declared, at, made_of, .. } => {
                Diagnostic::error("C027", self)
                    .label(*at, "written here")
                    .label(*made_of, format!("the component declares `{declared}`"))
                    .fix("write what the component declares", *at, declared)
            }
            Self::UnknownProperty { name, at, made_of, known, .. } => {
                let names = known.iter().map(|it| it.text.as_str());
                let all = known.iter().map(|it| (it.text.as_str(), it.at));
                Diagnostic::error("C028", self)
                    .label(*at, "no such property")
                    .label(*made_of, "the component")
                    .suggest_or(*at, &nearest(name, all), has("property", names))
            }
            Self::NeverRead { at, made_of, known, .. } => Diagnostic::warning("C029", self)
                .label(*at, "never read")
                .label(*made_of, "the component")
                .help(has("input", known.iter().map(String::as_str))),
        }
    }
}
