//! A topic that the node subscribes to: a connection and a task for each publisher, and any number of observers.

use std::collections::{BTreeMap, BTreeSet};
use std::future::{Future as _, poll_fn};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::task::Poll;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use asmotion_bus::{Envelope, Payload, Standstills, SubscriptionSender};
use asmotion_datum::{Datum, ros1};
use tokio::io::{AsyncBufReadExt as _, AsyncWriteExt, BufReader};
use tokio::net::TcpStream;
use tokio::runtime::Handle;
use tokio::task::AbortHandle;
use tokio::task::coop::unconstrained;
use tokio::time::{sleep, timeout};

use crate::circle::longer_circle;
use crate::context::{Context, MasterAnswer, lock};
use crate::frame::{FrameError, read_frame, read_header};
use crate::header::ConnectionHeader;
use crate::http::RosUri;
use crate::interface::{ANY, TopicType};
use crate::names::RosName;
use crate::notice::{RosNotice, StatedType, TypeMismatch};
use crate::publication::stated;
use crate::settings::Retry;
use crate::xmlrpc::XmlRpcValue;

/// A connection that lasts this long was a good one: the delays before the next begin anew.
const GOOD: Duration = Duration::from_secs(1);
/// Bytes that are read from a connection at once.
const BUFFER: usize = 64 << 10;

/// Counts of a subscribed topic, of all its publishers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RosSubscriptionCounts {
    /// Messages received.
    pub received: u64,
    /// Messages that could not be decoded, or were too large.
    pub unreadable: u64,
    /// Connections that were not made because of another type.
    pub refused: u64,
    /// Connections that failed or ended.
    pub disconnected: u64,
    /// Panics of an observer's notifier, which is notified no longer.
    pub panicked: u64,
    /// Present connections.
    pub publishers: usize,
}

/// The number of messages of a topic that could not be decoded, or were too large: quick to read, also after every message.
pub struct UnreadableMessages(pub(crate) Arc<TopicSubscription>);

impl UnreadableMessages {
    /// The number so far.
    pub fn count(&self) -> u64 {
        self.0.unreadable.load(Ordering::Relaxed)
    }
}

impl std::fmt::Debug for UnreadableMessages {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of `{}`", self.count(), self.0.topic)
    }
}

/// A topic that the node subscribes to.
pub(crate) struct TopicSubscription {
    pub(crate) topic: RosName,
    /// `None` for the type of the publisher, whatever it is.
    pub(crate) of: Option<TopicType>,
    observers: Mutex<Vec<SubscriptionSender>>,
    connections: Mutex<BTreeMap<RosUri, PublisherConnection>>,
    lives: AtomicU64,
    received: AtomicU64,
    unreadable: AtomicU64,
    refused: AtomicU64,
    disconnected: AtomicU64,
    panicked: AtomicU64,
}

/// The task that receives from a publisher.
struct PublisherConnection {
    task: AbortHandle,
    /// Set by the task while the connection is up.
    is_up: Arc<AtomicBool>,
}

/// Why there is no connection.
enum Broken {
    /// For display.
    Reason(String),
    Mismatch(Box<TypeMismatch>),
}

impl From<String> for Broken {
    fn from(reason: String) -> Self {
        Self::Reason(reason)
    }
}

impl TopicSubscription {
    pub(crate) fn new(topic: RosName, of: Option<TopicType>) -> Self {
        Self {
            topic,
            of,
            observers: Mutex::default(),
            connections: Mutex::default(),
            lives: AtomicU64::new(0),
            received: AtomicU64::new(0),
            unreadable: AtomicU64::new(0),
            refused: AtomicU64::new(0),
            disconnected: AtomicU64::new(0),
            panicked: AtomicU64::new(0),
        }
    }

    /// Name of the type for the master.
    pub(crate) fn type_name(&self) -> &str {
        self.of.as_ref().map_or(ANY, |of| &of.name)
    }

    pub(crate) fn add(&self, observer: SubscriptionSender) {
        lock(&self.observers).push(observer);
    }

    /// Removes an observer, and returns whether it was the last.
    pub(crate) fn remove(&self, observer: &SubscriptionSender) -> bool {
        let mut observers = lock(&self.observers);
        observers.retain(|it| !it.is_same(observer));
        observers.is_empty()
    }

    /// Connects to these publishers, and to no others.
    pub(crate) fn update(
        self: &Arc<Self>,
        context: &Arc<Context>,
        tasks: &Handle,
        publishers: &[&str],
    ) {
        let limit = context.settings.limits.publishers;
        let mut wanted = BTreeSet::new();
        for text in publishers.iter().take(limit) {
            match text.parse::<RosUri>() {
                Ok(uri) => drop(wanted.insert(uri)),
                Err(error) => self.report_list(context, error.to_string()),
            }
        }
        if publishers.len() > limit {
            let count = publishers.len();
            self.report_list(context, format!("{count} publishers; the limit is {limit}"));
        }
        let mut connections = lock(&self.connections);
        connections.retain(|uri, connection| {
            let is_kept = wanted.contains(uri);
            if !is_kept {
                connection.task.abort();
            }
            is_kept
        });
        for uri in wanted {
            let follow = || {
                let is_up = Arc::new(AtomicBool::new(false));
                let publisher = (uri.clone(), Arc::clone(&is_up));
                let following = follow(Arc::clone(context), Arc::clone(self), publisher);
                let task = tasks.spawn(following).abort_handle();
                PublisherConnection { task, is_up }
            };
            connections.entry(uri.clone()).or_insert_with(follow);
        }
    }

    fn report_list(&self, context: &Context, reason: String) {
        context.report(RosNotice::Unreadable {
            of: format!("the publishers of `{}`", self.topic),
            peer: context.settings.master.to_string(),
            reason,
        });
    }

    /// Ends all connections.
    pub(crate) fn close(&self) {
        let connections = std::mem::take(&mut *lock(&self.connections));
        connections.values().for_each(|it| it.task.abort());
    }

    pub(crate) fn counts(&self) -> RosSubscriptionCounts {
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        RosSubscriptionCounts {
            received: count(&self.received),
            unreadable: count(&self.unreadable),
            refused: count(&self.refused),
            disconnected: count(&self.disconnected),
            panicked: count(&self.panicked),
            publishers: self.publishers().len(),
        }
    }

    /// Addresses of the publishers with which a connection is up.
    pub(crate) fn publishers(&self) -> Vec<RosUri> {
        let connections = lock(&self.connections);
        let up = connections
            .iter()
            .filter(|(_, it)| it.is_up.load(Ordering::Acquire));
        up.map(|(uri, _)| uri.clone()).collect()
    }

    /// Gives a message to all observers. One whose notifier panics receives no more.
    fn pass_on(&self, envelope: Envelope) {
        self.received.fetch_add(1, Ordering::Relaxed);
        let observers = lock(&self.observers).clone();
        // one for each; the last gets the envelope itself, so that a single reader can take the message out of it
        let envelopes = std::iter::repeat_n(envelope, observers.len());
        for (observer, envelope) in observers.into_iter().zip(envelopes) {
            let push = AssertUnwindSafe(|| observer.push(envelope));
            if catch_unwind(push).is_err() {
                self.panicked.fetch_add(1, Ordering::Relaxed);
                self.remove(&observer);
            }
        }
    }

    /// Receives from a publisher until the connection ends.
    async fn receive(
        &self,
        context: &Context,
        uri: &RosUri,
        is_up: &AtomicBool,
    ) -> Result<(), Broken> {
        let (mut stream, header) = self.connect(context, uri).await?;
        let circle = match context.relays.circle(&self.topic, &header) {
            None => longer_circle(context, &self.topic, &header).await,
            circle => circle,
        };
        if let Some(reason) = circle {
            return Err(Broken::Reason(reason));
        }
        let source: Arc<str> = header.get("callerid").unwrap_or("(unnamed)").into();
        let of = self.type_of(&header)?;
        is_up.store(true, Ordering::Release);
        let mut envelope = Envelope {
            topic: self.topic.shared(),
            source,
            incarnation: self.lives.fetch_add(1, Ordering::Relaxed) + 1,
            sequence: 0,
            stamp: 0,
            clock: "".into(),
            age: Duration::ZERO,
            trace: None,
            type_name: Arc::clone(&of.name),
            payload: Payload::of(Datum::Null),
        };
        let mut is_reported = false;
        let mut arrivals = Arrivals::new();
        loop {
            arrivals.look(&mut stream).await;
            let message = read_frame(&mut stream, context.settings.limits.message).await;
            let message = message.map_err(|error| {
                match error {
                    FrameError::TooLarge { .. } | FrameError::Truncated { .. } => {
                        self.unreadable.fetch_add(1, Ordering::Relaxed);
                    }
                    FrameError::Connection(_) => {}
                }
                error.to_string()
            })?;
            envelope.sequence += 1;
            match ros1::decode(&message, &of.schema) {
                Ok(datum) => {
                    envelope.stamp = now();
                    envelope.age = arrivals.waited();
                    self.pass_on(Envelope {
                        payload: Payload::of(datum),
                        ..envelope.clone()
                    });
                    context.note_read();
                }
                Err(error) => {
                    self.unreadable.fetch_add(1, Ordering::Relaxed);
                    // once for each connection: a faulty publisher does not flood the log
                    if !std::mem::replace(&mut is_reported, true) {
                        context.report(RosNotice::Unreadable {
                            of: format!("a message on `{}`", self.topic),
                            peer: envelope.source.to_string(),
                            reason: error.to_string(),
                        });
                    }
                }
            }
        }
    }

    /// The type of the subscription, or that of a publisher.
    fn type_of(&self, header: &ConnectionHeader) -> Result<TopicType, String> {
        if let Some(of) = &self.of {
            return Ok(of.clone());
        }
        let field = |name| header.get(name).unwrap_or_default();
        TopicType::of_definition(field("type"), field("md5sum"), field("message_definition"))
    }

    /// Connects to a publisher, and exchanges headers.
    async fn connect(
        &self,
        context: &Context,
        uri: &RosUri,
    ) -> Result<(BufReader<TcpStream>, ConnectionHeader), Broken> {
        let (stream, header) = self.introduce(context, uri, self.of.as_ref()).await?;
        let Some(of) = &self.of else {
            return match header.get("error") {
                Some(error) => Err(Broken::Reason(error.to_owned())),
                None => Ok((stream, header)),
            };
        };
        let Some(error) = header.get("error") else {
            return match self.mismatch(context, uri, of, &header) {
                Some(mismatch) => Err(Broken::Mismatch(Box::new(mismatch))),
                None => Ok((stream, header)),
            };
        };
        // a publisher that refuses states no type: asked for any, it does
        let (_, header) = self.introduce(context, uri, None).await?;
        match self.mismatch(context, uri, of, &header) {
            Some(mismatch) if header.get("error").is_none() => {
                Err(Broken::Mismatch(Box::new(mismatch)))
            }
            Some(_) | None => Err(Broken::Reason(error.to_owned())),
        }
    }

    async fn introduce(
        &self,
        context: &Context,
        uri: &RosUri,
        of: Option<&TopicType>,
    ) -> Result<(BufReader<TcpStream>, ConnectionHeader), String> {
        let protocol = XmlRpcValue::Array(vec![XmlRpcValue::text("TCPROS")]);
        let parameters = [
            XmlRpcValue::text(self.topic.as_str()),
            XmlRpcValue::Array(vec![protocol]),
        ];
        let answer = context.api(uri, "requestTopic", &parameters).await;
        let answer = answer.map_err(MasterAnswer::reason)?;
        let (host, port) = endpoint(&answer)
            .ok_or("requestTopic: the answer is not `[\"TCPROS\", host, port]`")?;
        let header = match of {
            Some(of) => ConnectionHeader::new()
                .with("type", Arc::clone(&of.name))
                .with("md5sum", Arc::clone(&of.md5))
                .with("message_definition", Arc::clone(&of.definition)),
            None => ConnectionHeader::new()
                .with("type", ANY)
                .with("md5sum", ANY),
        };
        let header = header
            .with("callerid", context.name.shared())
            .with("topic", self.topic.shared())
            .with("tcp_nodelay", "1");
        let exchange = async {
            let stream = TcpStream::connect((host, port)).await;
            let mut stream = stream.map_err(|error| error.to_string())?;
            let _ = stream.set_nodelay(true);
            let written = stream.write_all(&header.encode()).await;
            written.map_err(|error| error.to_string())?;
            let mut stream = BufReader::with_capacity(BUFFER, stream);
            let answer = read_header(&mut stream).await?;
            Ok((stream, answer))
        };
        let limit = context.settings.timing.connect;
        let exchanged = timeout(limit, exchange).await;
        exchanged.unwrap_or_else(|_| Err(format!("no header within {limit:?}")))
    }

    fn mismatch(
        &self,
        context: &Context,
        uri: &RosUri,
        of: &TopicType,
        header: &ConnectionHeader,
    ) -> Option<TypeMismatch> {
        let md5 = header.get("md5sum").unwrap_or_default();
        let name = header.get("type").unwrap_or(ANY);
        let same = [(md5, &*of.md5), (name, &*of.name)];
        if same
            .iter()
            .all(|(there, here)| *there == ANY || there == here)
        {
            return None;
        }
        let node: Arc<str> = match header.get("callerid") {
            Some(node) => node.into(),
            None => uri.to_string().into(),
        };
        Some(TypeMismatch {
            of: self.topic.shared(),
            here: StatedType {
                node: context.name.shared(),
                name: Arc::clone(&of.name),
                md5: Arc::clone(&of.md5),
                definition: Arc::clone(&of.definition),
            },
            there: stated(&node, header),
        })
    }
}

/// The arrivals of a connection. Messages of ROS 1 contain no time of their sending, but arrive in order: one that was not there
/// at a look came after it, and would have been read at once if this process had not stood still.
struct Arrivals {
    standstills: &'static Standstills,
    /// Last time at which nothing was there.
    empty_at: Instant,
}

impl Arrivals {
    fn new() -> Self {
        Self {
            standstills: Standstills::of_process(),
            empty_at: Instant::now(),
        }
    }

    /// Looks whether a message, or a part of one, is there.
    async fn look(&mut self, stream: &mut BufReader<TcpStream>) {
        let now = Instant::now();
        // beyond its budget, a task would find nothing
        let mut filling = std::pin::pin!(unconstrained(stream.fill_buf()));
        let is_empty = poll_fn(|context| Poll::Ready(filling.as_mut().poll(context).is_pending()));
        if is_empty.await {
            self.empty_at = now;
        }
    }

    /// Longest time for which the message that was just read may have waited.
    fn waited(&self) -> Duration {
        self.standstills.waited(self.empty_at)
    }
}

/// Host and port of `["TCPROS", host, port]`.
fn endpoint(answer: &XmlRpcValue) -> Option<(&str, u16)> {
    let [protocol, host, port] = answer.as_array()? else {
        return None;
    };
    let port = u16::try_from(port.as_int()?).ok()?;
    (protocol.as_text()? == "TCPROS").then_some((host.as_text()?, port))
}

/// Wall time, in nanoseconds since 1970.
pub(crate) fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    i64::try_from(since.unwrap_or_default().as_nanos()).unwrap_or(i64::MAX)
}

/// Receives from a publisher, again and again, until this task is aborted because the master lists it no longer.
async fn follow(
    context: Arc<Context>,
    topic: Arc<TopicSubscription>,
    (uri, is_up): (RosUri, Arc<AtomicBool>),
) {
    let mut retry = Retry::new(&context.settings.timing);
    let mut reported = None;
    loop {
        let begun = Instant::now();
        let broken = match topic.receive(&context, &uri, &is_up).await {
            Ok(()) => Broken::Reason("the connection ended".to_owned()),
            Err(broken) => broken,
        };
        if is_up.swap(false, Ordering::AcqRel) {
            topic.disconnected.fetch_add(1, Ordering::Relaxed);
        }
        if begun.elapsed() > GOOD {
            retry.reset();
            reported = None;
        }
        let notice = match broken {
            Broken::Reason(reason) => RosNotice::Disconnected {
                of: topic.topic.shared(),
                peer: uri.to_string(),
                reason,
            },
            Broken::Mismatch(mismatch) => {
                topic.refused.fetch_add(1, Ordering::Relaxed);
                RosNotice::Mismatch(mismatch)
            }
        };
        // the same once, however often it is tried
        if reported.as_ref() != Some(&notice) {
            context.report(notice.clone());
            reported = Some(notice);
        }
        sleep(retry.next_delay()).await;
    }
}
