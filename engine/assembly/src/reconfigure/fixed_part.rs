//! Differences that require a restart.

/// A difference between two plans that requires a restart.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FixedPart {
    /// A table of the composite.
    #[error("{0} of the composite")]
    Table(&'static str),
    /// A message type or service interface whose definition in a folder of a bridge has changed.
    #[error("the definition of `{0}`")]
    Definition(String),
    /// A new component that runs in the thread of another one.
    #[error(
        "`{component}` is new and runs in the thread of `{master}`; without `master` it can be added"
    )]
    Slave {
        /// Name of the component.
        component: String,
        /// Name of the other component.
        master: String,
    },
    /// A new or removed component that is connected when its process starts.
    #[error(
        "`{component}` is {change}, and the built-in `{builtin}` is connected when its process starts: start the process again"
    )]
    Builtin {
        /// Name of the component.
        component: String,
        /// Name of the built-in.
        builtin: String,
        /// `new` or `removed`.
        change: &'static str,
    },
    /// A component that differs in more than can be changed at run time.
    #[error("`{component}` differs in {difference}; only {changeable} can change while it runs")]
    Component {
        /// Name of the component.
        component: String,
        /// The first difference.
        difference: String,
        /// Parts of a component that can change at run time.
        changeable: &'static str,
    },
    /// A connection of a message queue.
    #[error(
        "the connection from `{from}` to `{to}` uses a message queue, which is opened when the process starts"
    )]
    Connection {
        /// Writing end.
        from: String,
        /// Reading end.
        to: String,
    },
    /// A connection over a bus, to a topic or to a port of another process, that needs another queue there.
    #[error(
        "the connection from `{from}` to `{to}` needs another queue at the broker: remove it, and add it with its new policy in a \
         second step"
    )]
    Policy {
        /// Writing end.
        from: String,
        /// Reading end.
        to: String,
    },
    /// A wire over a broker to which the process is not connected.
    #[error(
        "the wire of `{reference}` to `{service}` leads over a broker to which the process was not connected when it started"
    )]
    Wire {
        /// Reference of the wire.
        reference: String,
        /// Service of the wire.
        service: String,
    },
}
