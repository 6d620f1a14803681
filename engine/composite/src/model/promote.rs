//! Promotions: ports, services and properties visible outside the composite.

use asmotion_derive::Table;
use asmotion_diagnostics::Span;

use super::instances::Instances;
use super::limits::DAY_MS;
use super::wiring::End;
use super::wiring::Transport;
use crate::at::At;

/// An element visible outside the composite.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a promotion",
    example = "{ service = \"Planner.planning\", as = \"planning\" }"
)]
pub struct Promotion {
    /// Source location of the promotion.
    pub span: Span,
    /// Instances: one element for each value of a variable, which is substituted in its names and strings, as in
    /// `"R$r.scan"`. A string that is only the variable becomes its value.
    #[key(name = "for", example = "\"$r in 1..20\"")]
    pub instances: Option<Instances>,
    /// Promoted element.
    #[key(flatten)]
    pub what: Promoted,
    /// Public name.
    #[key(name = "as", example = "\"planning\"", form = topic)]
    pub name: At<String>,
    /// Profiles that include it; all if empty.
    #[key(name = "profile", example = "\"sim\"")]
    pub profiles: Vec<At<String>>,
    /// Additional transports for access from outside.
    #[key(name = "binding")]
    pub bindings: Vec<At<Transport>>,
    /// Broker; required if there are several.
    #[key(example = "\"main\"")]
    pub broker: Option<At<String>>,
    /// Gateway; required if there are several.
    #[key(example = "\"main\"")]
    pub gateway: Option<At<String>>,
    /// Default timeout of calls through a gateway.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub timeout_ms: Option<At<u64>>,
    /// Whether a reference may remain unconnected.
    pub optional: bool,
}

/// A promoted element.
#[derive(Clone, Debug, Table)]
#[table(of = "a promotion", reason = "write a promotion for each")]
pub enum Promoted {
    /// Service of a component.
    #[key(example = "\"Component.name\"")]
    Service(End),
    /// Reference of a component.
    #[key(example = "\"Component.name\"")]
    Reference(End),
    /// Property of a component.
    #[key(example = "\"Component.name\"")]
    Property(End),
    /// Port of a component.
    #[key(example = "\"Component.name\"")]
    Port(End),
    /// Topic of the composite.
    #[key(example = "\"plan\"", form = topic)]
    Topic(At<String>),
}

impl Promotion {
    /// Returns the location of the binding to this transport; `None` if there is none.
    pub fn over(&self, transport: Transport) -> Option<&At<Transport>> {
        let mut bindings = self.bindings.iter();
        bindings.find(|binding| binding.value == transport)
    }
}

impl Promoted {
    /// The end that is promoted; `None` for a topic.
    pub fn end(&self) -> Option<&End> {
        match self {
            Self::Service(end) | Self::Reference(end) | Self::Property(end) | Self::Port(end) => {
                Some(end)
            }
            Self::Topic(_) => None,
        }
    }

    /// Returns the key that names the element, such as `service`.
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
