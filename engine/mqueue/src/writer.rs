//! The sending end of a queue: an output port of ours that Orocos components read.

use std::sync::Arc;

use asmotion_datum::{Datum, DatumError, DatumProblem, Sample};
use asmotion_runtime::{PushOutcome, Sink};

use crate::error::QueueCheckError;
use crate::layout::QueueLayout;
use crate::name::QueueName;
use crate::queue::{KernelQueue, SendOutcome};

/// How much a queue holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QueueCapacity {
    /// How many messages.
    pub messages: usize,
    /// The largest of them, in bytes (RTT `data_size`).
    pub size: usize,
}

/// What is kept when the queue is full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FullQueuePolicy {
    /// What was there first; a new message is dropped (RTT BUFFER).
    Oldest,
    /// What comes; the oldest message is taken out (RTT CIRCULAR_BUFFER).
    Newest,
    /// The same, where one message makes those before it worthless (RTT DATA).
    Last,
}

/// Writes messages; never waits for a reader. The queue's name is removed at the end.
pub struct QueueWriter {
    name: QueueName,
    layout: QueueLayout,
    keep: FullQueuePolicy,
    queue: KernelQueue,
    /// The message being written.
    message: Vec<u8>,
    /// For one taken out.
    old: Vec<u8>,
}

impl QueueWriter {
    /// Opens a queue, and makes it if there is none. What a writer before has left in it is thrown away; its first
    /// message is a sample of zeros.
    ///
    /// # Errors
    /// The system or its limits stand in the way, or there is a queue for smaller messages.
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
                takes: queue.size(),
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
            old,
            queue,
        };
        writer.show_shape().map(|()| writer)
    }

    /// A reader of RTT waits for a first sample as soon as it is connected: this one shows what samples are like.
    fn show_shape(&mut self) -> Result<(), QueueCheckError> {
        // a layout has a form for zeros
        match self.layout.encode_zeros(&mut self.message) {
            Ok(()) => self.push().map(drop),
            Err(_) => Ok(()),
        }
    }

    /// Writes a message, or drops it.
    ///
    /// # Errors
    /// It is of another type, or larger than the queue takes.
    pub fn send(&mut self, sample: &dyn Sample) -> Result<PushOutcome, DatumError> {
        self.message.clear();
        match sample.downcast_ref::<Datum>() {
            Some(datum) => self.layout.encode(datum, &mut self.message)?,
            None => (self.layout).encode(&sample.to_datum()?, &mut self.message)?,
        }
        self.push().map_err(told)
    }

    fn push(&mut self) -> Result<PushOutcome, QueueCheckError> {
        if self.queue.push(&self.message)? == SendOutcome::Stored {
            return Ok(PushOutcome::Stored);
        }
        if self.keep == FullQueuePolicy::Oldest {
            return Ok(PushOutcome::DroppedNewest);
        }
        // a reader may be faster, then nothing is lost
        let taken = self.queue.pop(&mut self.old)?;
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

/// A queue's problem, as one of the sample that met it.
pub(crate) fn told(error: QueueCheckError) -> DatumError {
    DatumError::new(DatumProblem::Mismatch(error.to_string()))
}
