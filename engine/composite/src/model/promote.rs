//! Promotion: what the outside sees.

use asmotion_derive::Table;
use asmotion_diagnostics::Span;

use super::wiring::Transport;
use super::{DAY_MS, End};
use crate::at::At;

/// Something that the outside sees.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a promotion",
    example = "{ service = \"Planner.planning\", as = \"planning\" }"
)]
pub struct Promotion {
    /// The place of the promotion.
    pub span: Span,
    /// What is promoted.
    #[key(flatten)]
    pub what: Promoted,
    /// Its name outside.
    #[key(name = "as", example = "\"planning\"", form = topic)]
    pub name: At<String>,
    /// In which profiles; in all, if none is named.
    #[key(name = "profile", example = "\"sim\"")]
    pub profiles: Vec<At<String>>,
    /// Over what the outside reaches it, beside the wires of an outer composite.
    #[key(name = "binding")]
    pub bindings: Vec<At<Transport>>,
    /// Over which broker, if there are several.
    #[key(example = "\"main\"")]
    pub broker: Option<At<String>>,
    /// Through which gateway, if there are several.
    #[key(example = "\"main\"")]
    pub gateway: Option<At<String>>,
    /// Deadline of a call through a gateway whose caller sets none.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub timeout_ms: Option<At<u64>>,
    /// Whether a reference may stay without a service.
    pub optional: bool,
}

/// What is promoted.
#[derive(Clone, Debug, Table)]
#[table(of = "a promotion", reason = "write a promotion for each")]
pub enum Promoted {
    /// A service of a component.
    #[key(example = "\"Component.name\"")]
    Service(End),
    /// A reference of a component.
    #[key(example = "\"Component.name\"")]
    Reference(End),
    /// A property of a component.
    #[key(example = "\"Component.name\"")]
    Property(End),
    /// A port of a component.
    #[key(example = "\"Component.name\"")]
    Port(End),
    /// A topic.
    #[key(example = "\"plan\"", form = topic)]
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
