//! Ends of connections and wires in a plan.

use asmotion_coordinator::BoundOperation;

/// A port, service or reference of a component; displayed as `Component.name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct End {
    /// Component name, qualified by the enclosing composites.
    pub component: String,
    /// Port, service or reference name.
    pub name: String,
}

/// One end of a connection; displayed as `Component.port`, `topic:name` or `mqueue:/name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Terminal {
    /// A port of a component.
    Port(End),
    /// A topic name.
    Topic(String),
    /// A POSIX message queue shared with an Orocos component.
    Mqueue(String),
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.component, self.name)
    }
}

/// The component of the end is a service or reference, its name an operation.
impl From<End> for BoundOperation {
    fn from(end: End) -> Self {
        Self {
            service: end.component,
            operation: end.name,
        }
    }
}

impl std::fmt::Display for Terminal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Port(end) => end.fmt(f),
            Self::Topic(topic) => write!(f, "topic:{topic}"),
            Self::Mqueue(name) => write!(f, "mqueue:{name}"),
        }
    }
}
