//! Nodes of ROS 1.

use std::sync::Arc;
use std::time::Instant;

use asmotion_bus::{Notifier, Overflow, QueuePolicy, Subscription};
use asmotion_component::Losses;
use asmotion_datum::{Datum, Schema};
use asmotion_ros_interface::Catalogue;
use asmotion_ros1::{
    ActionType, RosNotice, RosSettings, RosUri, ServiceType, TopicType, UnreadableMessages,
};

use crate::desk::ComponentWatch;
use crate::mapped::MappedTopic;
use crate::notices::Notices;
use crate::operation::{MappedOperation, OperationCaller, OperationSchemas, OperationServer};
use crate::operation_type::{OperationKind, OperationType};
use crate::ros1_operations::{
    Ros1GoalCaller, Ros1GoalServer, Ros1ServiceCaller, Ros1ServiceServer,
};
use crate::ros1_parameters::Ros1Parameters;
use crate::shown::{ComponentDisplay, ShownComponent};
use crate::transport::{MessageReceiver, MessageSender, RosConnection, RosMessage, RosTransport};
use crate::wake::{ArrivalFlag, CycleWakes, Wake};

/// Settings of a node of ROS 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ros1Settings {
    /// Name of the node.
    pub node: String,
    /// Address of the master, such as `http://127.0.0.1:11311`.
    pub master: String,
    /// Host or IP address at which other nodes reach this machine.
    pub host: String,
    /// Topics whose messages the bridge brings to a topic of the composite that it sends to other topics, with those topics.
    pub relays: Vec<(String, String)>,
}

/// Reaches the nodes that a master of ROS 1 knows.
pub struct Ros1Transport {
    settings: Ros1Settings,
    catalogue: Arc<Catalogue>,
}

impl Ros1Transport {
    /// Reaches the nodes of a master, whose messages have these definitions.
    pub fn new(settings: Ros1Settings, catalogue: Arc<Catalogue>) -> Self {
        Self {
            settings,
            catalogue,
        }
    }
}

/// The type of a topic.
fn topic_type(catalogue: &Catalogue, kind: &str) -> Result<TopicType, String> {
    let name = kind.parse().map_err(|error| format!("{error}"))?;
    TopicType::of(catalogue, &name).map_err(|error| error.to_string())
}

impl RosTransport for Ros1Transport {
    fn schema(&self, kind: &str) -> Result<Schema, String> {
        topic_type(&self.catalogue, kind).map(|of| (*of.schema).clone())
    }

    fn operation(&self, kind: &str) -> Result<OperationSchemas, String> {
        let of = OperationType::known(&self.catalogue, kind)?;
        of.schemas(&self.catalogue)
            .map_err(|error| error.to_string())
    }

    fn join(&self, wakes: CycleWakes) -> Result<Box<dyn RosConnection>, String> {
        let Ros1Settings {
            node,
            master,
            host,
            relays,
        } = &self.settings;
        let master: RosUri = master.parse().map_err(|error| format!("{error}"))?;
        let CycleWakes { wake, lend_thread } = wakes;
        let arrivals = ArrivalFlag::default();
        let notices = Arc::new(Notices::default());
        let (kept, woken) = (Arc::clone(&notices), Arc::clone(&wake));
        let settings = RosSettings {
            master,
            host: host.clone(),
            relays: relays.clone(),
            notices: Arc::new(move |notice| {
                if matches!(notice, RosNotice::Registered { .. }) {
                    kept.forget();
                }
                if kept.keep(notice.to_string()) {
                    woken();
                }
            }),
            after_reading: Some(arrivals.lender(lend_thread)),
            ..RosSettings::new(node.clone())
        };
        let node = asmotion_ros1::RosNode::start(settings).map_err(|error| error.to_string())?;
        Ok(Box::new(Ros1Connection {
            name: node.name().to_string().into(),
            node: Arc::new(node),
            catalogue: Arc::clone(&self.catalogue),
            wake,
            arrivals,
            notices,
        }))
    }
}

struct Ros1Connection {
    // shared with the operations, which call through it
    node: Arc<asmotion_ros1::RosNode>,
    name: Arc<str>,
    catalogue: Arc<Catalogue>,
    wake: Wake,
    arrivals: ArrivalFlag,
    notices: Arc<Notices>,
}

impl RosConnection for Ros1Connection {
    fn publish(&mut self, topic: &MappedTopic) -> Result<Box<dyn MessageSender>, String> {
        let of = topic_type(&self.catalogue, &topic.kind)?;
        let (queue, is_latched) = (topic.queue, topic.is_latched);
        let publisher = self.node.publisher(&topic.ros, of, queue, is_latched);
        Ok(Box::new(Ros1Sender(
            publisher.map_err(|it| it.to_string())?,
        )))
    }

    fn subscribe(&mut self, topic: &MappedTopic) -> Result<Box<dyn MessageReceiver>, String> {
        let of = topic_type(&self.catalogue, &topic.kind)?;
        let queue = QueuePolicy::All {
            size: topic.queue,
            overflow: Overflow::DropOldest,
        };
        let arrivals = self.arrivals.clone();
        let notifier = Arc::new(Notifier::calling(move || arrivals.note()));
        let subscription = self.node.subscribe(&topic.ros, Some(of), queue, notifier);
        let subscription = subscription.map_err(|it| it.to_string())?;
        let unreadable = self.node.unreadable_messages(&topic.ros);
        Ok(Box::new(Ros1Receiver {
            subscription,
            unreadable: unreadable.map_err(|it| it.to_string())?,
            own: Arc::clone(&self.name),
        }))
    }

    fn call(&mut self, of: &MappedOperation) -> Result<Box<dyn OperationCaller>, String> {
        let (node, notifier) = (&self.node, self.notifier());
        Ok(match self.endpoint_type(of)? {
            EndpointType::Service(kind) => {
                Box::new(Ros1ServiceCaller::new(node, &of.ros, kind, notifier)?)
            }
            EndpointType::Action(kind) => {
                Box::new(Ros1GoalCaller::new(node, &of.ros, &kind, &notifier)?)
            }
        })
    }

    fn offer(&mut self, of: &MappedOperation) -> Result<Box<dyn OperationServer>, String> {
        let (node, notifier) = (&self.node, self.notifier());
        Ok(match self.endpoint_type(of)? {
            EndpointType::Service(kind) => {
                Box::new(Ros1ServiceServer::new(node, &of.ros, kind, notifier)?)
            }
            EndpointType::Action(kind) => {
                let found = OperationType::known(&self.catalogue, &of.kind)?;
                let schemas = found.schemas(&self.catalogue);
                let schemas = schemas.map_err(|error| error.to_string())?;
                let result = &schemas.response;
                let server = Ros1GoalServer::new(node, &of.ros, &kind, result, &notifier)?;
                Box::new(server)
            }
        })
    }

    fn show(
        &mut self,
        shown: &[ShownComponent],
        watch: ComponentWatch,
    ) -> Result<Box<dyn ComponentDisplay>, String> {
        let shown = Ros1Parameters::new(&self.node, self.notifier(), watch, shown);
        Ok(Box::new(shown))
    }

    fn notices(&mut self) -> Vec<String> {
        self.notices.take()
    }
}

/// The type of a service or an action, for a node.
enum EndpointType {
    Service(ServiceType),
    Action(Box<ActionType>),
}

impl Ros1Connection {
    fn notifier(&self) -> Arc<Notifier> {
        let wake = Arc::clone(&self.wake);
        Arc::new(Notifier::calling(move || wake()))
    }

    fn endpoint_type(&self, of: &MappedOperation) -> Result<EndpointType, String> {
        let found = OperationType::known(&self.catalogue, &of.kind)?;
        Ok(match found.kind {
            OperationKind::Service => {
                let kind = ServiceType::of(&self.catalogue, &found.name);
                EndpointType::Service(kind.map_err(|error| error.to_string())?)
            }
            OperationKind::Action => {
                let kind = ActionType::of(&self.catalogue, &found.name.short());
                EndpointType::Action(Box::new(kind.map_err(|error| error.to_string())?))
            }
        })
    }
}

struct Ros1Sender(asmotion_ros1::RosPublisher);

impl MessageSender for Ros1Sender {
    fn send(&mut self, message: &Datum) -> Result<(), String> {
        self.0.publish(message).map_err(|error| error.to_string())
    }

    fn finish(&mut self, until: Instant) {
        self.0.drain(until);
    }

    fn losses(&self) -> Losses {
        Losses {
            dropped: self.0.dropped(),
            misfits: 0,
        }
    }
}

struct Ros1Receiver {
    subscription: Subscription,
    unreadable: Option<UnreadableMessages>,
    /// Name of the bridge's node, whose own messages do not come back.
    own: Arc<str>,
}

impl MessageReceiver for Ros1Receiver {
    fn take(&mut self) -> Vec<RosMessage> {
        let arrived = std::iter::from_fn(|| self.subscription.try_next());
        let others = arrived.filter(|envelope| envelope.source != self.own);
        // the node has decoded them: what cannot be decoded is among its counts
        others
            .filter_map(|envelope| {
                Some(RosMessage {
                    content: envelope.payload.into_datum().ok()?,
                    age: envelope.age,
                })
            })
            .collect()
    }

    fn losses(&self) -> Losses {
        let unreadable = self.unreadable.as_ref();
        Losses {
            dropped: self.subscription.dropped(),
            misfits: unreadable.map_or(0, UnreadableMessages::count),
        }
    }
}
