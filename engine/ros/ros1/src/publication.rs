//! A topic that the node publishes: its subscribers, each with a bounded queue and a task of its own, so that one that does not
//! read delays no other.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tokio::time::timeout;

use crate::context::{Context, lock};
use crate::header::ConnectionHeader;
use crate::interface::{ANY, TopicType};
use crate::names::RosName;
use crate::notice::{RosNotice, StatedType, TypeMismatch};

/// Counts of a publisher's messages.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RosPublisherCounts {
    /// Messages published.
    pub published: u64,
    /// Messages published while there was no subscriber.
    pub unrouted: u64,
    /// Messages written to connections, of all subscribers.
    pub sent: u64,
    /// Messages dropped because the queue of a subscriber was full or its connection ended.
    pub dropped: u64,
    /// Connections refused because of another type.
    pub refused: u64,
    /// Present subscribers.
    pub subscribers: Vec<SubscriberCounts>,
}

/// Counts of one subscriber's messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SubscriberCounts {
    /// Name of the node.
    pub node: Arc<str>,
    /// Messages written to the connection.
    pub sent: u64,
    /// Messages dropped because the queue was full.
    pub dropped: u64,
    /// Messages in the queue.
    pub waiting: usize,
}

/// A topic that the node publishes.
pub(crate) struct Publication {
    pub(crate) topic: RosName,
    pub(crate) of: TopicType,
    size: usize,
    is_latched: bool,
    peers: Mutex<Peers>,
    published: AtomicU64,
    unrouted: AtomicU64,
    refused: AtomicU64,
}

#[derive(Default)]
struct Peers {
    all: Vec<Arc<Peer>>,
    /// The last message of a latched topic.
    last: Option<Arc<[u8]>>,
    /// Set when the publisher is dropped.
    is_closed: bool,
    /// Counts of those that left.
    sent: u64,
    dropped: u64,
}

/// A subscriber.
struct Peer {
    node: Arc<str>,
    queue: Mutex<VecDeque<Arc<[u8]>>>,
    /// A message that was in the queue is being written. Set under the lock of the queue.
    is_writing: AtomicBool,
    filled: Notify,
    is_closed: AtomicBool,
    sent: AtomicU64,
    dropped: AtomicU64,
}

impl Peer {
    /// Appends a message, and drops the oldest one if there are too many.
    fn push(&self, message: Arc<[u8]>, size: usize) {
        let mut queue = lock(&self.queue);
        while queue.len() >= size {
            queue.pop_front();
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
        queue.push_back(message);
        drop(queue);
        self.filled.notify_one();
    }

    /// Removes the oldest message, which is being written from then on.
    fn begin_write(&self) -> Option<Arc<[u8]>> {
        let mut queue = lock(&self.queue);
        let next = queue.pop_front();
        self.is_writing.store(next.is_some(), Ordering::Release);
        next
    }

    /// Whether all messages have been written.
    fn is_idle(&self) -> bool {
        let queue = lock(&self.queue);
        queue.is_empty() && !self.is_writing.load(Ordering::Acquire)
    }

    fn close(&self) {
        self.is_closed.store(true, Ordering::Release);
        self.filled.notify_one();
    }
}

impl Publication {
    pub(crate) fn new(topic: RosName, of: TopicType, size: usize, is_latched: bool) -> Self {
        Self {
            topic,
            of,
            size: size.max(1),
            is_latched,
            peers: Mutex::default(),
            published: AtomicU64::new(0),
            unrouted: AtomicU64::new(0),
            refused: AtomicU64::new(0),
        }
    }

    /// Gives a message with its length to all subscribers.
    pub(crate) fn send(&self, frame: Arc<[u8]>) {
        self.published.fetch_add(1, Ordering::Relaxed);
        let mut peers = lock(&self.peers);
        if peers.all.is_empty() {
            self.unrouted.fetch_add(1, Ordering::Relaxed);
        }
        for peer in &peers.all {
            peer.push(Arc::clone(&frame), self.size);
        }
        if self.is_latched {
            peers.last = Some(frame);
        }
    }

    /// Ends all connections, after the messages in the queues.
    pub(crate) fn close(&self) {
        let mut peers = lock(&self.peers);
        peers.is_closed = true;
        peers.all.iter().for_each(|peer| peer.close());
    }

    /// Whether all messages have been written to the connections of present subscribers.
    pub(crate) fn is_idle(&self) -> bool {
        lock(&self.peers).all.iter().all(|peer| peer.is_idle())
    }

    pub(crate) fn counts(&self) -> RosPublisherCounts {
        let peers = lock(&self.peers);
        let subscribers: Vec<SubscriberCounts> = peers
            .all
            .iter()
            .map(|peer| SubscriberCounts {
                node: Arc::clone(&peer.node),
                sent: peer.sent.load(Ordering::Relaxed),
                dropped: peer.dropped.load(Ordering::Relaxed),
                waiting: lock(&peer.queue).len(),
            })
            .collect();
        RosPublisherCounts {
            published: self.published.load(Ordering::Relaxed),
            unrouted: self.unrouted.load(Ordering::Relaxed),
            sent: peers.sent + subscribers.iter().map(|it| it.sent).sum::<u64>(),
            dropped: peers.dropped + subscribers.iter().map(|it| it.dropped).sum::<u64>(),
            refused: self.refused.load(Ordering::Relaxed),
            subscribers,
        }
    }

    /// Serves a subscriber, whose header has been read, until it leaves.
    pub(crate) async fn serve(
        &self,
        context: &Context,
        mut stream: TcpStream,
        header: &ConnectionHeader,
    ) -> Result<(), String> {
        let node: Arc<str> = header.get("callerid").unwrap_or("(unnamed)").into();
        if let Some(mismatch) = self.mismatch(context, &node, header) {
            self.refused.fetch_add(1, Ordering::Relaxed);
            let text = mismatch.to_string();
            context.report(RosNotice::Mismatch(Box::new(mismatch)));
            let error = ConnectionHeader::new().with("error", text);
            let limit = context.settings.timing.connect;
            let _ = timeout(limit, stream.write_all(&error.encode())).await;
            return Ok(());
        }
        let accepted = ConnectionHeader::new()
            .with("callerid", context.name.shared())
            .with("topic", self.topic.shared())
            .with("type", Arc::clone(&self.of.name))
            .with("md5sum", Arc::clone(&self.of.md5))
            .with("message_definition", Arc::clone(&self.of.definition))
            .with("latching", if self.is_latched { "1" } else { "0" })
            .with("tcp_nodelay", "1");
        // messages are written whole, so waiting for more gains nothing
        let _ = stream.set_nodelay(true);
        let (limit, accepted) = (context.settings.timing.connect, accepted.encode());
        let written = timeout(limit, stream.write_all(&accepted)).await;
        let written = written.map_err(|_| "it does not read the header")?;
        written.map_err(|error| error.to_string())?;
        let peer = Arc::new(Peer {
            node,
            queue: Mutex::default(),
            is_writing: AtomicBool::new(false),
            filled: Notify::new(),
            is_closed: AtomicBool::new(false),
            sent: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
        });
        {
            let mut peers = lock(&self.peers);
            if peers.is_closed {
                return Ok(());
            }
            // under the lock, so that the next message comes after it
            if let Some(last) = &peers.last {
                peer.push(Arc::clone(last), self.size);
            }
            peers.all.push(Arc::clone(&peer));
        }
        let ended = write_messages(context, &peer, stream).await;
        let mut peers = lock(&self.peers);
        peers.all.retain(|it| !Arc::ptr_eq(it, &peer));
        peers.sent += peer.sent.load(Ordering::Relaxed);
        peers.dropped += peer.dropped.load(Ordering::Relaxed) + lock(&peer.queue).len() as u64;
        ended
    }

    fn mismatch(
        &self,
        context: &Context,
        node: &Arc<str>,
        header: &ConnectionHeader,
    ) -> Option<TypeMismatch> {
        let md5 = header.get("md5sum").unwrap_or_default();
        let name = header.get("type").unwrap_or(ANY);
        let same = [(md5, &*self.of.md5), (name, &*self.of.name)];
        if same
            .iter()
            .all(|(there, here)| *there == ANY || there == here)
        {
            return None;
        }
        Some(TypeMismatch {
            of: self.topic.shared(),
            here: StatedType {
                node: context.name.shared(),
                name: Arc::clone(&self.of.name),
                md5: Arc::clone(&self.of.md5),
                definition: Arc::clone(&self.of.definition),
            },
            there: stated(node, header),
        })
    }
}

/// The type that a header states.
pub(crate) fn stated(node: &Arc<str>, header: &ConnectionHeader) -> StatedType {
    let field = |name| Arc::from(header.get(name).unwrap_or_default());
    StatedType {
        node: Arc::clone(node),
        name: field("type"),
        md5: field("md5sum"),
        definition: field("message_definition"),
    }
}

/// Writes the messages of a subscriber until the connection ends.
async fn write_messages(context: &Context, peer: &Peer, stream: TcpStream) -> Result<(), String> {
    let (mut from, mut to) = stream.into_split();
    let writing = async {
        loop {
            let Some(message) = peer.begin_write() else {
                if peer.is_closed.load(Ordering::Acquire) {
                    return Ok(());
                }
                peer.filled.notified().await;
                continue;
            };
            let stall = context.settings.timing.stall;
            let written = timeout(stall, to.write_all(&message)).await;
            match written {
                Ok(Ok(())) => peer.sent.fetch_add(1, Ordering::Relaxed),
                Ok(Err(error)) => {
                    peer.dropped.fetch_add(1, Ordering::Relaxed);
                    return Err(error.to_string());
                }
                Err(_) => {
                    peer.dropped.fetch_add(1, Ordering::Relaxed);
                    return Err(format!("it has read nothing for {stall:?}"));
                }
            };
        }
    };
    let reading = async {
        // a subscriber sends nothing; what it sends is discarded, its end is noticed
        let mut scratch = [0; 256];
        while matches!(from.read(&mut scratch).await, Ok(read) if read > 0) {}
    };
    tokio::select! {
        ended = writing => ended,
        () = reading => Ok(()),
        () = context.until_end() => Ok(()),
    }
}
