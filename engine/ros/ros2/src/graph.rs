//! What a node knows of its peers: participants, endpoints, matches and nodes.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rustdds::{DomainParticipantStatusEvent, EndpointDescription, GUID};

use crate::gid::Gid;
use crate::names;
use crate::qos::Qos;

/// The kinds of endpoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndpointKind {
    /// Publishers, and the sending halves of clients and servers.
    Writer,
    /// Subscriptions, and the receiving halves of clients and servers.
    Reader,
}

/// A writer or reader of a peer, or of this node.
#[derive(Debug, Clone, PartialEq)]
pub struct Endpoint {
    /// Its id.
    pub gid: Gid,
    /// Writer or reader.
    pub kind: EndpointKind,
    /// The topic of DDS, such as `rt/scan`.
    pub topic: String,
    /// The type of DDS.
    pub type_name: String,
    /// The topic or service and its type as ROS names them; `None` if they are not of ROS.
    pub ros: Option<(String, String)>,
    /// The quality of service that it announces.
    pub qos: Qos,
    /// The type hash that it announces, such as `RIHS01_…`.
    pub type_hash: Option<String>,
}

/// A node of a peer, according to the graph that it publishes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RemoteNode {
    /// Name.
    pub name: String,
    /// Namespace, `/` or a name that starts with it.
    pub namespace: String,
    /// Ids of its readers.
    pub readers: Vec<Gid>,
    /// Ids of its writers.
    pub writers: Vec<Gid>,
}

/// An event that a user should see.
#[derive(Debug, Clone, PartialEq)]
pub enum Notice {
    /// A peer announces another type hash for a topic or service of this node. Its messages are decoded all the same, and
    /// counted as malformed where this fails.
    TypeHash {
        /// The topic of DDS.
        topic: String,
        /// The endpoint of the peer.
        peer: Gid,
        /// The hash here.
        here: String,
        /// The hash there.
        there: String,
    },
    /// A peer has the same topic with another type, and does not match.
    Type {
        /// The topic of DDS.
        topic: String,
        /// The type here.
        here: String,
        /// The type there.
        there: String,
        /// The endpoint of the peer.
        peer: Gid,
    },
    /// A peer has the same topic with a quality of service that does not match: a best-effort writer for a reliable reader, or a
    /// volatile writer for a transient local reader.
    Qos {
        /// The topic of DDS.
        topic: String,
        /// The quality of service there.
        there: Qos,
        /// The endpoint of the peer.
        peer: Gid,
    },
    /// A participant has left, or its lease has ended.
    Lost {
        /// The id of the participant's first 12 bytes, in hexadecimal digits.
        participant: String,
    },
}

/// All peers and endpoints, at one moment.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    /// Endpoints of peers.
    pub endpoints: BTreeMap<Gid, Endpoint>,
    /// Nodes of peers by participant.
    pub nodes: BTreeMap<Gid, Vec<RemoteNode>>,
    vendors: BTreeMap<[u8; 12], [u8; 2]>,
    /// For each endpoint of this node, the peers that match, and since when.
    matches: BTreeMap<Gid, BTreeMap<Gid, Instant>>,
    local: BTreeMap<Gid, Local>,
    notices: VecDeque<Notice>,
}

/// An endpoint of this node.
#[derive(Debug, Clone)]
struct Local {
    topic: String,
    type_name: String,
    type_hash: Option<String>,
}

/// Most notices that wait to be taken; the oldest is dropped.
const MOST_NOTICES: usize = 64;
/// Most endpoints of peers. A peer cannot fill the memory with endpoints that it invents.
const MOST_ENDPOINTS: usize = 1 << 14;

impl Graph {
    /// The number of peers that match an endpoint of this node.
    pub fn matches(&self, local: Gid) -> usize {
        self.matches.get(&local).map_or(0, BTreeMap::len)
    }

    /// The peers that match an endpoint of this node, and since when.
    pub(crate) fn matched(&self, local: Gid) -> impl Iterator<Item = (Gid, Instant)> {
        let found = self.matches.get(&local).into_iter().flatten();
        found.map(|(gid, since)| (*gid, *since))
    }

    /// The vendor of an endpoint's participant.
    pub(crate) fn vendor(&self, gid: Gid) -> Option<[u8; 2]> {
        self.vendors.get(&gid.participant()).copied()
    }

    fn notice(&mut self, notice: Notice) {
        if self.notices.len() >= MOST_NOTICES {
            self.notices.pop_front();
        }
        self.notices.push_back(notice);
    }

    fn detected(&mut self, kind: EndpointKind, description: EndpointDescription) {
        let gid = Gid::from(description.guid);
        if self.local.contains_key(&gid) || self.endpoints.len() >= MOST_ENDPOINTS {
            return;
        }
        let user_data = String::from_utf8_lossy(&description.user_data);
        let mut keys = user_data.split(';');
        let type_hash = keys.find_map(|key| key.strip_prefix("typehash="));
        let endpoint = Endpoint {
            gid,
            kind,
            ros: names::of_dds(&description.topic_name, &description.type_name),
            topic: description.topic_name,
            type_name: description.type_name,
            qos: Qos::announced(&description.qos),
            type_hash: type_hash.map(str::to_owned),
        };
        if self.endpoints.get(&gid) == Some(&endpoint) {
            return;
        }
        let same_topic = |local: &&Local| local.topic == endpoint.topic;
        let found = self.local.values().find(same_topic).cloned();
        if let Some(local) = found {
            self.compare(&local, &endpoint);
        }
        self.endpoints.insert(gid, endpoint);
    }

    /// Notices differences between an endpoint of this node and one of a peer, on the same topic.
    fn compare(&mut self, local: &Local, remote: &Endpoint) {
        if local.type_name != remote.type_name {
            self.notice(Notice::Type {
                topic: remote.topic.clone(),
                here: local.type_name.clone(),
                there: remote.type_name.clone(),
                peer: remote.gid,
            });
        } else if let (Some(here), Some(there)) = (&local.type_hash, &remote.type_hash)
            && here != there
        {
            self.notice(Notice::TypeHash {
                topic: remote.topic.clone(),
                peer: remote.gid,
                here: here.clone(),
                there: there.clone(),
            });
        }
    }

    fn incompatible(&mut self, peer: Gid, there: Qos) {
        let endpoint = self.endpoints.get(&peer);
        let topic = endpoint.map(|it| it.topic.clone()).unwrap_or_default();
        self.notice(Notice::Qos { topic, there, peer });
    }

    fn matched_by(&mut self, local: Gid, remote: Gid) {
        let peers = self.matches.entry(local).or_default();
        peers.entry(remote).or_insert_with(Instant::now);
    }

    fn lost(&mut self, is_lost: impl Fn(Gid) -> bool) {
        self.endpoints.retain(|gid, _| !is_lost(*gid));
        for peers in self.matches.values_mut() {
            peers.retain(|gid, _| !is_lost(*gid));
        }
    }

    fn apply(&mut self, event: DomainParticipantStatusEvent) {
        use DomainParticipantStatusEvent as Event;
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "an open enum of a dependency, with events about topics that readers and writers repeat"
        )]
        match event {
            Event::ParticipantDiscovered { dpd } => {
                let participant = Gid::from(dpd.guid).participant();
                self.vendors.insert(participant, dpd.vendor_id.as_bytes());
            }
            Event::ParticipantLost { id, .. } => {
                let mut guid = GUID::GUID_UNKNOWN;
                guid.prefix = id;
                let prefix = Gid::from(guid).participant();
                self.vendors.remove(&prefix);
                self.nodes.retain(|gid, _| gid.participant() != prefix);
                self.lost(|gid| gid.participant() == prefix);
                let participant = prefix.iter().map(|byte| format!("{byte:02x}"));
                self.notice(Notice::Lost {
                    participant: participant.collect(),
                });
            }
            Event::ReaderDetected { reader } => self.detected(EndpointKind::Reader, reader),
            Event::WriterDetected { writer } => self.detected(EndpointKind::Writer, writer),
            Event::ReaderLost { guid, .. } | Event::WriterLost { guid, .. } => {
                let lost = Gid::from(guid);
                self.lost(|gid| gid == lost);
            }
            Event::RemoteReaderMatched {
                local_writer,
                remote_reader,
            } => self.matched_by(local_writer.into(), remote_reader.into()),
            Event::RemoteWriterMatched {
                local_reader,
                remote_writer,
            } => self.matched_by(local_reader.into(), remote_writer.into()),
            Event::RemoteReaderQosIncompatible {
                remote_reader,
                requested_qos,
                ..
            } => self.incompatible(remote_reader.into(), Qos::announced(&requested_qos)),
            Event::RemoteWriterQosIncompatible {
                remote_writer,
                offered_qos,
                ..
            } => self.incompatible(remote_writer.into(), Qos::announced(&offered_qos)),
            _ => {}
        }
    }
}

/// The graph, with its changes announced to those who wait.
#[derive(Default)]
pub(crate) struct SharedGraph {
    graph: Mutex<Graph>,
    changed: Condvar,
}

impl SharedGraph {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Graph> {
        self.graph.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn apply(&self, event: DomainParticipantStatusEvent) {
        self.lock().apply(event);
        self.changed.notify_all();
    }

    /// Replaces the nodes of a participant.
    pub(crate) fn set_nodes(&self, participant: Gid, nodes: Vec<RemoteNode>) {
        self.lock().nodes.insert(participant, nodes);
        self.changed.notify_all();
    }

    /// Adds an endpoint of this node.
    pub(crate) fn add_local(
        &self,
        gid: Gid,
        topic: &str,
        type_name: &str,
        type_hash: Option<String>,
    ) {
        let local = Local {
            topic: topic.to_owned(),
            type_name: type_name.to_owned(),
            type_hash,
        };
        let mut graph = self.lock();
        graph.endpoints.remove(&gid);
        let known: Vec<_> = graph.endpoints.values().cloned().collect();
        for remote in known.iter().filter(|it| it.topic == local.topic) {
            graph.compare(&local, remote);
        }
        graph.local.insert(gid, local);
    }

    /// Removes an endpoint of this node.
    pub(crate) fn remove_local(&self, gid: Gid) {
        let mut graph = self.lock();
        graph.local.remove(&gid);
        graph.matches.remove(&gid);
    }

    pub(crate) fn take_notices(&self) -> Vec<Notice> {
        self.lock().notices.drain(..).collect()
    }

    /// Waits until the graph has a property, at most for `longest`; returns whether it has.
    pub(crate) fn wait(&self, longest: Duration, has: impl Fn(&Graph) -> bool) -> bool {
        let end = Instant::now() + longest;
        let mut graph = self.lock();
        while !has(&graph) {
            let Some(left) = end.checked_duration_since(Instant::now()) else {
                return false;
            };
            let waited = self.changed.wait_timeout(graph, left);
            graph = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }
}
