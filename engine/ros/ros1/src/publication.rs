//! A topic that the node publishes: its subscribers, each with a bounded queue and a task of its own, so that one that does not
//! read delays no other.
//!
//! The thread that publishes writes a message to the socket itself, as far as the socket takes it without waiting: to wake the task
//! would cost more than to write. What remains waits in the queue for the task.

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
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

/// A message with its length, which all subscribers share. A slice would be a copy of it.
pub(crate) type Frame = Arc<Vec<u8>>;

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
    last: Option<Frame>,
    /// Set when the publisher is dropped.
    is_closed: bool,
    /// Counts of those that left.
    sent: u64,
    dropped: u64,
}

/// A subscriber.
struct Peer {
    node: Arc<str>,
    stream: OwnedWriteHalf,
    outgoing: Mutex<Outgoing>,
    /// Notified when a message waits for the task.
    filled: Notify,
    is_closed: AtomicBool,
    sent: AtomicU64,
    dropped: AtomicU64,
}

/// Messages on their way to a subscriber. Its lock is held during a write, which does not wait, so that messages keep their order.
#[derive(Default)]
struct Outgoing {
    /// A message of which the socket has not taken all, and the number of bytes that it has taken.
    begun: Option<(Frame, usize)>,
    queue: VecDeque<Frame>,
}

impl Outgoing {
    fn is_empty(&self) -> bool {
        self.begun.is_none() && self.queue.is_empty()
    }
}

impl Peer {
    fn new(node: Arc<str>, stream: OwnedWriteHalf) -> Self {
        Self {
            node,
            stream,
            outgoing: Mutex::default(),
            filled: Notify::new(),
            is_closed: AtomicBool::new(false),
            sent: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
        }
    }

    /// Writes a message if no other waits and the socket takes it; else appends it, and drops the oldest one if there are too many.
    fn push(&self, message: Frame, size: usize) {
        let mut outgoing = lock(&self.outgoing);
        if outgoing.is_empty() {
            outgoing.begun = Some((message, 0));
            // the task meets an error again, and ends the connection
            let _ = self.write(&mut outgoing);
            if outgoing.is_empty() {
                return;
            }
        } else {
            while outgoing.queue.len() >= size {
                outgoing.queue.pop_front();
                self.dropped.fetch_add(1, Ordering::Relaxed);
            }
            outgoing.queue.push_back(message);
        }
        drop(outgoing);
        self.filled.notify_one();
    }

    /// Writes messages until the socket takes no more. Returns the number of bytes.
    fn write(&self, outgoing: &mut Outgoing) -> io::Result<usize> {
        let mut total = 0;
        loop {
            if outgoing.begun.is_none() {
                outgoing.begun = outgoing.queue.pop_front().map(|message| (message, 0));
            }
            let Some((message, written)) = &mut outgoing.begun else {
                return Ok(total);
            };
            let rest = message.get(*written..).unwrap_or_default();
            match self.stream.try_write(rest) {
                Ok(count) => {
                    total += count;
                    *written += count;
                    if *written >= message.len() {
                        outgoing.begun = None;
                        self.sent.fetch_add(1, Ordering::Relaxed);
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(total),
                Err(error) => return Err(error),
            }
        }
    }

    /// Whether all messages have been written.
    fn is_idle(&self) -> bool {
        lock(&self.outgoing).is_empty()
    }

    /// Messages in the queue.
    fn waiting(&self) -> usize {
        lock(&self.outgoing).queue.len()
    }

    /// Messages that have not been written, or not whole.
    fn unwritten(&self) -> usize {
        let outgoing = lock(&self.outgoing);
        outgoing.queue.len() + usize::from(outgoing.begun.is_some())
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
    pub(crate) fn send(&self, frame: Frame) {
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

    /// Messages dropped so far.
    pub(crate) fn dropped(&self) -> u64 {
        let peers = lock(&self.peers);
        let present = peers.all.iter();
        let present = present.map(|it| it.dropped.load(Ordering::Relaxed));
        peers.dropped + present.sum::<u64>()
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
                waiting: peer.waiting(),
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
        let accepted = context.relays.announce(&self.topic, accepted);
        // messages are written whole, so waiting for more gains nothing
        let _ = stream.set_nodelay(true);
        let (limit, accepted) = (context.settings.timing.connect, accepted.encode());
        let written = timeout(limit, stream.write_all(&accepted)).await;
        let written = written.map_err(|_| "it does not read the header")?;
        written.map_err(|error| error.to_string())?;
        let (from, to) = stream.into_split();
        let peer = Arc::new(Peer::new(node, to));
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
        let ended = write_messages(context, &peer, from).await;
        let mut peers = lock(&self.peers);
        peers.all.retain(|it| !Arc::ptr_eq(it, &peer));
        peers.sent += peer.sent.load(Ordering::Relaxed);
        peers.dropped += peer.dropped.load(Ordering::Relaxed) + peer.unwritten() as u64;
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

/// Writes the messages that wait for a subscriber until the connection ends.
async fn write_messages(
    context: &Context,
    peer: &Peer,
    mut from: OwnedReadHalf,
) -> Result<(), String> {
    let writing = async {
        let stall = context.settings.timing.stall;
        loop {
            if peer.is_idle() {
                if peer.is_closed.load(Ordering::Acquire) {
                    return Ok(());
                }
                peer.filled.notified().await;
                continue;
            }
            match timeout(stall, peer.stream.writable()).await {
                Ok(ready) => ready.map_err(|error| error.to_string())?,
                Err(_) => return Err(format!("it has read nothing for {stall:?}")),
            }
            let written = peer.write(&mut lock(&peer.outgoing));
            written.map_err(|error| error.to_string())?;
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
