//! The sending end of a queue: an output port that Orocos components read.

use std::sync::Arc;

use asmotion_datum::{Datum, DatumError, DatumProblem, Sample};
use asmotion_runtime::{PushOutcome, Sink};

use crate::capacity::QueueCapacity;
use crate::error::QueueCheckError;
use crate::layout::QueueLayout;
use crate::name::QueueName;
use crate::queue::{KernelQueue, SendOutcome};

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

/// Writes messages without ever waiting for a reader. The queue's name is removed on drop.
pub struct QueueWriter {
    name: QueueName,
    layout: QueueLayout,
    keep: FullQueuePolicy,
    queue: KernelQueue,
    /// Buffer for the message being written.
    message: Vec<u8>,
    /// Buffer for a message that is removed to make room.
    discarded: Vec<u8>,
}

impl QueueWriter {
    /// Opens a queue, and creates it if it does not exist. Discards messages of a previous writer, and sends a sample
    /// of zeros as the first message.
    ///
    /// # Errors
    /// An error of the operating system, usually a limit; or a queue with this name exists for smaller messages.
    pub fn open(
        name: QueueName,
        layout: QueueLayout,
        room: QueueCapacity,
        keep: FullQueuePolicy,
    ) -> Result<Self, QueueCheckError> {
        if room.size == 0 {
            return Err(QueueCheckError::NoSize {
                queue: name.to_string(),
                kind: layout.schema().to_string(),
            });
        }
        let queue = KernelQueue::create(&name, room)?;
        if queue.size() < room.size {
            return Err(QueueCheckError::Smaller {
                queue: name.to_string(),
                required: queue.size(),
                size: room.size,
            });
        }
        let mut old = vec![0; queue.size()];
        while queue.pop(&mut old)?.is_some() {}
        let mut writer = Self {
            name,
            layout,
            keep,
            message: Vec::with_capacity(room.size),
            discarded: old,
            queue,
        };
        writer.send_zeros().map(|()| writer)
    }

    /// Sends a sample that shows the layout, for which a reader of RTT waits after connecting.
    fn send_zeros(&mut self) -> Result<(), QueueCheckError> {
        // fails only for types that a layout refuses
        match self.layout.encode_zeros(&mut self.message) {
            Ok(()) => self.push().map(drop),
            Err(_) => Ok(()),
        }
    }

    /// Sends a message, or drops it if the queue is full.
    ///
    /// # Errors
    /// An error if the message has another type or is too large for the queue.
    pub fn send(&mut self, sample: &dyn Sample) -> Result<PushOutcome, DatumError> {
        self.message.clear();
        match sample.downcast_ref::<Datum>() {
            Some(datum) => self.layout.encode(datum, &mut self.message)?,
            None => self.layout.encode(&sample.to_datum()?, &mut self.message)?,
        }
        self.push().map_err(to_datum_error)
    }

    fn push(&mut self) -> Result<PushOutcome, QueueCheckError> {
        if self.queue.push(&self.message)? == SendOutcome::Stored {
            return Ok(PushOutcome::Stored);
        }
        if self.keep == FullQueuePolicy::Oldest {
            return Ok(PushOutcome::DroppedNewest);
        }
        // a reader may have emptied the queue in the meantime, in which case nothing is lost
        let taken = self.queue.pop(&mut self.discarded)?;
        Ok(match (self.queue.push(&self.message)?, taken, self.keep) {
            (SendOutcome::Full, ..) => PushOutcome::DroppedNewest,
            (SendOutcome::Stored, Some(_), FullQueuePolicy::Newest) => PushOutcome::DroppedOldest,
            (SendOutcome::Stored, ..) => PushOutcome::Stored,
        })
    }
}

impl Drop for QueueWriter {
    fn drop(&mut self) {
        self.queue.unlink();
    }
}

impl Sink for QueueWriter {
    fn name(&self) -> String {
        self.name.to_string()
    }

    fn send(&mut self, sample: Arc<dyn Sample>) -> Result<PushOutcome, DatumError> {
        QueueWriter::send(self, &*sample)
    }
}

/// Converts a problem of the queue to an error of the sample.
pub(crate) fn to_datum_error(error: QueueCheckError) -> DatumError {
    DatumError::new(DatumProblem::Mismatch(error.to_string()))
}
