//! The sending end of a queue: an output port that Orocos components read.

mod upkeep;

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_datum::{Datum, DatumError, DatumProblem, Sample};
use asmotion_runtime::{PushOutcome, Sink, SinkUpkeep};

use crate::capacity::QueueCapacity;
use crate::claim::{QueueClaim, QueueEnd};
use crate::error::QueueCheckError;
use crate::layout::QueueLayout;
use crate::name::QueueName;
use crate::queue::{HolderAccess, KernelQueue, QueueOrigin, SendOutcome};
use crate::queue_priority::QueuePriority;
use crate::writer::upkeep::QueueUpkeep;

/// The messages that are kept when the queue is full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FullQueuePolicy {
    /// The oldest: a new message is dropped (RTT BUFFER).
    Oldest,
    /// The newest: the oldest message is dropped (RTT CIRCULAR_BUFFER).
    Newest,
    /// Only the last: replaced messages do not count as dropped (RTT DATA).
    Last,
}

/// Writes messages without ever waiting for a reader.
///
/// On drop, the queue's name is removed unless another process has the queue open, or may have: a reader that stays
/// would never find the next writer's queue.
pub struct QueueWriter {
    name: QueueName,
    /// Shared with [`QueueUpkeep`], which holds the lock for a few system calls at most.
    state: Arc<Mutex<WriterState>>,
    /// Keeps other processes from writing to the queue.
    _claim: QueueClaim,
}

/// The queue of a writer and its content.
struct WriterState {
    name: QueueName,
    layout: QueueLayout,
    keep: FullQueuePolicy,
    capacity: QueueCapacity,
    /// Age at which a message in the queue is discarded.
    max_age: Option<Duration>,
    queue: Arc<KernelQueue>,
    origin: QueueOrigin,
    /// Times of sending of the messages in the queue, oldest first; `None` for a message that only shows the layout,
    /// which does not age.
    waiting: VecDeque<Option<Instant>>,
    /// Number of messages of data that were put into the queue.
    sent: u64,
    /// Number of messages that a reader has taken from the queue.
    taken: u64,
    /// Another process with the queue open has been seen, so that readers are visible. Set by the upkeep.
    holder_seen: bool,
    /// Buffer for the message being encoded.
    message: Vec<u8>,
    /// The last message; empty before the first one.
    last: Vec<u8>,
    /// Buffer for a message that is removed.
    removed: Vec<u8>,
    discarded: DiscardedMessages,
}

/// Messages that the writer removed from the queue and that have not been reported yet.
#[derive(Default)]
struct DiscardedMessages {
    /// Left in the queue by an earlier writer.
    left: u64,
    /// Older than the limit.
    expired: u64,
}

impl QueueWriter {
    /// Opens a queue, and creates it if it does not exist. Discards messages of an earlier writer.
    ///
    /// In a queue that it created, the first message is a sample of zeros, which shows the layout. A queue that another
    /// process has open is used as it is: its reader would take the zeros for data. A queue that no process has open is
    /// replaced.
    ///
    /// # Errors
    /// An error of the operating system, usually a limit; or a queue with this name exists for smaller messages; or another
    /// process of ours writes to it.
    pub fn open(
        name: QueueName,
        layout: QueueLayout,
        capacity: QueueCapacity,
        keep: FullQueuePolicy,
    ) -> Result<Self, QueueCheckError> {
        if capacity.size == 0 {
            return Err(QueueCheckError::NoSize {
                queue: name.to_string(),
                kind: layout.schema().to_string(),
            });
        }
        let claim = QueueClaim::new(&name, QueueEnd::Writer)?;
        let (mut queue, mut origin) = KernelQueue::create(&name, capacity)?;
        let mut left = 0;
        if origin == QueueOrigin::Found {
            let others = queue.find_holders(HolderAccess::Any);
            if others.found.is_empty() && others.complete {
                left = queue.count();
                queue.unlink();
                (queue, origin) = KernelQueue::create(&name, capacity)?;
            }
        }
        if queue.size() < capacity.size {
            return Err(QueueCheckError::Smaller {
                queue: name.to_string(),
                required: queue.size(),
                size: capacity.size,
            });
        }
        let mut removed = vec![0; queue.size()];
        while queue.pop(&mut removed)?.is_some() {
            left += 1;
        }
        let mut state = WriterState {
            name: name.clone(),
            layout,
            keep,
            capacity,
            max_age: None,
            queue: Arc::new(queue),
            origin,
            waiting: VecDeque::with_capacity(capacity.messages),
            sent: 0,
            taken: 0,
            holder_seen: false,
            message: Vec::with_capacity(capacity.size),
            last: Vec::with_capacity(capacity.size),
            removed,
            discarded: DiscardedMessages {
                left: left as u64,
                expired: 0,
            },
        };
        state.show_layout()?;
        Ok(Self {
            name,
            state: Arc::new(Mutex::new(state)),
            _claim: claim,
        })
    }

    /// Sets the age at which a message that nobody has read is discarded (default: none).
    #[must_use]
    pub fn max_age(self, max_age: Option<Duration>) -> Self {
        lock(&self.state).max_age = max_age;
        self
    }

    /// Sends a message, or drops it if the queue is full.
    ///
    /// # Errors
    /// An error if the message has another type or is too large for the queue.
    pub fn send(&mut self, sample: &dyn Sample) -> Result<PushOutcome, DatumError> {
        lock(&self.state).send(sample)
    }
}

impl WriterState {
    fn send(&mut self, sample: &dyn Sample) -> Result<PushOutcome, DatumError> {
        self.message.clear();
        match sample.downcast_ref::<Datum>() {
            Some(datum) => self.layout.encode(datum, &mut self.message)?,
            None => self.layout.encode(&sample.to_datum()?, &mut self.message)?,
        }
        let now = Instant::now();
        self.expire(now).map_err(to_datum_error)?;
        let outcome = self.store(now).map_err(to_datum_error)?;
        std::mem::swap(&mut self.message, &mut self.last);
        Ok(outcome)
    }

    fn store(&mut self, now: Instant) -> Result<PushOutcome, QueueCheckError> {
        // a queue that was found may have room for more messages than this connection wants
        if self.queue.count() < self.capacity.messages && self.push(now)? == SendOutcome::Stored {
            return Ok(PushOutcome::Stored);
        }
        if self.keep == FullQueuePolicy::Oldest {
            return Ok(PushOutcome::DroppedNewest);
        }
        // a reader may have emptied the queue in the meantime, in which case nothing is lost
        let replaced = self.remove_oldest()?;
        Ok(match (self.push(now)?, replaced, self.keep) {
            (SendOutcome::Full, ..) => PushOutcome::DroppedNewest,
            (SendOutcome::Stored, Some(QueuePriority::Data), FullQueuePolicy::Newest) => {
                PushOutcome::DroppedOldest
            }
            (SendOutcome::Stored, ..) => PushOutcome::Stored,
        })
    }

    fn push(&mut self, now: Instant) -> Result<SendOutcome, QueueCheckError> {
        let outcome = self.queue.push(&self.message, QueuePriority::Data)?;
        if outcome == SendOutcome::Stored {
            self.waiting.push_back(Some(now));
            self.sent += 1;
        }
        Ok(outcome)
    }

    /// Sends a message that shows the layout, for which a reader of RTT waits after connecting: the last message, or
    /// zeros in a queue that this writer created. The queue must be empty, and no connected reader may be waiting for
    /// data.
    fn show_layout(&mut self) -> Result<(), QueueCheckError> {
        if !self.last.is_empty() {
            self.message.clone_from(&self.last);
        } else if self.origin == QueueOrigin::Created {
            self.message.clear();
            // fails only for types that a layout refuses
            if self.layout.encode_zeros(&mut self.message).is_err() {
                return Ok(());
            }
        } else {
            return Ok(());
        }
        if self.queue.push(&self.message, QueuePriority::Layout)? == SendOutcome::Stored {
            self.waiting.push_back(None);
        }
        Ok(())
    }

    /// Removes the oldest message. Returns its priority.
    fn remove_oldest(&mut self) -> Result<Option<QueuePriority>, QueueCheckError> {
        let removed = self.queue.pop(&mut self.removed)?;
        if removed.is_some() {
            self.waiting.pop_front();
        }
        Ok(removed.map(|(_, priority)| priority))
    }

    /// Counts the messages that a reader has taken. Returns the number of messages left in the queue.
    fn update_taken(&mut self) -> usize {
        let count = self.queue.count();
        let taken = self.waiting.len().saturating_sub(count);
        self.waiting.drain(..taken);
        self.taken += taken as u64;
        count
    }

    /// Removes the messages that are too old, and a message before them that shows the layout.
    fn expire(&mut self, now: Instant) -> Result<(), QueueCheckError> {
        self.update_taken();
        let Some(max_age) = self.max_age else {
            return Ok(());
        };
        let is_old = |sent: &Option<Instant>| {
            sent.is_some_and(|sent| now.saturating_duration_since(sent) > max_age)
        };
        let newest = self.waiting.iter().rposition(is_old);
        for _ in 0..newest.map_or(0, |newest| newest + 1) {
            match self.remove_oldest()? {
                Some(QueuePriority::Data) => self.discarded.expired += 1,
                Some(QueuePriority::Layout | QueuePriority::Foreign) => {}
                // a reader was faster
                None => break,
            }
        }
        Ok(())
    }

    /// Returns whether no reader can have the queue open, given that none was found: all processes were examined,
    /// readers have been visible so far, or none has ever taken a message.
    fn is_unread(&self, complete: bool) -> bool {
        let untouched = self.origin == QueueOrigin::Created && self.taken == 0;
        complete || self.holder_seen || untouched
    }
}

impl Drop for QueueWriter {
    fn drop(&mut self) {
        let mut state = lock(&self.state);
        let others = state.queue.find_holders(HolderAccess::Any);
        state.update_taken();
        if others.found.is_empty() && state.is_unread(others.complete) && !state.queue.is_unlinked()
        {
            state.queue.unlink();
        }
    }
}

impl Sink for QueueWriter {
    fn name(&self) -> String {
        self.name.to_string()
    }

    fn send(&mut self, sample: Arc<dyn Sample>) -> Result<PushOutcome, DatumError> {
        QueueWriter::send(self, &*sample)
    }

    fn upkeep(&mut self) -> Option<Box<dyn SinkUpkeep>> {
        Some(Box::new(QueueUpkeep::new(Arc::clone(&self.state))))
    }
}

fn lock(state: &Mutex<WriterState>) -> MutexGuard<'_, WriterState> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Converts a problem of the queue to an error of the sample.
pub(crate) fn to_datum_error(error: QueueCheckError) -> DatumError {
    problem(error.to_string())
}

/// A problem with a message, in words.
pub(crate) fn problem(reason: String) -> DatumError {
    DatumError::new(DatumProblem::Mismatch(reason))
}
