//! What can be wrong with the map of a built-in.

use asmotion_diagnostics::{Diagnostic, Span};

use crate::finding::Finding;
use crate::model::ProxyMode;

#[derive(Debug, thiserror::Error)]
pub(crate) enum MapError {
    #[error(
        "an operation with `mode = \"{mode}\"` needs an {wanted} of the target, and `{port}` is an {found}"
    )]
    Direction {
        mode: ProxyMode,
        wanted: &'static str,
        found: &'static str,
        port: String,
        at: Span,
        declared: Option<Span>,
    },
    #[error("`{port}` is no port of the target `{target}`")]
    Elsewhere {
        port: String,
        target: String,
        at: Span,
        target_at: Span,
    },
    #[error("{what} of `{operation}` is no {wanted}")]
    Shapes {
        what: &'static str,
        operation: String,
        wanted: String,
        here: String,
        there: String,
        at: Span,
        declared: Option<Span>,
    },
    #[error("{reason}")]
    Condition {
        reason: String,
        found: String,
        at: Span,
        declared: Option<Span>,
    },
    #[error("`mode = \"done\"` needs `notify.idle` to say when a motion by `{port}` has ended")]
    NoMotion {
        port: String,
        at: Span,
        idle: Option<Span>,
    },
    #[error("`stale_ms` needs a period: when nothing comes, nothing wakes `{component}`")]
    NoPace {
        component: String,
        at: Span,
        declared: Span,
    },
    #[error("`{name}` goes {direction}, so it must stand under `{list}`")]
    NotListed {
        name: String,
        direction: &'static str,
        list: &'static str,
        kind: String,
        at: Span,
    },
    #[error("`{name}` is `{here}` here and `{there}` there")]
    Types {
        name: String,
        here: String,
        there: String,
        at: Span,
        declared: Option<Span>,
    },
}

impl Finding for MapError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Direction {
                at,
                declared,
                found,
                ..
            } => {
                let diagnostic = Diagnostic::error("C120", self)
                    .label(*at, "named here")
                    .help("`oneway`, `taken` and `done` write to an input of the target, `last` and `all` read an output of it");
                match declared {
                    Some(declared) => diagnostic.label(*declared, format!("an {found}")),
                    None => diagnostic,
                }
            }
            Self::Elsewhere { at, target_at, .. } => Diagnostic::error("C121", self)
                .label(*at, "a port of another component")
                .label(*target_at, "the target")
                .help("name a port of the target, or make the other component the target of a proxy of its own"),
            Self::Shapes {
                here,
                there,
                at,
                declared,
                ..
            } => {
                let diagnostic = Diagnostic::error("C124", self)
                    .label(*at, here)
                    .help("give the fields of both the same names, or name the part of the message with `field`");
                match declared {
                    Some(declared) => diagnostic.label(*declared, there),
                    None => diagnostic,
                }
            }
            Self::Condition {
                found,
                at,
                declared,
                ..
            } => {
                let diagnostic = Diagnostic::error("C125", self)
                    .label(*at, found)
                    .help("write `port.new`, `port.flag`, or `port.field != 0` with one of == != < <= > >=");
                match declared {
                    Some(declared) => diagnostic.label(*declared, "described here"),
                    None => diagnostic,
                }
            }
            Self::NoMotion { port, at, idle } => {
                let diagnostic = Diagnostic::error("C126", self)
                    .label(*at, "nobody would ever reply")
                    .help(format!("write `notify.idle` with `of = \"{port}.…\"`, or use `mode = \"taken\"`"));
                match idle {
                    Some(idle) => diagnostic.label(*idle, "of another port"),
                    None => diagnostic,
                }
            }
            Self::NoPace { at, declared, .. } => Diagnostic::warning("C127", self)
                .label(*at, "nobody looks at the clock")
                .label(*declared, "cycles when something comes")
                .help("write `activity = { period_ms = 20 }`"),
            Self::NotListed {
                name,
                list,
                kind,
                at,
                ..
            } => Diagnostic::error("C122", self)
                .label(*at, format!("not under `{list}`"))
                .help(format!("add `{list} = {{ {name} = \"{kind}\" }}`")),
            Self::Types { at, declared, .. } => {
                let diagnostic = Diagnostic::error("C123", self).label(*at, "the type there");
                let diagnostic = match declared {
                    Some(declared) => diagnostic.label(*declared, "the type here"),
                    None => diagnostic,
                };
                diagnostic.help("name a converter with `convert`, or use one type on both sides")
            }
        }
    }
}
