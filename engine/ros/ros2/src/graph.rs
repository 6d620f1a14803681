//! What a node knows of its peers: participants, endpoints, matches and nodes.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use rustdds::{DomainParticipantStatusEvent, EndpointDescription, GUID, LostReason, QosPolicies};

use crate::endpoint::{Endpoint, EndpointKind, RemoteNode};
use crate::gid::Gid;
use crate::names;
use crate::notice::{Notice, Waker};
use crate::qos::{Qos, Reliability};

/// All peers and endpoints, at one moment.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    /// Endpoints of peers.
    pub endpoints: BTreeMap<Gid, Endpoint>,
    /// Nodes of peers by participant.
    pub nodes: BTreeMap<Gid, Vec<RemoteNode>>,
    vendors: BTreeMap<[u8; 12], [u8; 2]>,
    /// Counts the changes of `endpoints`.
    revision: u64,
    /// For each endpoint of this node, the peers that match, and since when.
    matches: BTreeMap<Gid, BTreeMap<Gid, Instant>>,
    local: BTreeMap<Gid, Local>,
    /// Participants whose lease has ended while they matched endpoints of this node beside the graph, with the time and the names of their
    /// nodes.
    expired: BTreeMap<[u8; 12], (Instant, Vec<String>)>,
    /// A scout looks for them.
    is_scouted: bool,
    /// With the time since which they wait.
    notices: VecDeque<(Instant, Notice)>,
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
/// Time in which a peer publishes the name of its node after the endpoints.
const NAMING: Duration = Duration::from_millis(500);
/// Most endpoints of peers. A peer cannot fill the memory with endpoints that it invents.
const MOST_ENDPOINTS: usize = 1 << 14;
/// Most participants that are remembered after their lease has ended.
const MOST_EXPIRED: usize = 256;

/// The id of a participant in hexadecimal digits.
fn in_digits(participant: [u8; 12]) -> String {
    let digits = participant.iter().map(|byte| format!("{byte:02x}"));
    digits.collect()
}

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

    /// The readers that match a writer of this node, of those that are reliable or not, as wanted. One that is not known is reliable.
    pub(crate) fn readers(&self, writer: Gid, wanted: impl Fn(bool) -> bool) -> Vec<Gid> {
        let is_reliable = |reader: &Gid| {
            let known: Option<&Endpoint> = self.endpoints.get(reader);
            known.is_none_or(|it| it.qos.reliability == Reliability::Reliable)
        };
        let all = self.matches.get(&writer).into_iter().flatten();
        let all = all.map(|(reader, _)| *reader);
        all.filter(|it| wanted(is_reliable(it))).collect()
    }

    /// The vendor of an endpoint's participant.
    pub(crate) fn vendor(&self, gid: Gid) -> Option<[u8; 2]> {
        self.vendors.get(&gid.participant()).copied()
    }

    /// Since when the first of the peers that match an endpoint of this node matches it.
    pub(crate) fn matched_since(&self, local: Gid) -> Option<Instant> {
        self.matched(local).map(|(_, since)| since).min()
    }

    /// Since when the last of the peers that match an endpoint of this node matches it.
    pub(crate) fn newest_match(&self, local: Gid) -> Option<Instant> {
        self.matched(local).map(|(_, since)| since).max()
    }

    /// The name of the node, with its namespace, that has an endpoint; `None` if no peer has published it yet.
    pub fn node_of(&self, endpoint: Gid) -> Option<String> {
        let mut all = self.nodes.values().flatten();
        let has = |node: &&RemoteNode| {
            node.readers.contains(&endpoint) || node.writers.contains(&endpoint)
        };
        all.find(has).map(RemoteNode::full_name)
    }

    /// A number that differs from that of a graph with other endpoints.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// The topics of DDS that begin with this text and that peers write, with their participants.
    pub(crate) fn written<'g>(
        &'g self,
        prefix: &'g str,
    ) -> impl Iterator<Item = (&'g str, [u8; 12])> {
        let writers = self.endpoints.iter();
        let writers = writers.filter(|(_, it)| it.kind == EndpointKind::Writer);
        let found = writers.filter(move |(_, it)| it.topic.starts_with(prefix));
        found.map(|(gid, it)| (&*it.topic, gid.participant()))
    }

    /// The topics of DDS on which a participant matches endpoints of this node.
    fn topics_with(&self, participant: [u8; 12]) -> Vec<String> {
        let matches = self.matches.iter();
        let mut shared = matches.filter(|(_, peers)| {
            let mut peers = peers.keys();
            peers.any(|peer| peer.participant() == participant)
        });
        let topic = |(local, _): (&Gid, _)| self.local.get(local).map(|it| it.topic.clone());
        let topics: BTreeSet<String> = shared.by_ref().filter_map(topic).collect();
        topics.into_iter().collect()
    }

    /// Returns whether a notice can be taken: the name of its peer's node is known, or has not come for a while.
    fn is_ready(&self, (since, notice): &(Instant, Notice)) -> bool {
        let peer = notice.peer();
        peer.is_none_or(|peer| self.node_of(peer).is_some() || since.elapsed() >= NAMING)
    }

    fn notice(&mut self, notice: Notice) {
        if self.notices.len() >= MOST_NOTICES {
            self.notices.pop_front();
        }
        self.notices.push_back((Instant::now(), notice));
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
        self.revision += 1;
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

    fn incompatible(&mut self, local: Gid, peer: Gid, kind: EndpointKind, both: [&QosPolicies; 2]) {
        let local = self.local.get(&local);
        let topic = local.map(|it| it.topic.clone()).unwrap_or_default();
        let [here, there] = both.map(Qos::announced);
        self.notice(Notice::Qos {
            topic,
            here,
            there,
            peer,
            kind,
        });
    }

    fn matched_by(&mut self, local: Gid, remote: Gid) {
        let peers = self.matches.entry(local).or_default();
        peers.entry(remote).or_insert_with(Instant::now);
    }

    fn lost(&mut self, is_lost: impl Fn(Gid) -> bool) {
        self.endpoints.retain(|gid, _| !is_lost(*gid));
        self.revision += 1;
        for peers in self.matches.values_mut() {
            peers.retain(|gid, _| !is_lost(*gid));
        }
    }

    /// A participant is there that may have been missing.
    fn returned(&mut self, participant: [u8; 12]) {
        if let Some((_, nodes)) = self.expired.remove(&participant) {
            let participant = in_digits(participant);
            self.notice(Notice::Returned { participant, nodes });
        }
    }

    fn participant_lost(&mut self, prefix: [u8; 12], is_expired: bool) {
        let topics = self.topics_with(prefix);
        self.vendors.remove(&prefix);
        let is_lost = |gid: &Gid| gid.participant() == prefix;
        let nodes = self.nodes.iter().filter(|(gid, _)| is_lost(gid));
        let nodes = nodes.flat_map(|(_, nodes)| nodes.iter().map(RemoteNode::full_name));
        let nodes: Vec<String> = nodes.collect();
        self.nodes.retain(|gid, _| !is_lost(gid));
        self.lost(|gid| is_lost(&gid));
        // every node follows the graph
        let is_reached = topics.iter().any(|it| it != names::GRAPH);
        if is_expired && is_reached && self.expired.len() < MOST_EXPIRED {
            self.expired.insert(prefix, (Instant::now(), nodes.clone()));
        }
        self.notice(Notice::Lost {
            participant: in_digits(prefix),
            nodes,
            topics,
        });
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
                self.returned(participant);
            }
            Event::ParticipantLost { id, reason } => {
                let mut guid = GUID::GUID_UNKNOWN;
                guid.prefix = id;
                let is_expired = matches!(reason, LostReason::Timeout { .. });
                self.participant_lost(Gid::from(guid).participant(), is_expired);
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
                local_writer,
                remote_reader,
                requested_qos,
                offered_qos,
            } => {
                let both = [&*offered_qos, &*requested_qos];
                let (here, there) = (local_writer.into(), remote_reader.into());
                self.incompatible(here, there, EndpointKind::Reader, both);
            }
            Event::RemoteWriterQosIncompatible {
                local_reader,
                remote_writer,
                requested_qos,
                offered_qos,
            } => {
                let both = [&*requested_qos, &*offered_qos];
                let (here, there) = (local_reader.into(), remote_writer.into());
                self.incompatible(here, there, EndpointKind::Writer, both);
            }
            _ => {}
        }
    }
}

/// Starts what looks for the missing participants of a graph.
pub(crate) type StartScout = Box<dyn Fn(&Arc<SharedGraph>) + Send + Sync>;

/// The graph, with its changes announced to those who wait.
#[derive(Default)]
pub(crate) struct SharedGraph {
    graph: Mutex<Graph>,
    changed: Condvar,
    /// Called when notices wait.
    waker: Mutex<Option<Waker>>,
    /// Called when a lease has ended and nobody looks for those that are missing. Set once.
    scout: OnceLock<StartScout>,
}

impl SharedGraph {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Graph> {
        self.graph.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn apply(self: &Arc<Self>, event: DomainParticipantStatusEvent) {
        let mut graph = self.lock();
        graph.apply(event);
        let needs_scout = !graph.expired.is_empty() && !graph.is_scouted;
        graph.is_scouted |= needs_scout;
        drop(graph);
        if needs_scout && let Some(scout) = self.scout.get() {
            scout(self);
        }
        self.changed.notify_all();
        self.wake_for_notices();
    }

    /// Sets the function that starts looking for participants whose lease has ended.
    pub(crate) fn set_scout(&self, scout: StartScout) {
        // the first one stays: there is one for each participant
        let _ = self.scout.set(scout);
    }

    /// Participants whose lease has ended.
    pub(crate) fn expired(&self) -> BTreeSet<[u8; 12]> {
        self.lock().expired.keys().copied().collect()
    }

    /// When the last lease of these ended; `None`, and the scout ends, if there are none.
    pub(crate) fn newest_expiry(&self) -> Option<Instant> {
        let mut graph = self.lock();
        let newest = graph.expired.values().map(|(at, _)| *at).max();
        graph.is_scouted = newest.is_some();
        newest
    }

    /// A participant is there whose lease had ended.
    pub(crate) fn returned(&self, participant: [u8; 12]) {
        self.lock().returned(participant);
        self.wake_for_notices();
    }

    /// Adds a notice.
    pub(crate) fn notice(&self, notice: Notice) {
        self.lock().notice(notice);
        self.wake_for_notices();
    }

    /// Sets what is called when notices wait, and calls it if some do.
    pub(crate) fn set_waker(&self, waker: Waker) {
        *self.waker.lock().unwrap_or_else(PoisonError::into_inner) = Some(waker);
        self.wake_for_notices();
    }

    /// Calls the waker if notices can be taken.
    pub(crate) fn wake_for_notices(&self) {
        let graph = self.lock();
        if !graph.notices.iter().any(|it| graph.is_ready(it)) {
            return;
        }
        drop(graph);
        let waker = self.waker.lock().unwrap_or_else(PoisonError::into_inner);
        let waker = waker.clone();
        if let Some(waker) = waker {
            waker();
        }
    }

    /// Replaces the nodes of a participant.
    pub(crate) fn set_nodes(&self, participant: Gid, nodes: Vec<RemoteNode>) {
        self.lock().nodes.insert(participant, nodes);
        self.changed.notify_all();
        self.wake_for_notices();
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
        drop(graph);
        self.wake_for_notices();
    }

    /// Removes an endpoint of this node.
    pub(crate) fn remove_local(&self, gid: Gid) {
        let mut graph = self.lock();
        graph.local.remove(&gid);
        graph.matches.remove(&gid);
    }

    pub(crate) fn take_notices(&self) -> Vec<Notice> {
        let mut graph = self.lock();
        let all = std::mem::take(&mut graph.notices);
        let (ready, waiting) = all.into_iter().partition(|it| graph.is_ready(it));
        graph.notices = waiting;
        let ready: VecDeque<(Instant, Notice)> = ready;
        ready.into_iter().map(|(_, notice)| notice).collect()
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
