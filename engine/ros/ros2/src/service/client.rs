//! Clients: calls with deadlines.
//!
//! Discovery is not symmetric: when both endpoints of a server match here, the server may not yet have found ours, and a request
//! sent at once would be lost without an error. DDS does not tell a participant who matches it elsewhere. A request is therefore
//! sent after both matches have lasted for [`SETTLED`].

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use asmotion_datum::{Codec, Datum};
use asmotion_ros_interface::InterfaceName;
use rustdds::bytes::Bytes;

use super::{Part, ServiceType, qos};
use crate::error::{CallError, EndpointError};
use crate::gid::Gid;
use crate::graph::{Graph, SharedGraph};
use crate::mapping::{CycloneHeader, ServiceMapping};
use crate::names;
use crate::node::Node;
use crate::notice::Waker;
use crate::outbox::Outbox;
use crate::participant::Inner;
use crate::reactor::{Chore, Incoming, Registration, Sink};

/// Time for which both endpoints of a server must have matched.
const SETTLED: Duration = Duration::from_millis(200);
/// Most calls of a client that wait.
const MOST_CALLS: usize = 256;

/// Numbers of calls of a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ClientCounts {
    /// Requests given to DDS.
    pub sent: u64,
    /// Responses that ended a call.
    pub responses: u64,
    /// Responses to calls that had ended at their deadline.
    pub late: u64,
    /// Messages that are not responses of this service.
    pub malformed: u64,
}

/// Calls a service.
pub struct Client {
    inner: Arc<Inner>,
    shared: Arc<Shared>,
    request: Part,
    _registration: Registration,
}

struct Shared {
    service: String,
    mapping: ServiceMapping,
    outbox: Arc<Outbox>,
    /// The reader of responses.
    replies: Gid,
    /// The id of this client in the mapping of Cyclone.
    id: u64,
    response: Part,
    graph: Arc<SharedGraph>,
    calls: Mutex<Calls>,
    ended: Condvar,
    waker: OnceLock<Waker>,
    late: AtomicU64,
    malformed: AtomicU64,
}

#[derive(Default)]
struct Calls {
    next: u64,
    sequence: i64,
    open: BTreeMap<u64, State>,
    /// The calls that were sent, by mapping and number on the wire.
    sent: BTreeMap<(ServiceMapping, i64), u64>,
    counts: ClientCounts,
}

enum State {
    Unsent(Bytes),
    Sent(ServiceMapping, i64),
    Ended(Result<Datum, CallError>),
}

impl Node {
    /// Creates a client of a service. Names as for [`publisher`](Self::publisher).
    ///
    /// # Errors
    /// The name is not valid, the type is not a service that is defined, or DDS refuses.
    pub fn client(
        &self,
        service: &str,
        of: &InterfaceName,
        mapping: ServiceMapping,
    ) -> Result<Client, EndpointError> {
        let inner = self.inner();
        let name = inner.absolute(service)?;
        Client::new(inner, name, ServiceType::of(inner, of)?, mapping)
    }
}

impl Client {
    pub(crate) fn new(
        inner: &Arc<Inner>,
        service: String,
        of: ServiceType,
        mapping: ServiceMapping,
    ) -> Result<Self, EndpointError> {
        let (requests, replies) = names::service(&service);
        let (request, response) = (of.request, of.response);
        let outbox = inner.writer(&requests, &request.type_name, qos(), of.hash.clone())?;
        let type_name = response.type_name.clone();
        let mut shared = None;
        let (_, registration) = inner.reader(&replies, &type_name, qos(), of.hash, |replies| {
            let made = Arc::new(Shared {
                service,
                mapping,
                id: id_of(outbox.gid),
                outbox,
                replies,
                response,
                graph: Arc::clone(&inner.graph),
                calls: Mutex::default(),
                ended: Condvar::new(),
                waker: OnceLock::new(),
                late: AtomicU64::new(0),
                malformed: AtomicU64::new(0),
            });
            shared = Some(Arc::clone(&made));
            Box::new(Replies(made))
        })?;
        // the reader was created, and its sink with it
        let Some(shared) = shared else {
            return Err(EndpointError::Dds {
                topic: replies,
                reason: "no reader".to_owned(),
            });
        };
        let chore: Arc<dyn Chore> = Arc::clone(&shared) as Arc<dyn Chore>;
        inner.reactor.add_chore(Arc::downgrade(&chore));
        Ok(Self {
            inner: Arc::clone(inner),
            shared,
            request,
            _registration: registration,
        })
    }

    /// Calls the service. Never waits: [`Call::take`] has the response in a later cycle. A request waits for a server until the
    /// deadline, and is sent once.
    pub fn call(&self, request: &Datum, deadline: Duration) -> Call {
        let mut calls = self.shared.lock();
        let number = calls.next;
        calls.next += 1;
        let state = if calls.open.len() >= MOST_CALLS {
            let service = self.shared.service.clone();
            State::Ended(Err(CallError::TooMany(MOST_CALLS, service)))
        } else {
            match Codec::Cdr.encode(request, &self.request.schema) {
                Ok(bytes) => State::Unsent(bytes.into()),
                Err(error) => State::Ended(Err(CallError::Request(error))),
            }
        };
        calls.open.insert(number, state);
        drop(calls);
        if self.shared.run() {
            self.inner.reactor.wake();
        }
        Call {
            shared: Arc::clone(&self.shared),
            number,
            deadline,
            end: Instant::now() + deadline,
        }
    }

    /// Sets what is called after a call has ended with a response or an error. A deadline that passes wakes nobody.
    pub fn wake_with(&self, waker: Waker) {
        self.shared.waker.get_or_init(|| waker);
    }

    /// Returns whether a server has matched for long enough to be called.
    pub fn is_ready(&self) -> bool {
        self.shared.server().is_some()
    }

    /// The numbers of calls.
    pub fn counts(&self) -> ClientCounts {
        ClientCounts {
            late: self.shared.late.load(Ordering::Relaxed),
            malformed: self.shared.malformed.load(Ordering::Relaxed),
            ..self.shared.lock().counts
        }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.inner.forget(self.shared.outbox.gid);
        self.inner.forget(self.shared.replies);
    }
}

/// The id of a client for a writer. The first 12 bytes of a writer's id are random.
fn id_of(gid: Gid) -> u64 {
    // Fowler, Noll and Vo: FNV-1a
    gid.0.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

impl Shared {
    fn notify(&self) {
        self.ended.notify_all();
        if let Some(waker) = self.waker.get() {
            waker();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Calls> {
        self.calls.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The mapping of a server whose both endpoints have matched for long enough.
    fn server(&self) -> Option<ServiceMapping> {
        let graph = self.graph.lock();
        let settled = |since: Instant| since.elapsed() >= SETTLED;
        let readers = graph.matched(self.outbox.gid);
        let ready = readers.filter(|(_, since)| settled(*since));
        let mut ready = ready.filter(|(reader, _)| self.replies_from(&graph, *reader));
        let (reader, _) = ready.next()?;
        Some(self.mapping.for_vendor(graph.vendor(reader)))
    }

    fn replies_from(&self, graph: &Graph, reader: Gid) -> bool {
        let mut writers = graph.matched(self.replies);
        writers.any(|(writer, since)| {
            writer.participant() == reader.participant() && since.elapsed() >= SETTLED
        })
    }

    /// Sends a request; returns its number on the wire, or `None` if DDS does not take it now.
    fn send(
        &self,
        calls: &mut Calls,
        mapping: ServiceMapping,
        request: &Bytes,
    ) -> Result<Option<i64>, CallError> {
        let bytes = if mapping == ServiceMapping::Cyclone {
            let header = CycloneHeader {
                client: self.id,
                sequence: calls.sequence + 1,
            };
            header.put_before(request)
        } else {
            request.clone()
        };
        let identity = self.outbox.send_now(bytes).map_err(CallError::Send)?;
        let Some(identity) = identity else {
            return Ok(None);
        };
        if mapping != ServiceMapping::Cyclone {
            return Ok(Some(identity.sequence_number.into()));
        }
        calls.sequence += 1;
        Ok(Some(calls.sequence))
    }

    fn received(&self, incoming: &Incoming) -> Option<()> {
        let vendor = self.graph.lock().vendor(incoming.writer);
        let mapping = self.mapping.for_vendor(vendor);
        let (sequence, body) = if mapping == ServiceMapping::Cyclone {
            let Some((header, body)) = CycloneHeader::take_from(&incoming.payload.0) else {
                self.malformed.fetch_add(1, Ordering::Relaxed);
                return None;
            };
            // the topic carries the responses of all clients
            (header.client == self.id).then_some((header.sequence, body))?
        } else {
            let Some(related) = incoming.related else {
                self.malformed.fetch_add(1, Ordering::Relaxed);
                return None;
            };
            let client = Gid::from(related.writer_guid);
            let is_own = client == self.outbox.gid || client == self.replies;
            let body = || incoming.payload.0.to_vec();
            is_own.then(|| (related.sequence_number.into(), body()))?
        };
        let mut calls = self.lock();
        let Some(number) = calls.sent.remove(&(mapping, sequence)) else {
            self.late.fetch_add(1, Ordering::Relaxed);
            return None;
        };
        let decoded = Codec::Cdr.decode(&body, &self.response.schema);
        let result = decoded.map_err(|error| {
            self.malformed.fetch_add(1, Ordering::Relaxed);
            CallError::Malformed {
                service: self.service.clone(),
                reason: error.to_string(),
            }
        });
        calls.counts.responses += u64::from(result.is_ok());
        calls.open.insert(number, State::Ended(result));
        drop(calls);
        self.notify();
        Some(())
    }
}

impl Chore for Shared {
    fn run(&self) -> bool {
        let is_unsent = |state: &State| matches!(state, State::Unsent(_));
        if !self.lock().open.values().any(is_unsent) {
            return false;
        }
        let Some(mapping) = self.server() else {
            return true;
        };
        let mut calls = self.lock();
        let open = calls.open.iter();
        let unsent: Vec<(u64, Bytes)> = open
            .filter_map(|(number, state)| match state {
                State::Unsent(bytes) => Some((*number, bytes.clone())),
                State::Sent(..) | State::Ended(_) => None,
            })
            .collect();
        for (number, bytes) in unsent {
            let state = match self.send(&mut calls, mapping, &bytes) {
                Ok(None) => return true,
                Ok(Some(sequence)) => {
                    calls.counts.sent += 1;
                    calls.sent.insert((mapping, sequence), number);
                    State::Sent(mapping, sequence)
                }
                Err(error) => State::Ended(Err(error)),
            };
            calls.open.insert(number, state);
        }
        drop(calls);
        self.notify();
        false
    }
}

struct Replies(Arc<Shared>);

impl Sink for Replies {
    fn message(&mut self, incoming: Incoming) {
        self.0.received(&incoming);
    }

    fn unreadable(&mut self) {
        self.0.malformed.fetch_add(1, Ordering::Relaxed);
    }
}

/// A call that is under way. When it is dropped, its response is ignored and counted as late.
pub struct Call {
    shared: Arc<Shared>,
    number: u64,
    deadline: Duration,
    end: Instant,
}

impl Call {
    /// The response, or the error with which the call ended; `None` while it is under way, and after the response was taken.
    pub fn take(&mut self) -> Option<Result<Datum, CallError>> {
        let mut calls = self.shared.lock();
        self.take_from(&mut calls)
    }

    /// Waits for the end of the call. Not for cycles of components, which do not wait.
    ///
    /// # Errors
    /// The call ended without a response, at its deadline or before.
    pub fn wait(self) -> Result<Datum, CallError> {
        let shared = &self.shared;
        let mut calls = shared.lock();
        loop {
            if let Some(result) = self.take_from(&mut calls) {
                return result;
            }
            let left = self.end.saturating_duration_since(Instant::now());
            let waited = shared.ended.wait_timeout(calls, left);
            calls = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn take_from(&self, calls: &mut Calls) -> Option<Result<Datum, CallError>> {
        let is_over = Instant::now() >= self.end;
        let state = calls.open.get(&self.number)?;
        if !is_over && !matches!(state, State::Ended(_)) {
            return None;
        }
        let (service, deadline) = (self.shared.service.clone(), self.deadline);
        Some(match calls.open.remove(&self.number)? {
            State::Ended(result) => result,
            State::Unsent(_) => Err(CallError::NoServer { service, deadline }),
            State::Sent(mapping, sequence) => {
                calls.sent.remove(&(mapping, sequence));
                Err(CallError::Deadline { service, deadline })
            }
        })
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        let mut calls = self.shared.lock();
        if let Some(State::Sent(mapping, sequence)) = calls.open.remove(&self.number) {
            calls.sent.remove(&(mapping, sequence));
        }
    }
}
