//! The participant of a node: it creates readers and writers of DDS and publishes them in the graph.

use std::collections::{BTreeMap, BTreeSet};
use std::net::IpAddr;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use asmotion_datum::{Codec, Schema};
use asmotion_ros_interface::{Catalogue, InterfaceKind, InterfaceName};
use rustdds::no_key::DataWriter;
use rustdds::{DomainParticipant, DomainParticipantBuilder, QosPolicies, RTPSEntity, TopicKind};

use crate::endpoint::RemoteNode;
use crate::entities::{self, Entities};
use crate::error::{EndpointError, NodeError};
use crate::gid::Gid;
use crate::graph::SharedGraph;
use crate::names;
use crate::outbox::{Outbox, Readers};
use crate::payload::{Payload, Raw};
use crate::qos::{Qos, Reliability};
use crate::reactor::{Chore, Reactor, Reader, Registration, Sink};
use crate::release::Acknowledger;
use crate::scout::Scout;

/// Configuration of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeOptions {
    /// Name: letters, digits and underscores.
    pub name: String,
    /// Namespace, in which relative names are; `/` by default.
    pub namespace: String,
    /// Domain id, 0 to 232, 0 by default. Participants of other domains are not seen.
    pub domain: u16,
    /// Addresses of the network interfaces that are announced and used for multicast; all if empty. Sockets are bound to all
    /// addresses nevertheless: this is no protection.
    pub networks: Vec<IpAddr>,
}

impl NodeOptions {
    /// A node with this name, in the root namespace, in domain 0, on all networks.
    pub fn named(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            namespace: "/".to_owned(),
            domain: 0,
            networks: Vec::new(),
        }
    }
}

/// Largest domain id whose ports exist.
const LAST_DOMAIN: u16 = 232;

/// What a node and its endpoints share. All but the options is that of the participant, which several nodes can share.
pub(crate) struct Inner {
    options: NodeOptions,
    catalogue: Arc<Catalogue>,
    participant: DomainParticipant,
    publisher: rustdds::Publisher,
    subscriber: rustdds::Subscriber,
    pub(crate) reactor: Arc<Reactor>,
    pub(crate) graph: Arc<SharedGraph>,
    acknowledger: Arc<Acknowledger>,
    /// The nodes of the participant with their endpoints, as they are published in the graph.
    own: Arc<Mutex<OwnNodes>>,
    entities: Arc<Entities>,
    goals: Arc<AtomicU32>,
}

#[derive(Default)]
struct OwnNodes {
    /// By namespace and name.
    nodes: BTreeMap<(String, String), OwnEndpoints>,
    outbox: Option<Arc<Outbox>>,
}

#[derive(Default)]
struct OwnEndpoints {
    readers: BTreeSet<Gid>,
    writers: BTreeSet<Gid>,
}

impl OwnNodes {
    fn of(&mut self, key: (String, String)) -> &mut OwnEndpoints {
        self.nodes.entry(key).or_default()
    }
}

fn refused(topic: &str, reason: impl ToString) -> EndpointError {
    EndpointError::Dds {
        topic: topic.to_owned(),
        reason: reason.to_string(),
    }
}

impl Inner {
    /// Creates the participant and its thread.
    pub(crate) fn start(
        options: NodeOptions,
        catalogue: Arc<Catalogue>,
    ) -> Result<(Arc<Self>, JoinHandle<()>), NodeError> {
        names::node(&options.name)?;
        let options = NodeOptions {
            namespace: names::namespace(&options.namespace)?,
            ..options
        };
        let domain = options.domain;
        if domain > LAST_DOMAIN {
            return Err(NodeError::Domain(domain));
        }
        let failed = |error: rustdds::dds::CreateError| NodeError::Participant {
            domain,
            reason: error.to_string(),
        };
        let mut builder = DomainParticipantBuilder::new(domain);
        if !options.networks.is_empty() {
            builder = builder.with_only_networks(options.networks.iter().copied());
        }
        let participant = builder.build().map_err(failed)?;
        let none = QosPolicies::qos_none();
        let publisher = participant.create_publisher(&none).map_err(failed)?;
        let subscriber = participant.create_subscriber(&none).map_err(failed)?;
        let graph = Arc::new(SharedGraph::default());
        let networks = options.networks.clone();
        let scout = Scout { domain, networks };
        graph.set_scout(Box::new(move |graph| scout.clone().start(graph)));
        let acknowledger = Arc::new(Acknowledger::new(&participant)?);
        let (reactor, thread) = Reactor::start(&participant, &graph, &options.name)?;
        let inner = Arc::new(Self {
            options,
            catalogue,
            participant,
            publisher,
            subscriber,
            reactor,
            graph,
            acknowledger,
            own: Arc::default(),
            entities: Arc::new(Entities::new()?),
            goals: Arc::default(),
        });
        inner.own().nodes.insert(inner.key(), Default::default());
        Ok((inner, thread))
    }

    /// A further node of the participant, which peers see beside the first.
    pub(crate) fn beside(&self, namespace: &str, name: &str) -> Result<Arc<Self>, NodeError> {
        names::node(name)?;
        let inner = Arc::new(Self {
            options: NodeOptions {
                name: name.to_owned(),
                namespace: names::namespace(namespace)?,
                ..self.options.clone()
            },
            catalogue: Arc::clone(&self.catalogue),
            participant: self.participant.clone(),
            publisher: self.publisher.clone(),
            subscriber: self.subscriber.clone(),
            reactor: Arc::clone(&self.reactor),
            graph: Arc::clone(&self.graph),
            acknowledger: Arc::clone(&self.acknowledger),
            own: Arc::clone(&self.own),
            entities: Arc::clone(&self.entities),
            goals: Arc::clone(&self.goals),
        });
        let mut own = self.own();
        if own.nodes.contains_key(&inner.key()) {
            return Err(NodeError::Twice(inner.full_name()));
        }
        own.nodes.insert(inner.key(), Default::default());
        drop(own);
        inner.publish_entities();
        Ok(inner)
    }

    /// Removes this node from the graph, and leaves the others of the participant.
    pub(crate) fn leave_participant(&self) {
        self.own().nodes.remove(&self.key());
        self.publish_entities();
    }

    fn key(&self) -> (String, String) {
        let NodeOptions {
            name, namespace, ..
        } = &self.options;
        (namespace.clone(), name.clone())
    }

    pub(crate) fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// The schema of a message.
    pub(crate) fn message(&self, of: &InterfaceName) -> Result<Schema, EndpointError> {
        self.check_kind(of, InterfaceKind::Message, "message")?;
        let schema = self.catalogue.schema(of)?;
        self.carried(of, &schema)?;
        Ok(schema)
    }

    pub(crate) fn check_kind(
        &self,
        of: &InterfaceName,
        kind: InterfaceKind,
        needed: &'static str,
    ) -> Result<(), EndpointError> {
        if of.kind() == kind {
            return Ok(());
        }
        let of = of.clone();
        Err(EndpointError::Kind { of, needed })
    }

    pub(crate) fn carried(&self, of: &InterfaceName, schema: &Schema) -> Result<(), EndpointError> {
        let carried = Codec::Cdr.carries(schema);
        carried.map_err(|reason| EndpointError::Uncarried {
            of: of.clone(),
            reason,
        })
    }

    /// The type hash, with which that of a peer is compared.
    pub(crate) fn hash(&self, of: &InterfaceName) -> Option<String> {
        let hash = self.catalogue.type_hash(of);
        // a folder of definitions may lack those that only the hash needs
        hash.ok().map(|hash| hash.to_string())
    }

    pub(crate) fn absolute(&self, name: &str) -> Result<String, names::NameError> {
        names::absolute(name, &self.options.namespace, &self.options.name)
    }

    /// A number that no other goal of this node has.
    pub(crate) fn next_goal(&self) -> u32 {
        self.goals.fetch_add(1, Ordering::Relaxed)
    }

    pub(crate) fn gid(&self) -> Gid {
        self.participant.guid().into()
    }

    /// Creates a writer of DDS, with its queue.
    pub(crate) fn writer(
        &self,
        topic: &str,
        kind: &str,
        qos: Qos,
        hash: Option<String>,
    ) -> Result<Arc<Outbox>, EndpointError> {
        let policies = qos.writer();
        let dds = self.dds_topic(topic, kind, &qos.topic())?;
        let created = self
            .publisher
            .create_datawriter_no_key(&dds, Some(policies));
        let writer: DataWriter<Payload, Raw> = created.map_err(|error| refused(topic, error))?;
        let gid = Gid::from(writer.guid());
        self.graph.add_local(gid, topic, kind, hash);
        let readers = (qos.reliability == Reliability::Reliable).then(|| Readers {
            graph: Arc::clone(&self.graph),
            acknowledger: Arc::clone(&self.acknowledger),
        });
        let kept = (qos.history(), readers);
        let outbox = Arc::new(Outbox::new(gid, topic, writer, qos.queue(), kept));
        let chore: Arc<dyn Chore> = outbox.clone();
        self.reactor.add_chore(Arc::downgrade(&chore));
        self.own().of(self.key()).writers.insert(gid);
        self.publish_entities();
        Ok(outbox)
    }

    /// Creates a reader of DDS, whose messages go to a sink.
    pub(crate) fn reader(
        &self,
        topic: &str,
        kind: &str,
        qos: Qos,
        hash: Option<String>,
        sink: impl FnOnce(Gid) -> Box<dyn Sink>,
    ) -> Result<(Gid, Registration), EndpointError> {
        let policies = qos.reader();
        let dds = self.dds_topic(topic, kind, &policies)?;
        let created = self
            .subscriber
            .create_simple_datareader_no_key(&dds, Some(policies));
        let reader: Reader = created.map_err(|error| refused(topic, error))?;
        let gid = Gid::from(reader.guid());
        self.graph.add_local(gid, topic, kind, hash);
        let registration = self.reactor.read(reader, sink(gid));
        let registration = registration.map_err(|error| refused(topic, error))?;
        self.own().of(self.key()).readers.insert(gid);
        self.publish_entities();
        Ok((gid, registration))
    }

    fn dds_topic(
        &self,
        topic: &str,
        kind: &str,
        policies: &QosPolicies,
    ) -> Result<rustdds::Topic, EndpointError> {
        let (name, kind) = (topic.to_owned(), kind.to_owned());
        let created = self
            .participant
            .create_topic(name, kind, policies, TopicKind::NoKey);
        created.map_err(|error| refused(topic, error))
    }

    /// Removes an endpoint of this node from the graph.
    pub(crate) fn forget(&self, gid: Gid) {
        self.graph.remove_local(gid);
        let mut own = self.own();
        let mut nodes = own.nodes.values_mut();
        let known = nodes.any(|it| it.readers.remove(&gid) | it.writers.remove(&gid));
        drop(own);
        if known {
            self.publish_entities();
        }
    }

    fn own(&self) -> MutexGuard<'_, OwnNodes> {
        self.own.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Publishes the nodes of the participant and their endpoints.
    fn publish_entities(&self) {
        let own = self.own();
        let Some(outbox) = own.outbox.clone() else {
            return;
        };
        let nodes = own.nodes.iter();
        let nodes = nodes.map(|((namespace, name), of)| RemoteNode {
            name: name.clone(),
            namespace: namespace.clone(),
            readers: of.readers.iter().copied().collect(),
            writers: of.writers.iter().copied().collect(),
        });
        let nodes: Vec<_> = nodes.collect();
        // before the lock is released: the newest message has the newest state
        self.send_entities(&outbox, &nodes);
    }

    fn send_entities(&self, outbox: &Outbox, nodes: &[RemoteNode]) {
        // the schema is ours, and a full queue keeps the newest, which is all that counts
        if let Ok(bytes) = self.entities.encode(self.gid(), nodes) {
            let _ = outbox.send(bytes.into(), None);
        }
    }

    /// Publishes the node, and follows the graph of peers.
    pub(crate) fn join_graph(&self) -> Result<Registration, EndpointError> {
        let qos = Qos::latched();
        let (topic, kind) = (entities::TOPIC, entities::TYPE);
        let listener = self.entities.listener(Arc::clone(&self.graph), self.gid());
        let (reader, registration) = self.reader(topic, kind, qos, None, |_| Box::new(listener))?;
        let outbox = self.writer(topic, kind, qos, None)?;
        let mut own = self.own();
        // rmw does not list the endpoints of the graph itself
        let endpoints = own.of(self.key());
        endpoints.readers.remove(&reader);
        endpoints.writers.remove(&outbox.gid);
        own.outbox = Some(outbox);
        drop(own);
        self.publish_entities();
        Ok(registration)
    }

    /// Publishes that the participant has no node any more.
    pub(crate) fn leave_graph(&self) {
        if let Some(outbox) = self.own().outbox.take() {
            self.send_entities(&outbox, &[]);
        }
    }

    /// The name of the node with its namespace.
    pub(crate) fn full_name(&self) -> String {
        let NodeOptions {
            name, namespace, ..
        } = &self.options;
        format!("{}/{name}", namespace.trim_end_matches('/'))
    }
}
