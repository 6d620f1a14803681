//! The route from a writer to its reader, or from a caller to its service: inside a process, where real time holds, or
//! over a transport that is not suited to real time.

use std::fmt;

use crate::joint::{Connection, Topic};
use crate::plan::{End, Plan, Terminal, Wire};
use asmotion_composite::model::{Lock, Transport};

/// The route from a writer to its reader, or from a caller to its service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConnectionRoute {
    /// Writer or caller.
    pub from: Terminal,
    /// Reader or service.
    pub to: RouteEnd,
    /// Topic of the route; `None` for connections and wires.
    pub topic: Option<String>,
    /// Transport between both ends.
    pub over: RouteTransport,
}

/// Reader or service at the end of a route.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RouteEnd {
    /// A port, service, topic or message queue of the system.
    Inside(Terminal),
    /// The URL of a service of another system or robot.
    Url(String),
}

/// Transport between a writer and its reader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RouteTransport {
    /// Shared memory within a process.
    Nothing(Lock),
    /// A POSIX message queue.
    Mqueue,
    /// A broker; `None` if the composite does not name it.
    Broker(Option<String>),
    /// Another middleware.
    Other(Transport),
}

impl Plan {
    /// Returns all routes of the deployed system: connections, topics, then wires.
    pub fn connection_routes(&self) -> Vec<ConnectionRoute> {
        let connections = self
            .connections
            .iter()
            .filter_map(|it| self.route_of_connection(it));
        let topics = self.topics.iter().flat_map(|it| self.routes_of_topic(it));
        let wires = self.wires.iter().flat_map(|it| self.routes_of_wire(it));
        connections.chain(topics).chain(wires).collect()
    }

    /// Returns `None` for a topic, whose routes depend on all its publishers and subscribers.
    fn route_of_connection(&self, connection: &Connection) -> Option<ConnectionRoute> {
        let over = match (&connection.from, &connection.to) {
            (Terminal::Port(from), Terminal::Port(to)) => {
                self.between(from, to, connection.policy.lock)
            }
            (Terminal::Mqueue(_), _) | (_, Terminal::Mqueue(_)) => RouteTransport::Mqueue,
            (Terminal::Topic(_), _) | (_, Terminal::Topic(_)) => return None,
        };
        Some(ConnectionRoute {
            from: connection.from.clone(),
            to: RouteEnd::Inside(connection.to.clone()),
            topic: None,
            over,
        })
    }

    fn routes_of_topic<'p>(
        &'p self,
        topic: &'p Topic,
    ) -> impl Iterator<Item = ConnectionRoute> + 'p {
        let route = |from: &End, to: &End| ConnectionRoute {
            from: Terminal::Port(from.clone()),
            to: RouteEnd::Inside(Terminal::Port(to.clone())),
            topic: Some(topic.name.clone()),
            over: self.between(from, to, self.lock_of(topic, to)),
        };
        let from = topic.publishers.iter();
        from.flat_map(move |from| topic.subscribers.iter().map(move |to| route(from, to)))
    }

    fn routes_of_wire<'p>(&'p self, wire: &'p Wire) -> impl Iterator<Item = ConnectionRoute> + 'p {
        let route = |to: RouteEnd, over| ConnectionRoute {
            from: Terminal::Port(wire.reference.clone()),
            to,
            topic: None,
            over,
        };
        let inside = wire.services.iter().map(move |to| {
            let over = match wire.binding {
                // requests to a component's inbox are lock-free
                Transport::Local => self.between(&wire.reference, to, Lock::LockFree),
                Transport::Amqp => {
                    RouteTransport::Broker(self.broker_of_wire(wire).map(str::to_owned))
                }
                other @ (Transport::Ros | Transport::Http) => RouteTransport::Other(other),
            };
            route(RouteEnd::Inside(Terminal::Port(to.clone())), over)
        });
        let outside = wire.url.iter().map(move |url| {
            let over = match wire.binding {
                Transport::Amqp => {
                    RouteTransport::Broker(self.broker_of_wire(wire).map(str::to_owned))
                }
                other @ (Transport::Local | Transport::Ros | Transport::Http) => {
                    RouteTransport::Other(other)
                }
            };
            route(RouteEnd::Url(url.shown().to_owned()), over)
        });
        inside.chain(outside)
    }

    fn between(&self, from: &End, to: &End, lock: Lock) -> RouteTransport {
        let process = |end: &End| self.process_of(&end.component).map(|it| &it.name);
        if process(from) == process(to) {
            RouteTransport::Nothing(lock)
        } else {
            RouteTransport::Broker(self.broker_of(&from.component).map(str::to_owned))
        }
    }

    /// Returns the synchronisation between a reader of a topic and its writers.
    fn lock_of(&self, topic: &Topic, reader: &End) -> Lock {
        let [from, to] = [
            Terminal::Topic(topic.name.clone()),
            Terminal::Port(reader.clone()),
        ];
        let mut connections = self.connections.to_end(&to);
        let connection = connections.find(|it| it.from == from);
        connection.map_or_else(Lock::default, |it| it.policy.lock)
    }
}

impl ConnectionRoute {
    /// Returns the ends that are ports, services or references.
    pub fn ends(&self) -> impl Iterator<Item = &End> {
        let to = match &self.to {
            RouteEnd::Inside(terminal) => Some(terminal),
            RouteEnd::Url(_) => None,
        };
        let both = std::iter::once(&self.from).chain(to);
        both.filter_map(|terminal| match terminal {
            Terminal::Port(end) => Some(end),
            Terminal::Topic(_) | Terminal::Mqueue(_) => None,
        })
    }
}

impl RouteTransport {
    /// Returns whether the transport is shared memory without locks, as required for real time.
    pub fn is_real_time(&self) -> bool {
        match self {
            Self::Nothing(Lock::LockFree | Lock::Unsync) => true,
            Self::Nothing(Lock::Locked) | Self::Mqueue | Self::Broker(_) | Self::Other(_) => false,
        }
    }
}

impl fmt::Display for RouteEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inside(terminal) => terminal.fmt(f),
            Self::Url(url) => f.write_str(url),
        }
    }
}

impl fmt::Display for RouteTransport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing(Lock::LockFree) => f.write_str("in process, lock-free"),
            Self::Nothing(Lock::Locked) => f.write_str("in process, locked"),
            Self::Nothing(Lock::Unsync) => f.write_str("in process, one thread"),
            Self::Mqueue => f.write_str("over a message queue"),
            Self::Broker(Some(name)) => write!(f, "over the broker `{name}`"),
            Self::Broker(None) => f.write_str("over the broker"),
            Self::Other(transport) => write!(f, "over {transport}"),
        }
    }
}
