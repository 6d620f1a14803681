//! What can be wrong with a connection.

use asmotion_diagnostics::{Diagnostic, Span};

use super::face::Kind;
use crate::finding::Finding;
use crate::model::Flow;

#[derive(Debug, thiserror::Error)]
pub(crate) enum ConnectionError {
    #[error("`{end}` is an {is}, so a connection cannot {use_} it")]
    Direction {
        end: String,
        is: &'static str,
        use_: &'static str,
        at: Span,
        declared: Option<Span>,
    },
    #[error("a connection from {from} to {to} joins no component")]
    Relay {
        from: &'static str,
        from_at: Span,
        to: &'static str,
        to_at: Span,
    },
    #[error("`{from}` is `{}`, but `{to}` is `{}`", from_kind.text, to_kind.text)]
    Types {
        from: String,
        from_kind: Kind,
        from_at: Span,
        to: String,
        to_kind: Kind,
        to_at: Span,
    },
    #[error("`{port}` keeps the last value, and two write it")]
    TwoWriters { port: String, at: Span, first: Span },
    #[error("`{from}` and `{to}` are joined twice")]
    Twice {
        from: String,
        to: String,
        at: Span,
        first: Span,
    },
    #[error("a connection of type `{kind}` needs a `size`")]
    NoSize { kind: Flow, at: Span },
    #[error("nothing is connected to input `{component}.{port}`")]
    Undriven {
        component: String,
        port: String,
        kind: String,
        nested: bool,
        at: Span,
    },
    #[error("`{component}` also has the input `{port}`, which the composite leaves open")]
    Open {
        component: String,
        port: String,
        kind: String,
        at: Span,
    },
    #[error("`lock = \"unsync\"` needs both ends in one thread")]
    Threads {
        from: String,
        to: String,
        at: Span,
        ends: Span,
    },
    #[error("{threads} threads would use a connection that allows {max}")]
    Crowded {
        threads: i64,
        max: i64,
        at: Span,
        ends: Span,
    },
    #[error("`{key}` says nothing here")]
    Idle {
        key: &'static str,
        at: Span,
        reason: &'static str,
    },
}

impl Finding for ConnectionError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Direction {
                is,
                use_,
                at,
                declared,
                ..
            } => {
                let diagnostic = Diagnostic::error("C040", self)
                    .label(*at, format!("cannot {use_} an {is}"))
                    .help("a connection goes `from` an output `to` an input");
                match declared {
                    Some(declared) => diagnostic.label(*declared, "declared here"),
                    None => diagnostic,
                }
            }
            Self::Relay {
                from,
                from_at,
                to,
                to_at,
            } => Diagnostic::error("C041", self)
                .label(*to_at, *to)
                .label(
                    *from_at,
                    format!("{from}{}", if from == to { ", too" } else { "" }),
                )
                .help(match (*from, *to) {
                    ("a topic", "a topic") => {
                        "rename the topic where it is published or subscribed"
                    }
                    _ => "put a component between, or join the port itself to the message queue",
                }),
            Self::Types {
                from_kind,
                from_at,
                to_kind,
                to_at,
                ..
            } => {
                let mut diagnostic = Diagnostic::error("C042", self)
                    .label(*to_at, format!("takes `{}`", to_kind.text))
                    .label(*from_at, format!("gives `{}`", from_kind.text))
                    .help("connect ends of one type, or put a component between that converts");
                for place in [from_kind.at, to_kind.at].into_iter().flatten() {
                    diagnostic = diagnostic.label(place, "declared here");
                }
                diagnostic
            }
            Self::TwoWriters { at, first, .. } => Diagnostic::error("C043", self)
                .label(*at, "the second writer")
                .label(*first, "the first writer")
                .help("queue both with `type = \"buffer\"` and a `size`, or leave one out"),
            Self::Twice { at, first, .. } => Diagnostic::error("C049", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help("leave one of the two out"),
            Self::NoSize { kind, at } => Diagnostic::error("C044", self)
                .label(*at, "how long is the queue?")
                .help(format!(
                    "for example `policy = {{ type = \"{kind}\", size = 16 }}`"
                )),
            Self::Undriven {
                component,
                port,
                kind,
                nested,
                at,
            } => {
                let or = match nested {
                    true => "",
                    false => ", or move it to `subscribe`",
                };
                let help =
                    format!("connect an output of type `{kind}` to `{component}.{port}`{or}");
                Diagnostic::error("C045", self)
                    .label(*at, "would never see a message")
                    .help(help)
            }
            Self::Open {
                component,
                port,
                kind,
                at,
            } => Diagnostic::warning("C046", self)
                .label(*at, "would never see a message there")
                .help(format!(
                    "connect an output of type `{kind}` to `{component}.{port}`"
                )),
            Self::Threads { from, to, at, ends } => Diagnostic::error("C047", self)
                .label(*at, "not safe here")
                .label(*ends, "two threads meet")
                .help(format!(
                    "use `lock_free`, or cycle one after the other: `activity.master` of `{to}` \
                     or `{from}`"
                )),
            Self::Crowded {
                threads, at, ends, ..
            } => Diagnostic::error("C058", self)
                .label(*at, "too few")
                .label(*ends, "read in a thread of its own")
                .help(format!(
                    "allow {threads}, or leave `max_threads` out: no connection of ours needs it"
                )),
            Self::Idle { at, reason, .. } => Diagnostic::warning("C048", self)
                .label(*at, *reason)
                .help("leave it out"),
        }
    }
}
