//! Promotion: what the outside sees.

use asmotion_diagnostics::Span;

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
    /// Over what the outside reaches it, beside the wires of an outer composite.
    pub bindings: Vec<At<Transport>>,
    /// Over which broker, if there are several.
    pub broker: Option<At<String>>,
    /// Through which gateway, if there are several.
    pub gateway: Option<At<String>>,
    /// How long a call through a gateway may take whose caller does not say.
    pub timeout_ms: Option<At<i64>>,
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

impl Promotion {
    /// Where it says that the outside reaches it over this.
    pub fn over(&self, transport: Transport) -> Option<&At<Transport>> {
        let mut bindings = self.bindings.iter();
        bindings.find(|binding| binding.value == transport)
    }
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
