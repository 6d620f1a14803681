//! Promotion: what the outside sees.

use source::Span;

use super::End;
use super::wiring::Transport;
use crate::At;

/// `[[promote]]`.
#[derive(Clone, Debug)]
pub struct Promotion {
    /// The place of the promotion.
    pub span: Span,
    /// In which profiles; everywhere where empty.
    pub profiles: Vec<At<String>>,
    /// What is promoted.
    pub what: Promoted,
    /// Under which name.
    pub name: At<String>,
    /// Over what the outside reaches it.
    pub binding: Option<At<Transport>>,
    /// Over which broker, if there are several.
    pub broker: Option<At<String>>,
    /// Whether a reference may stay without a service.
    pub optional: bool,
}

/// What is promoted.
#[derive(Clone, Debug)]
pub enum Promoted {
    /// A service of a component.
    Service(End),
    /// A reference of a component.
    Reference(End),
    /// A property of a component.
    Property(End),
    /// A port of a component.
    Port(End),
    /// A topic.
    Topic(At<String>),
}

impl Promoted {
    /// The key of the dialect that names it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Service(_) => "service",
            Self::Reference(_) => "reference",
            Self::Property(_) => "property",
            Self::Port(_) => "port",
            Self::Topic(_) => "topic",
        }
    }
}
