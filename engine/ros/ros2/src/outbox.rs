//! Writers of DDS, with a queue for what DDS does not take at once.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rustdds::bytes::Bytes;
use rustdds::dds::WriteError;
use rustdds::no_key::DataWriter;
use rustdds::{SampleIdentity, Timestamp, WriteOptions, WriteOptionsBuilder};

use crate::error::SendError;
use crate::gid::Gid;
use crate::payload::{Payload, Raw};
use crate::reactor::Chore;

/// Time that messages without acknowledgement have to leave.
const UNACKNOWLEDGED: Duration = Duration::from_millis(20);

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
}

/// A writer of DDS, and the messages that it did not take yet.
pub(crate) struct Outbox {
    pub(crate) gid: Gid,
    topic: String,
    writer: DataWriter<Payload, Raw>,
    capacity: usize,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    waiting: VecDeque<(Bytes, WriteOptions)>,
    counts: PublisherCounts,
}

impl Outbox {
    pub(crate) fn new(
        gid: Gid,
        topic: &str,
        writer: DataWriter<Payload, Raw>,
        capacity: usize,
    ) -> Self {
        Self {
            gid,
            topic: topic.to_owned(),
            writer,
            capacity,
            state: Mutex::default(),
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
        if state.waiting.len() >= self.capacity {
            state.waiting.pop_front();
            state.counts.dropped += 1;
        }
        state.waiting.push_back((bytes, options));
        Ok(())
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
        // the writer's longest blocking time is zero
        match self.writer.write_with_options(Payload(bytes), options) {
            Ok(identity) => {
                state.counts.sent += 1;
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
