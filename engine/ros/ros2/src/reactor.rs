//! The thread of a node: it receives messages, follows discovery and sends what had to wait.
//!
//! The thread owns all readers; other threads hand them over in `orders`. Chores are parts that need to be run again later, such
//! as a publisher whose messages DDS did not take at once; they are held weakly, by their owners.

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};
use std::thread::JoinHandle;
use std::time::Duration;

use rustdds::mio1::{self, Events, Interest, Poll, Registry, Token};
use rustdds::no_key::SimpleDataReader;
use rustdds::{DomainParticipant, SampleIdentity, StatusEvented, Timestamp};

use crate::gid::Gid;
use crate::graph::SharedGraph;
use crate::notice::{Notice, Waker};
use crate::payload::{Payload, Raw};

/// A message as it comes from DDS.
pub(crate) struct Incoming {
    /// The message with its encapsulation header.
    pub payload: Payload,
    /// Its writer.
    pub writer: Gid,
    /// Its number, counted by the writer from 1.
    pub sequence: i64,
    /// Time of its writing, in nanoseconds of the writer's clock.
    pub written: Option<u64>,
    /// The request that it belongs to, in the mapping of DDS-RPC.
    pub related: Option<SampleIdentity>,
}

/// Receives the messages of a reader, on the thread of the node.
pub(crate) trait Sink: Send {
    /// A message came.
    fn message(&mut self, incoming: Incoming);
    /// A message came in an encoding that is not plain CDR.
    fn unreadable(&mut self);
}

/// Something to be done again.
pub(crate) trait Chore: Send + Sync {
    /// Does what can be done without waiting. Returns `true` if a rest waits for time to pass.
    fn run(&self) -> bool;
}

/// A reader of DDS without decoding.
pub(crate) type Reader = SimpleDataReader<Payload, Raw>;

struct Entry {
    reader: Reader,
    sink: Box<dyn Sink>,
}

#[derive(Default)]
struct Orders {
    added: Vec<(Token, Entry)>,
    removed: Vec<Token>,
    next: usize,
}

/// The part of the reactor that all threads share.
pub(crate) struct Reactor {
    registry: Registry,
    waker: mio1::Waker,
    orders: Mutex<Orders>,
    chores: Mutex<Vec<Weak<dyn Chore>>>,
    /// Called without locks after readers have been emptied. Set once.
    after_reading: OnceLock<Waker>,
    stopped: AtomicBool,
}

/// Removes a reader from its node when it is dropped.
pub(crate) struct Registration {
    reactor: Arc<Reactor>,
    token: Token,
}

impl Drop for Registration {
    fn drop(&mut self) {
        self.reactor.orders().removed.push(self.token);
        self.reactor.wake();
    }
}

const WAKE: Token = Token(0);
const STATUS: Token = Token(1);
/// The first token of a reader.
const FIRST: usize = 2;
/// Interval at which chores with a rest are run.
const TICK: Duration = Duration::from_millis(5);
/// Longest sleep: bounds the harm of a notification that gets lost.
const LONGEST: Duration = Duration::from_millis(200);
/// Most messages taken from one reader before the others get their turn.
const BATCH: usize = 256;

impl Reactor {
    /// Starts the thread.
    pub(crate) fn start(
        participant: &DomainParticipant,
        graph: &Arc<SharedGraph>,
        name: &str,
    ) -> io::Result<(Arc<Self>, JoinHandle<()>)> {
        let poll = Poll::new()?;
        let reactor = Arc::new(Self {
            registry: poll.registry().try_clone()?,
            waker: mio1::Waker::new(poll.registry(), WAKE)?,
            orders: Mutex::default(),
            chores: Mutex::default(),
            after_reading: OnceLock::new(),
            stopped: AtomicBool::new(false),
        });
        let mut status = participant.status_listener();
        let source = status.as_status_source_mio1();
        reactor
            .registry
            .register(source, STATUS, Interest::READABLE)?;
        let (shared, graph) = (Arc::clone(&reactor), Arc::clone(graph));
        let thread = std::thread::Builder::new().name(format!("ros2 {name}"));
        let thread = thread.spawn(move || {
            let follow_discovery = || {
                let mut changed = false;
                while let Some(event) = status.try_recv_status() {
                    changed = true;
                    graph.apply(event);
                }
                graph.wake_for_notices();
                changed
            };
            shared.run(poll, follow_discovery, || {
                graph.notice(Notice::Interrupted);
            });
        })?;
        Ok((reactor, thread))
    }

    fn orders(&self) -> std::sync::MutexGuard<'_, Orders> {
        self.orders.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Wakes the thread.
    pub(crate) fn wake(&self) {
        // fails only where the operating system has no more memory; the thread then runs at its next tick
        let _ = self.waker.wake();
    }

    /// Ends the thread.
    pub(crate) fn stop(&self) {
        self.stopped.store(true, Ordering::Release);
        self.wake();
    }

    /// Sets what is called, in the thread, after readers have been emptied.
    pub(crate) fn call_after_reading(&self, call: Waker) {
        // the first one stays: an owner sets it once
        let _ = self.after_reading.set(call);
    }

    /// Hands over a reader.
    pub(crate) fn read(
        self: &Arc<Self>,
        mut reader: Reader,
        sink: Box<dyn Sink>,
    ) -> io::Result<Registration> {
        let mut orders = self.orders();
        orders.next += 1;
        let token = Token(FIRST + orders.next);
        self.registry
            .register(&mut reader, token, Interest::READABLE)?;
        orders.added.push((token, Entry { reader, sink }));
        drop(orders);
        self.wake();
        Ok(Registration {
            reactor: Arc::clone(self),
            token,
        })
    }

    /// Adds a chore.
    pub(crate) fn add_chore(&self, chore: Weak<dyn Chore>) {
        let mut chores = self.chores.lock().unwrap_or_else(PoisonError::into_inner);
        chores.push(chore);
    }

    /// Runs all chores. Returns `true` if one has a rest.
    fn run_chores(&self) -> bool {
        let mut chores = self.chores.lock().unwrap_or_else(PoisonError::into_inner);
        chores.retain(|chore| chore.strong_count() > 0);
        let alive: Vec<_> = chores.iter().filter_map(Weak::upgrade).collect();
        drop(chores);
        let mut has_rest = false;
        for chore in alive {
            has_rest |= chore.run();
        }
        has_rest
    }

    fn run(
        &self,
        mut poll: Poll,
        mut follow_discovery: impl FnMut() -> bool,
        interrupted: impl Fn(),
    ) {
        let mut events = Events::with_capacity(64);
        let mut entries: BTreeMap<Token, Entry> = BTreeMap::new();
        let mut full = Vec::new();
        while !self.stopped.load(Ordering::Acquire) {
            follow_discovery();
            let rest = self.run_chores();
            let sleep = match (full.is_empty(), rest) {
                (false, _) => Duration::ZERO,
                (true, true) => TICK,
                (true, false) => LONGEST,
            };
            let polled = poll.poll(&mut events, Some(sleep));
            let problem = polled.err().map(|error| error.kind());
            if problem == Some(io::ErrorKind::Interrupted) {
                interrupted();
            } else if problem.is_some() {
                // without events the readers are polled at each tick
                std::thread::sleep(TICK);
            }
            let added = {
                let mut orders = self.orders();
                for token in orders.removed.drain(..) {
                    // not yet taken over if it was added and removed at once
                    entries.remove(&token);
                }
                std::mem::take(&mut orders.added)
            };
            let mut ready: Vec<Token> = std::mem::take(&mut full);
            ready.extend(added.iter().map(|(token, _)| *token));
            entries.extend(added);
            if events.is_empty() {
                ready.extend(entries.keys());
            }
            ready.extend(events.iter().map(|event| event.token()));
            ready.sort_unstable();
            ready.dedup();
            for token in ready {
                if let Some(entry) = entries.get_mut(&token)
                    && !entry.take()
                {
                    full.push(token);
                }
            }
            if let Some(call) = self.after_reading.get() {
                call();
            }
        }
    }
}

impl Entry {
    /// Takes messages. Returns `false` if more are there.
    fn take(&mut self) -> bool {
        self.reader.drain_read_notifications();
        for _ in 0..BATCH {
            match self.reader.try_take_one() {
                Ok(None) => return true,
                Ok(Some(change)) => self.sink.message(Incoming {
                    writer: change.writer_guid.into(),
                    sequence: change.sequence_number.into(),
                    written: change.write_options.source_timestamp().map(nanoseconds),
                    related: change.write_options.related_sample_identity(),
                    payload: change.sample,
                }),
                // the reader has moved past the message
                Err(_) => self.sink.unreadable(),
            }
        }
        false
    }
}

/// The time in nanoseconds since 1970.
fn nanoseconds(time: Timestamp) -> u64 {
    /// Nanoseconds of a second, of which RTPS counts 2^-32 parts.
    const SECOND: u128 = 1_000_000_000;
    let ticks = u128::from(time.to_ticks());
    u64::try_from((ticks * SECOND) >> 32).unwrap_or(u64::MAX)
}
