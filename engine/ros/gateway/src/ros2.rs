//! Nodes of ROS 2.

use std::net::IpAddr;
use std::sync::Arc;
use std::time::Instant;

use asmotion_component::Losses;
use asmotion_datum::{Datum, Schema};
use asmotion_ros_interface::{Catalogue, InterfaceName};
use asmotion_ros2::{
    Durability, EndpointKind, Graph, Node, NodeOptions, Notice, Publisher, Qos, Received,
    Reliability, Subscription, SubscriptionOptions,
};

use crate::desk::ComponentWatch;
use crate::mapped::MappedTopic;
use crate::notices::Notices;
use crate::operation::{MappedOperation, OperationCaller, OperationSchemas, OperationServer};
use crate::operation_type::{OperationKind, OperationType};
use crate::ros2_components::Ros2Components;
use crate::ros2_memory::{Memories, TopicMemory};
use crate::ros2_operations::{
    Ros2GoalCaller, Ros2GoalServer, Ros2ServiceCaller, Ros2ServiceServer,
};
use crate::ros2_relays::{AnnouncedRelays, Circles};
use crate::shown::{ComponentDisplay, ShownComponent};
use crate::transport::{
    ConnectionState, MessageReceiver, MessageSender, RosConnection, RosMessage, RosTransport,
};
use crate::wake::{ArrivalFlag, CycleWakes, Wake};

/// Settings of a node of ROS 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ros2Settings {
    /// Name of the node with its namespace, such as `/robot/coordinator`. Relative names of topics are in the namespace.
    pub node: String,
    /// Domain id. Nodes of other domains are not seen.
    pub domain: u16,
    /// Addresses of the network interfaces that are used; all if empty.
    pub networks: Vec<IpAddr>,
    /// Topics whose messages the bridge brings to a topic of the composite that it sends to other topics, with those topics.
    pub relays: Vec<(String, String)>,
}

/// Reaches the nodes of a domain of DDS.
pub struct Ros2Transport {
    settings: Ros2Settings,
    catalogue: Arc<Catalogue>,
    memories: Memories,
}

impl Ros2Transport {
    /// Reaches the nodes of a domain, whose messages have these definitions.
    pub fn new(settings: Ros2Settings, catalogue: Arc<Catalogue>) -> Self {
        Self {
            settings,
            catalogue,
            memories: Memories::default(),
        }
    }
}

fn message(kind: &str) -> Result<InterfaceName, String> {
    kind.parse().map_err(|error| format!("{error}"))
}

impl RosTransport for Ros2Transport {
    fn schema(&self, kind: &str) -> Result<Schema, String> {
        let schema = self.catalogue.schema(&message(kind)?);
        schema.map_err(|error| error.to_string())
    }

    fn operation(&self, kind: &str) -> Result<OperationSchemas, String> {
        let of = OperationType::known(&self.catalogue, kind)?;
        let schemas = of.schemas(&self.catalogue);
        schemas.map_err(|error| error.to_string())
    }

    fn join(&self, wakes: CycleWakes) -> Result<Box<dyn RosConnection>, String> {
        let Ros2Settings {
            node,
            domain,
            networks,
            relays,
        } = &self.settings;
        let (namespace, name) = node.rsplit_once('/').unwrap_or(("", node));
        let options = NodeOptions {
            namespace: namespace.to_owned(),
            domain: *domain,
            networks: networks.clone(),
            ..NodeOptions::named(name)
        };
        let node = Node::start(options, Arc::clone(&self.catalogue));
        let node = node.map_err(|error| error.to_string())?;
        let CycleWakes { wake, lend_thread } = wakes;
        node.wake_for_notices(Arc::clone(&wake));
        let arrivals = ArrivalFlag::default();
        node.call_after_reading(arrivals.lender(lend_thread));
        let notices = Arc::new(Notices::default());
        let name = node.full_name();
        notices.keep(format!("joined the ROS 2 domain {domain} as `{name}`"));
        // for the cycle that reports it
        wake();
        Ok(Box::new(Ros2Connection {
            // before the publishers of the topics
            relays: AnnouncedRelays::announce(&node, relays)?,
            node,
            catalogue: Arc::clone(&self.catalogue),
            wake,
            arrivals,
            notices,
            state: ConnectionState::Sound,
            memories: self.memories.clone(),
        }))
    }
}

struct Ros2Connection {
    relays: AnnouncedRelays,
    node: Node,
    catalogue: Arc<Catalogue>,
    wake: Wake,
    arrivals: ArrivalFlag,
    notices: Arc<Notices>,
    state: ConnectionState,
    memories: Memories,
}

fn qos(topic: &MappedTopic) -> Qos {
    Qos {
        reliability: if topic.is_best_effort {
            Reliability::BestEffort
        } else {
            Reliability::Reliable
        },
        durability: if topic.is_latched {
            Durability::TransientLocal
        } else {
            Durability::Volatile
        },
        depth: topic.queue,
        deadline: topic.deadline,
        lifespan: topic.lifespan,
    }
}

impl RosConnection for Ros2Connection {
    fn publish(&mut self, topic: &MappedTopic) -> Result<Box<dyn MessageSender>, String> {
        let of = message(&topic.kind)?;
        let publisher = self.node.publisher(&topic.ros, &of, qos(topic));
        let publisher = publisher.map_err(|error| error.to_string())?;
        Ok(Box::new(Ros2Sender(publisher)))
    }

    fn subscribe(&mut self, topic: &MappedTopic) -> Result<Box<dyn MessageReceiver>, String> {
        let of = message(&topic.kind)?;
        let arrivals = self.arrivals.clone();
        let options = SubscriptionOptions {
            qos: qos(topic),
            ignores_own: true,
            waker: Some(Arc::new(move || arrivals.note())),
        };
        let subscription = self.node.subscription(&topic.ros, &of, options);
        let subscription = subscription.map_err(|error| error.to_string())?;
        Ok(Box::new(Ros2Receiver {
            subscription,
            circles: self.relays.circles(&self.node, &topic.ros)?,
            notices: Arc::clone(&self.notices),
            wake: Arc::clone(&self.wake),
            topic: topic.ros.clone(),
            is_latched: topic.is_latched,
            memory: self.memories.take(&topic.ros),
            memories: self.memories.clone(),
        }))
    }

    fn call(&mut self, of: &MappedOperation) -> Result<Box<dyn OperationCaller>, String> {
        let OperationType { name, kind } = OperationType::known(&self.catalogue, &of.kind)?;
        let (node, wake) = (&self.node, &self.wake);
        Ok(match kind {
            OperationKind::Service => Box::new(Ros2ServiceCaller::new(node, &of.ros, &name, wake)?),
            OperationKind::Action => Box::new(Ros2GoalCaller::new(node, &of.ros, &name, wake)?),
        })
    }

    fn offer(&mut self, of: &MappedOperation) -> Result<Box<dyn OperationServer>, String> {
        let found = OperationType::known(&self.catalogue, &of.kind)?;
        let (node, wake) = (&self.node, &self.wake);
        Ok(match found.kind {
            OperationKind::Service => {
                Box::new(Ros2ServiceServer::new(node, &of.ros, &found.name, wake)?)
            }
            OperationKind::Action => {
                let schemas = found.schemas(&self.catalogue);
                let schemas = schemas.map_err(|error| error.to_string())?;
                let result = &schemas.response;
                let server = Ros2GoalServer::new(node, &of.ros, &found.name, result, wake)?;
                Box::new(server)
            }
        })
    }

    fn show(
        &mut self,
        shown: &[ShownComponent],
        watch: ComponentWatch,
    ) -> Result<Box<dyn ComponentDisplay>, String> {
        let shown = Ros2Components::new(&self.node, watch, shown, &self.wake)?;
        Ok(Box::new(shown))
    }

    fn notices(&mut self) -> Vec<String> {
        let new = self.node.take_notices();
        if !new.is_empty() {
            let graph = self.node.graph();
            for notice in new {
                if notice == Notice::Interrupted {
                    self.state = ConnectionState::Broken;
                } else if matches!(notice, Notice::Returned { .. })
                    && self.state == ConnectionState::Sound
                {
                    self.state = ConnectionState::Partial;
                }
                // a peer that comes back is judged again, and each gap is an event of its own
                if matches!(notice, Notice::Lost { .. } | Notice::Deadline { .. }) {
                    self.notices.forget();
                }
                if let Some(text) = text(&notice, &graph) {
                    self.notices.keep(text);
                }
            }
        }
        self.notices.take()
    }

    fn state(&self) -> ConnectionState {
        self.state
    }
}

/// The topic of ROS for a topic of DDS.
fn ros(topic: &str) -> &str {
    topic.strip_prefix("rt").unwrap_or(topic)
}

/// A notice in words; `None` for one that is of no interest here.
fn text(notice: &Notice, graph: &Graph) -> Option<String> {
    let of_node = |peer| match graph.node_of(peer) {
        Some(node) => format!(" of `{node}`"),
        None => String::new(),
    };
    Some(match notice {
        Notice::TypeHash {
            topic,
            peer,
            here,
            there,
        } => format!(
            "`{}`: a peer{} has another definition of the type: its hash is {there}, and {here} here",
            ros(topic),
            of_node(*peer)
        ),
        Notice::Type {
            topic,
            here,
            there,
            peer,
        } => format!(
            "`{}`: a peer{} has the type `{}`, and the bridge `{}`: no messages pass between them",
            ros(topic),
            of_node(*peer),
            of_dds(there),
            of_dds(here)
        ),
        Notice::Qos {
            topic,
            here,
            there,
            peer,
            kind,
        } => {
            let (peer, name) = (of_node(*peer), ros(topic));
            let both = match kind {
                EndpointKind::Writer => {
                    format!("a publisher{peer} offers {there}, and the bridge requests {here}")
                }
                EndpointKind::Reader => {
                    format!("a subscriber{peer} requests {there}, and the bridge offers {here}")
                }
            };
            format!("`{name}`: {both}: no messages pass between them (key `qos`)")
        }
        Notice::Interrupted => "the process was stopped for a while, and its node of ROS 2 with it: the bridge joins again. Messages \
             in between are lost, and calls end"
            .to_owned(),
        Notice::Deadline { topic, deadline } => format!(
            "`{}`: no message within the deadline of {} ms",
            ros(topic),
            deadline.as_millis()
        ),
        Notice::Lost { nodes, topics, .. } => {
            if topics.is_empty() {
                return None;
            }
            let topics: Vec<_> = topics.iter().map(|it| format!("`{}`", ros(it))).collect();
            let who = named(nodes);
            format!("{who} no longer answers: lost on {}", topics.join(", "))
        }
        Notice::Returned { nodes, .. } => format!(
            "{} answers again: the bridge joins again as soon as no call is under way",
            named(nodes)
        ),
        Notice::Unacknowledged { topic, readers } => {
            let nodes: Vec<String> = readers.iter().filter_map(|it| graph.node_of(*it)).collect();
            let who = match &nodes[..] {
                [] => "a subscriber".to_owned(),
                [node] => format!("`{node}`"),
                nodes => format!("one of `{}`", nodes.join("`, `")),
            };
            format!(
                "`{}`: {who} does not acknowledge messages in time; older ones are no longer kept for it",
                ros(topic)
            )
        }
    })
}

/// Nodes in words.
fn named(nodes: &[String]) -> String {
    match nodes {
        [] => "a peer".to_owned(),
        nodes => format!("`{}`", nodes.join("`, `")),
    }
}

/// The type of ROS for a type of DDS.
fn of_dds(type_name: &str) -> String {
    let plain = type_name.trim_end_matches('_');
    plain.replace("::msg::dds_::", "/")
}

struct Ros2Sender(Publisher);

impl MessageSender for Ros2Sender {
    fn send(&mut self, message: &Datum) -> Result<(), String> {
        self.0.send(message).map_err(|error| error.to_string())
    }

    fn finish(&mut self, until: Instant) {
        self.0.drain(until);
    }

    fn losses(&self) -> Losses {
        let counts = self.0.counts();
        Losses {
            // not kept for a subscriber that does not acknowledge
            dropped: counts.dropped + counts.released,
            misfits: 0,
        }
    }
}

struct Ros2Receiver {
    subscription: Subscription,
    circles: Circles,
    notices: Arc<Notices>,
    wake: Wake,
    topic: String,
    is_latched: bool,
    memory: TopicMemory,
    memories: Memories,
}

impl Drop for Ros2Receiver {
    fn drop(&mut self) {
        let memory = std::mem::take(&mut self.memory);
        self.memories.keep(&self.topic, memory);
    }
}

impl MessageReceiver for Ros2Receiver {
    fn take(&mut self) -> Vec<RosMessage> {
        let mut messages = Vec::new();
        while let Some(received) = self.subscription.take() {
            let Received {
                writer,
                sequence,
                written,
                arrived,
                ..
            } = received;
            let (goes_round, reason) = self.circles.check(&self.subscription, writer);
            if reason.is_some_and(|it| self.notices.keep(it)) {
                (self.wake)();
            }
            if goes_round {
                continue;
            }
            // late subscriptions get the last messages of a latched topic by its nature
            if !self.memory.is_new(writer, sequence) && !self.is_latched {
                continue;
            }
            let age = self.memory.age(writer, written, arrived, Instant::now());
            let content = received.message;
            messages.push(RosMessage { content, age });
        }
        messages
    }

    fn losses(&self) -> Losses {
        let counts = self.subscription.counts();
        Losses {
            // lost on the way, or because the bridge was too slow
            dropped: counts.dropped + counts.lost,
            misfits: counts.malformed,
        }
    }
}
