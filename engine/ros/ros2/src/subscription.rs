//! Subscriptions.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use asmotion_datum::{Codec, Datum, Schema};

use crate::deadline::DeadlineWatch;
use crate::gid::Gid;
use crate::graph::Graph;
use crate::names;
use crate::notice::Waker;
use crate::participant::Inner;
use crate::qos::Qos;
use crate::queue::Queue;
use crate::reactor::{Incoming, Registration, Sink};

/// Numbers of messages of a subscription.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SubscriptionCounts {
    /// Decoded and put into the queue.
    pub received: u64,
    /// Dropped because the queue was full.
    pub dropped: u64,
    /// Numbers that a writer left out: messages lost on the way. Only counted after the first message of a writer.
    pub lost: u64,
    /// Messages that are not of the type: cut short, with a rest, with an impossible length, or not in plain CDR.
    pub malformed: u64,
    /// The error of the last malformed message.
    pub last_error: Option<String>,
    /// Gaps between messages that were longer than the deadline, while a publisher matched.
    pub late: u64,
}

/// Settings of a subscription.
#[derive(Clone, Default)]
pub struct SubscriptionOptions {
    /// Quality of service.
    pub qos: Qos,
    /// `true` to leave out the messages of this node's own publishers.
    pub ignores_own: bool,
    /// Called after a message has been put into the queue.
    pub waker: Option<Waker>,
}

impl From<Qos> for SubscriptionOptions {
    fn from(qos: Qos) -> Self {
        Self {
            qos,
            ..Self::default()
        }
    }
}

/// A message with its origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Received {
    /// The message.
    pub message: Datum,
    /// The writer that sent it.
    pub writer: Gid,
    /// Its number, counted by the writer from 1.
    pub sequence: i64,
    /// Time of its writing, in nanoseconds of the writer's clock; `None` if the writer does not state it.
    pub written: Option<u64>,
    /// Time at which this node received it.
    pub arrived: Instant,
}

/// Receives the messages of a topic.
pub struct Subscription {
    pub(crate) inner: Arc<Inner>,
    pub(crate) gid: Gid,
    pub(crate) shared: Arc<Shared>,
    pub(crate) _registration: Registration,
}

pub(crate) struct Shared {
    pub(crate) queue: Queue<Received>,
    pub(crate) counters: Counters,
    /// Set when the reader is created, if it has a deadline.
    pub(crate) deadline: OnceLock<Arc<DeadlineWatch>>,
}

/// Counters that the thread of the node writes.
#[derive(Default)]
pub(crate) struct Counters {
    pub(crate) received: AtomicU64,
    pub(crate) lost: AtomicU64,
    pub(crate) malformed: AtomicU64,
    pub(crate) last_error: Mutex<Option<String>>,
}

impl Counters {
    pub(crate) fn malformed(&self, error: &dyn std::fmt::Display) {
        self.malformed.fetch_add(1, Ordering::Relaxed);
        let mut last = self
            .last_error
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        *last = Some(error.to_string());
    }
}

impl Subscription {
    /// Takes the oldest message from the queue.
    pub fn take(&self) -> Option<Received> {
        self.shared.queue.take()
    }

    /// Waits for a message, at most for `longest`. Not for cycles of components, which do not wait.
    pub fn wait(&self, longest: Duration) -> Option<Received> {
        self.shared.queue.wait(longest)
    }

    /// Number of publishers that match.
    pub fn matches(&self) -> usize {
        self.inner.graph.lock().matches(self.gid)
    }

    /// Waits until this many publishers match, at most for `longest`; returns whether they do.
    pub fn wait_for_matches(&self, count: usize, longest: Duration) -> bool {
        let enough = |graph: &Graph| graph.matches(self.gid) >= count;
        self.inner.graph.wait(longest, enough)
    }

    /// The numbers of messages.
    pub fn counts(&self) -> SubscriptionCounts {
        let Counters {
            received,
            lost,
            malformed,
            last_error,
        } = &self.shared.counters;
        SubscriptionCounts {
            received: received.load(Ordering::Relaxed),
            dropped: self.shared.queue.dropped(),
            lost: lost.load(Ordering::Relaxed),
            malformed: malformed.load(Ordering::Relaxed),
            last_error: last_error
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .clone(),
            late: self.shared.deadline.get().map_or(0, |it| it.missed()),
        }
    }

    /// A number that changes whenever an endpoint of a peer is found or lost.
    pub fn graph_revision(&self) -> u64 {
        self.inner.graph.lock().revision()
    }

    /// The topics of ROS that peers publish and whose absolute names begin with this text, with the participants.
    pub fn topics_of_peers(&self, prefix: &str) -> Vec<(String, [u8; 12])> {
        let prefix = names::topic(prefix);
        let graph = self.inner.graph.lock();
        let found = graph.written(&prefix);
        let of_ros = found.filter_map(|(topic, participant)| {
            let topic = topic.strip_prefix(names::TOPIC)?;
            Some((topic.to_owned(), participant))
        });
        of_ros.collect()
    }

    /// The name of the node, with its namespace, that has an endpoint; `None` if no peer has published it yet.
    pub fn node_of(&self, endpoint: Gid) -> Option<String> {
        self.inner.graph.lock().node_of(endpoint)
    }

    /// The id of the reader.
    pub fn gid(&self) -> Gid {
        self.gid
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        self.inner.forget(self.gid);
    }
}

/// Decodes the messages of a topic.
pub(crate) struct Decoder {
    pub(crate) schema: Schema,
    pub(crate) shared: Arc<Shared>,
    /// The number of the last message of each writer.
    pub(crate) last: BTreeMap<Gid, i64>,
    /// The participant whose messages are left out.
    pub(crate) ignored: Option<[u8; 12]>,
    pub(crate) waker: Option<Waker>,
}

/// Most writers whose numbers are followed. Beyond it, all are forgotten, and lost messages are missed once.
const MOST_WRITERS: usize = 1024;

impl Decoder {
    fn follow(&mut self, writer: Gid, sequence: i64) {
        if self.last.len() >= MOST_WRITERS {
            self.last.clear();
        }
        let before = self.last.insert(writer, sequence);
        let gap = before.map_or(0, |before| {
            sequence.saturating_sub(before).saturating_sub(1)
        });
        if let Ok(gap) = u64::try_from(gap) {
            self.shared.counters.lost.fetch_add(gap, Ordering::Relaxed);
        }
    }
}

impl Sink for Decoder {
    fn message(&mut self, incoming: Incoming) {
        let (writer, sequence) = (incoming.writer, incoming.sequence);
        if self.ignored == Some(writer.participant()) {
            return;
        }
        self.follow(writer, sequence);
        if let Some(deadline) = self.shared.deadline.get() {
            deadline.arrived();
        }
        match Codec::Cdr.decode(&incoming.payload.0, &self.schema) {
            Ok(message) => {
                self.shared
                    .counters
                    .received
                    .fetch_add(1, Ordering::Relaxed);
                self.shared.queue.push(Received {
                    message,
                    writer,
                    sequence,
                    written: incoming.written,
                    arrived: Instant::now(),
                });
                if let Some(waker) = &self.waker {
                    waker();
                }
            }
            Err(error) => self.shared.counters.malformed(&error),
        }
    }

    fn unreadable(&mut self) {
        let error = "the message is not in plain CDR (XCDR version 1)";
        self.shared.counters.malformed(&error);
    }
}
