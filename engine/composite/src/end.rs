//! Ends of connections and wires, as components have them.

/// The end of a connection or wire; shown as `Component.name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct End {
    /// The component.
    pub component: String,
    /// Its port, service or reference.
    pub name: String,
}

/// One end of a connection; shown as `Component.port`, `topic:name` or `mqueue:/name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Terminal {
    /// A port.
    Port(End),
    /// A topic.
    Topic(String),
    /// A message queue, beyond which there is an Orocos component.
    Mqueue(String),
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.component, self.name)
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
