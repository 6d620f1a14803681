//! Servers: requests in a queue, replies when they are ready.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_datum::{Codec, Datum};
use asmotion_ros_interface::InterfaceName;
use rustdds::bytes::Bytes;
use rustdds::{GUID, SampleIdentity};

use super::{Part, ServiceType, qos};
use crate::error::{EndpointError, SendError};
use crate::gid::Gid;
use crate::graph::SharedGraph;
use crate::mapping::{CycloneHeader, ServiceMapping};
use crate::names;
use crate::node::Node;
use crate::notice::Waker;
use crate::outbox::Outbox;
use crate::participant::Inner;
use crate::queue::Queue;
use crate::reactor::{Chore, Incoming, Registration, Sink};

/// Longest time for which a reply waits until the reader of its client matches.
const LONGEST_WAIT: Duration = Duration::from_secs(2);
/// Most replies that wait.
const MOST_REPLIES: usize = 256;

/// Numbers of requests of a server.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ServerCounts {
    /// Requests put into the queue.
    pub received: u64,
    /// Requests dropped because the queue was full.
    pub dropped: u64,
    /// Messages that are not requests of this service, for example those of a client with the other mapping.
    pub malformed: u64,
    /// The error of the last malformed request.
    pub last_error: Option<String>,
    /// Replies given to DDS.
    pub replied: u64,
    /// Replies dropped because the client had left or did not match.
    pub unreachable: u64,
}

/// A request.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The data of the request.
    pub request: Datum,
    /// The address for the reply.
    pub reply_to: ReplyTo,
}

/// The address for the reply to a request.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplyTo {
    client: Gid,
    identity: Identity,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Identity {
    Cyclone(CycloneHeader),
    Enhanced(SampleIdentity),
}

impl ReplyTo {
    /// The writer of the request.
    pub fn client(&self) -> Gid {
        self.client
    }
}

/// Offers a service.
pub struct Server {
    inner: Arc<Inner>,
    shared: Arc<Shared>,
    requests: Gid,
    response: Part,
    _registration: Registration,
}

struct Shared {
    mapping: ServiceMapping,
    request: Part,
    outbox: Arc<Outbox>,
    graph: Arc<SharedGraph>,
    queue: Queue<Request>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    waiting: VecDeque<Reply>,
    counts: ServerCounts,
}

struct Reply {
    client: Gid,
    bytes: Bytes,
    related: Option<SampleIdentity>,
    since: Instant,
}

impl Node {
    /// Offers a service, with a queue for `depth` requests. Names as for [`publisher`](Self::publisher).
    ///
    /// # Errors
    /// The name is not valid, the type is not a service that is defined, or DDS refuses.
    pub fn server(
        &self,
        service: &str,
        of: &InterfaceName,
        mapping: ServiceMapping,
        depth: usize,
    ) -> Result<Server, EndpointError> {
        let inner = self.inner();
        let name = inner.absolute(service)?;
        Server::new(inner, &name, ServiceType::of(inner, of)?, mapping, depth)
    }
}

impl Server {
    pub(crate) fn new(
        inner: &Arc<Inner>,
        service: &str,
        kind: ServiceType,
        mapping: ServiceMapping,
        depth: usize,
    ) -> Result<Self, EndpointError> {
        let (requests, replies) = names::service(service);
        let response = kind.response;
        let outbox = inner.writer(&replies, &response.type_name, qos(), kind.hash.clone())?;
        let type_name = kind.request.type_name.clone();
        let shared = Arc::new(Shared {
            mapping,
            request: kind.request,
            outbox,
            graph: Arc::clone(&inner.graph),
            queue: Queue::new(depth),
            state: Mutex::default(),
        });
        let chore: Arc<dyn Chore> = Arc::clone(&shared) as Arc<dyn Chore>;
        inner.reactor.add_chore(Arc::downgrade(&chore));
        let sink = Box::new(Requests(Arc::clone(&shared)));
        let (requests, registration) =
            inner.reader(&requests, &type_name, qos(), kind.hash, |_| sink)?;
        Ok(Self {
            inner: Arc::clone(inner),
            shared,
            requests,
            response,
            _registration: registration,
        })
    }

    /// Sets what is called after a request has been put into the queue.
    pub fn wake_with(&self, waker: Waker) {
        self.shared.queue.set_waker(waker);
    }

    /// Takes the oldest request from the queue.
    pub fn take(&self) -> Option<Request> {
        self.shared.queue.take()
    }

    /// Waits for a request, at most for `longest`. Not for cycles of components, which do not wait.
    pub fn wait(&self, longest: Duration) -> Option<Request> {
        self.shared.queue.wait(longest)
    }

    /// Replies to a request. Never waits: the reply is sent when the client's reader matches, at most two seconds later.
    ///
    /// # Errors
    /// The datum does not fit the response of the service.
    pub fn reply(&self, to: &ReplyTo, response: &Datum) -> Result<(), SendError> {
        let bytes: Bytes = Codec::Cdr.encode(response, &self.response.schema)?.into();
        let (bytes, related) = match to.identity {
            Identity::Cyclone(header) => (header.put_before(&bytes), None),
            Identity::Enhanced(identity) => (bytes, Some(identity)),
        };
        let mut state = self.shared.lock();
        if state.waiting.len() >= MOST_REPLIES {
            state.waiting.pop_front();
            state.counts.unreachable += 1;
        }
        state.waiting.push_back(Reply {
            client: to.client,
            bytes,
            related,
            since: Instant::now(),
        });
        drop(state);
        if self.shared.run() {
            self.inner.reactor.wake();
        }
        Ok(())
    }

    /// The numbers of requests.
    pub fn counts(&self) -> ServerCounts {
        ServerCounts {
            dropped: self.shared.queue.dropped(),
            ..self.shared.lock().counts.clone()
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.inner.forget(self.shared.outbox.gid);
        self.inner.forget(self.requests);
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn malformed(&self, error: impl ToString) {
        let counts = &mut self.lock().counts;
        counts.malformed += 1;
        counts.last_error = Some(error.to_string());
    }

    fn received(&self, incoming: &Incoming) {
        let vendor = self.graph.lock().vendor(incoming.writer);
        let (identity, body) = match self.mapping.for_vendor(vendor) {
            ServiceMapping::Cyclone => match CycloneHeader::take_from(&incoming.payload.0) {
                Some((header, body)) => (Identity::Cyclone(header), body),
                None => {
                    return self.malformed("the request is too short for the header of Cyclone");
                }
            },
            ServiceMapping::Enhanced | ServiceMapping::OfPeer => {
                let identity = Identity::Enhanced(request_identity(incoming));
                (identity, incoming.payload.0.to_vec())
            }
        };
        match Codec::Cdr.decode(&body, &self.request.schema) {
            Ok(request) => {
                self.lock().counts.received += 1;
                self.queue.push(Request {
                    request,
                    reply_to: ReplyTo {
                        client: incoming.writer,
                        identity,
                    },
                });
            }
            Err(error) => self.malformed(error),
        }
    }
}

/// The identity by which the client recognises the reply: the request's own, or with the writer that the client names, as
/// Fast DDS does with the reader of its replies.
fn request_identity(incoming: &Incoming) -> SampleIdentity {
    let named = incoming.related.map(|related| related.writer_guid);
    let named = named.filter(|guid| *guid != GUID::GUID_UNKNOWN);
    SampleIdentity {
        writer_guid: named.unwrap_or_else(|| GUID::from_bytes(incoming.writer.0)),
        sequence_number: incoming.sequence.into(),
    }
}

impl Chore for Shared {
    fn run(&self) -> bool {
        let mut state = self.lock();
        if state.waiting.is_empty() {
            return self.outbox.is_waiting();
        }
        let graph = self.graph.lock();
        let matched = graph.matched(self.outbox.gid);
        let matched: Vec<_> = matched.map(|(gid, _)| gid.participant()).collect();
        drop(graph);
        for reply in std::mem::take(&mut state.waiting) {
            if matched.contains(&reply.client.participant()) {
                match self.outbox.send(reply.bytes, reply.related) {
                    Ok(()) => state.counts.replied += 1,
                    Err(_) => state.counts.unreachable += 1,
                }
            } else if reply.since.elapsed() > LONGEST_WAIT {
                state.counts.unreachable += 1;
            } else {
                state.waiting.push_back(reply);
            }
        }
        !state.waiting.is_empty() || self.outbox.is_waiting()
    }
}

struct Requests(Arc<Shared>);

impl Sink for Requests {
    fn message(&mut self, incoming: Incoming) {
        self.0.received(&incoming);
    }

    fn unreadable(&mut self) {
        self.0.malformed("the request is not in plain CDR");
    }
}
