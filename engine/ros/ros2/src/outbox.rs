//! Writers of DDS, with a queue for what DDS does not take at once.
//!
//! A reader that has matched gets its first message alone: the next one waits until all readers have acknowledged the first. A
//! volatile reader of Cyclone DDS begins after the last message that the first heartbeat of a foreign writer announces, and
//! `rustdds` sends a heartbeat with each datagram, in which it announces messages that another thread has written meanwhile and
//! that are not on their way yet. Such a message would never reach the reader.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rustdds::bytes::Bytes;
use rustdds::dds::WriteError;
use rustdds::no_key::DataWriter;
use rustdds::{SampleIdentity, Timestamp, WriteOptions, WriteOptionsBuilder};

use crate::error::SendError;
use crate::gid::Gid;
use crate::graph::SharedGraph;
use crate::history::{KeptMessages, Overflow};
use crate::notice::Notice;
use crate::payload::{Payload, Raw};
use crate::reactor::Chore;
use crate::release::Acknowledger;

/// Time that messages without acknowledgement have to leave.
const UNACKNOWLEDGED: Duration = Duration::from_millis(20);
/// Longest wait for the acknowledgement of the first message after a match.
const INTRODUCTION: Duration = Duration::from_millis(200);
/// Smallest number of messages that wait meanwhile before the oldest is dropped.
const INTRODUCED_LATER: usize = 256;

/// Numbers of messages of a publisher.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PublisherCounts {
    /// Given to DDS.
    pub sent: u64,
    /// Dropped because the queue was full: a subscription acknowledges too slowly.
    pub dropped: u64,
    /// Refused by DDS.
    pub refused: u64,
    /// In the queue.
    pub waiting: usize,
    /// No longer kept for a subscription that did not acknowledge them; the others have received them.
    pub released: u64,
}

/// The matched readers of a reliable writer.
pub(crate) struct Readers {
    pub(crate) graph: Arc<SharedGraph>,
    pub(crate) acknowledger: Arc<Acknowledger>,
}

impl Readers {
    /// Acknowledges messages of a writer in the name of readers.
    fn acknowledge(&self, writer: Gid, readers: &[Gid], before: i64) {
        for reader in readers {
            self.acknowledger.acknowledge(writer, *reader, before);
        }
    }
}

/// A writer of DDS, and the messages that it did not take yet.
pub(crate) struct Outbox {
    pub(crate) gid: Gid,
    topic: String,
    writer: DataWriter<Payload, Raw>,
    capacity: usize,
    /// `None` for a best-effort writer, whose readers acknowledge nothing.
    readers: Option<Readers>,
    state: Mutex<State>,
}

struct State {
    waiting: VecDeque<(Bytes, WriteOptions)>,
    counts: PublisherCounts,
    /// Messages that DDS may keep for readers.
    history: KeptMessages,
    /// A reader that does not acknowledge was noticed, and not all have acknowledged since.
    is_behind: bool,
    /// The latest match of a reader that has got its first message.
    introduced: Option<Instant>,
    /// The first message after a match that is not acknowledged yet.
    introduction: Option<Introduction>,
}

struct Introduction {
    /// The latest match before the message.
    matched: Instant,
    sent: Instant,
}

impl Outbox {
    pub(crate) fn new(
        gid: Gid,
        topic: &str,
        writer: DataWriter<Payload, Raw>,
        capacity: usize,
        (history, readers): (KeptMessages, Option<Readers>),
    ) -> Self {
        let state = State {
            waiting: VecDeque::new(),
            counts: PublisherCounts::default(),
            history,
            is_behind: false,
            introduced: None,
            introduction: None,
        };
        Self {
            gid,
            topic: topic.to_owned(),
            writer,
            capacity,
            readers,
            state: Mutex::new(state),
        }
    }

    /// The numbers of messages.
    pub(crate) fn counts(&self) -> PublisherCounts {
        let state = self.lock();
        PublisherCounts {
            waiting: state.waiting.len(),
            ..state.counts
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends a message, or queues it if others wait or DDS does not take it.
    pub(crate) fn send(
        &self,
        bytes: Bytes,
        related: Option<SampleIdentity>,
    ) -> Result<(), SendError> {
        let options = options(related);
        let mut state = self.lock();
        self.flush(&mut state);
        let is_first = state.waiting.is_empty();
        if is_first
            && self
                .write(&mut state, bytes.clone(), options.clone())?
                .is_some()
        {
            return Ok(());
        }
        let capacity = match state.introduction {
            Some(_) => self.capacity.max(INTRODUCED_LATER),
            None => self.capacity,
        };
        if state.waiting.len() >= capacity {
            state.waiting.pop_front();
            state.counts.dropped += 1;
        }
        state.waiting.push_back((bytes, options));
        Ok(())
    }

    /// Returns whether messages wait.
    pub(crate) fn is_waiting(&self) -> bool {
        !self.lock().waiting.is_empty()
    }

    /// Sends a message at once, or not at all; returns its identity.
    pub(crate) fn send_now(&self, bytes: Bytes) -> Result<Option<SampleIdentity>, SendError> {
        self.write(&mut self.lock(), bytes, options(None))
    }

    fn write(
        &self,
        state: &mut State,
        bytes: Bytes,
        options: WriteOptions,
    ) -> Result<Option<SampleIdentity>, SendError> {
        if !self.is_introduced(state) {
            return Ok(None);
        }
        self.forget_acknowledged(state);
        let matched = self.newest_match();
        let length = bytes.len();
        // the writer's longest blocking time is zero
        match self.writer.write_with_options(Payload(bytes), options) {
            Ok(identity) => {
                state.counts.sent += 1;
                self.keep(state, identity.sequence_number.into(), length);
                if let Some(matched) = matched.filter(|it| Some(*it) > state.introduced) {
                    let sent = Instant::now();
                    state.introduction = Some(Introduction { matched, sent });
                }
                Ok(Some(identity))
            }
            Err(WriteError::WouldBlock { .. }) => Ok(None),
            Err(
                error @ (WriteError::Serialization { .. }
                | WriteError::Poisoned { .. }
                | WriteError::Io(_)
                | WriteError::Internal { .. }),
            ) => {
                state.counts.refused += 1;
                Err(SendError::Dds {
                    topic: self.topic.clone(),
                    reason: error.to_string(),
                })
            }
        }
    }

    /// The latest match of a reader.
    fn newest_match(&self) -> Option<Instant> {
        let readers = self.readers.as_ref()?;
        readers.graph.lock().newest_match(self.gid)
    }

    /// If much is kept, asks DDS whether all readers have acknowledged it.
    fn forget_acknowledged(&self, state: &mut State) {
        let (Some(readers), true) = (&self.readers, state.history.is_long()) else {
            return;
        };
        let acknowledged = self.writer.wait_for_acknowledgments(Duration::ZERO);
        if !acknowledged.unwrap_or(false) {
            return;
        }
        state.is_behind = false;
        if let Some(last) = state.history.clear() {
            let best_effort = readers.graph.lock().readers(self.gid, |it| !it);
            readers.acknowledge(self.gid, &best_effort, last + 1);
        }
    }

    /// Records a message that DDS keeps, and gives up old ones if it keeps too much.
    fn keep(&self, state: &mut State, number: i64, length: usize) {
        let Some(readers) = &self.readers else {
            return;
        };
        state.history.push(number, length);
        let Some(Overflow { before, messages }) = state.history.overflow() else {
            return;
        };
        let all = readers.graph.lock().readers(self.gid, |_| true);
        readers.acknowledge(self.gid, &all, before);
        state.counts.released += messages;
        if !std::mem::replace(&mut state.is_behind, true) {
            let reliable = readers.graph.lock().readers(self.gid, |it| it);
            readers.graph.notice(Notice::Unacknowledged {
                topic: self.topic.clone(),
                readers: reliable,
            });
        }
    }

    /// Returns whether a message can be sent: the first one after a match, or one after it was acknowledged.
    fn is_introduced(&self, state: &mut State) -> bool {
        let Some(Introduction { matched, sent }) = &state.introduction else {
            return true;
        };
        let acknowledged = self.writer.wait_for_acknowledgments(Duration::ZERO);
        if !acknowledged.unwrap_or(true) && sent.elapsed() < INTRODUCTION {
            return false;
        }
        state.introduced = Some(*matched);
        state.introduction = None;
        true
    }

    /// Waits until DDS has taken the messages sent so far, and reliable subscriptions have acknowledged them, at most until this
    /// time. Returns whether they have.
    pub(crate) fn drain(&self, until: Instant) -> bool {
        loop {
            let mut state = self.lock();
            self.flush(&mut state);
            if state.waiting.is_empty() {
                break;
            }
            drop(state);
            if Instant::now() >= until {
                return false;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let left = until.saturating_duration_since(Instant::now());
        let acknowledged = self.writer.wait_for_acknowledgments(left);
        // nothing tells when the thread of DDS has sent what needs no acknowledgement
        std::thread::sleep(UNACKNOWLEDGED.min(until.saturating_duration_since(Instant::now())));
        acknowledged.unwrap_or(false)
    }

    fn flush(&self, state: &mut State) {
        while let Some((bytes, options)) = state.waiting.front().cloned() {
            // a refused message is counted, and does not come back
            if matches!(self.write(state, bytes, options), Ok(None)) {
                return;
            }
            state.waiting.pop_front();
        }
    }
}

/// Options of a message that is sent now: its age counts from here, also while it waits.
fn options(related: Option<SampleIdentity>) -> WriteOptions {
    WriteOptionsBuilder::new()
        .related_sample_identity_opt(related)
        .source_timestamp(Timestamp::now())
        .build()
}

impl Chore for Outbox {
    fn run(&self) -> bool {
        let mut state = self.lock();
        self.flush(&mut state);
        !state.waiting.is_empty()
    }
}
