//! Channels of connections, according to their policies.

use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;

use asmotion_connection::{Pool, Receiver, Sender};
use asmotion_datum::{Datum, DatumError, Message, Sample, Schema};

use crate::connection_id::ConnectionId;
use crate::loss_counter::LossCounter;
use crate::one_thread;
use crate::policy::{Lock, OnStale, Policy};
use crate::queue_gauges::QueueGauges;
use crate::sender::{AnySender, PulledSender, Stamped};
use crate::snapshot::SampleSnapshot;

/// A queue shared by several connections. Created by the first one; its element type is that of its readers.
pub type SharedQueue = Option<Box<dyn Any + Send>>;

/// The reason that a connection cannot be opened.
#[derive(Debug)]
pub enum OpenError {
    /// The policy replaces stale samples by zeros, and the type has no zero value.
    NoZero(DatumError),
    /// The shared queue contains samples of another type.
    TypeMismatch,
}

/// Opens channels into an input port. Knows the port's type, but does not access the port.
pub trait ChannelOpener: Send + Sync {
    /// Opens a channel for a connection, over the shared queue if there is one.
    ///
    /// # Errors
    /// An error if the type does not fit the policy or the shared queue.
    fn open(
        &self,
        connection: ConnectionId,
        policy: &Policy,
        queue: Option<&mut SharedQueue>,
    ) -> Result<(Box<dyn AnySender>, ReadingEnd), OpenError>;

    /// Opens a lock-free channel of its own whose memory is allocated with the first sample, by the thread that sends it.
    ///
    /// # Errors
    /// An error if the type does not fit the policy.
    fn open_on_demand(
        &self,
        connection: ConnectionId,
        policy: &Policy,
    ) -> Result<(Box<dyn AnySender>, ReadingEnd), OpenError>;

    /// The counter of the messages that are lost on the way into the port. Writers count what they drop.
    fn losses(&self) -> LossCounter;

    /// Number of samples that wait in the queues of the port's connections. A connection for the newest sample alone is no queue,
    /// and the queue of two ends in one thread is not seen from others.
    fn waiting(&self) -> u64;
}

/// The reading end of a connection, before it is joined to the port whose [`ChannelOpener`] made it.
pub struct ReadingEnd {
    pub(crate) channel: Box<dyn Any + Send>,
    pub(crate) declared: bool,
}

impl ReadingEnd {
    /// Marks a connection that is not part of the system's declaration, such as that of a tool:
    /// [`AnyInput::queue`](crate::AnyInput::queue) does not include it.
    #[must_use]
    pub fn undeclared(self) -> Self {
        Self {
            declared: false,
            ..self
        }
    }
}

/// The reading end of a connection, joined to its port.
pub(crate) struct InputChannel<T> {
    pub connection: ConnectionId,
    pub policy: Policy,
    /// Replacement for a stale sample, if the policy asks for zeros.
    pub zero: Option<T>,
    /// Whether the connection is part of the system's declaration.
    pub declared: bool,
    /// The writing end had been dropped when the channel was last emptied, so that nothing more can arrive.
    pub has_ended: bool,
    pub receiver: InputReceiver<T>,
}

/// The receiver of a connection's samples.
pub(crate) enum InputReceiver<T> {
    /// Samples in the port's own type.
    Own(Receiver<Stamped<T>>),
    /// Samples as they were written; the port converts them.
    Pulled(Receiver<Stamped<Arc<dyn Sample>>>),
}

/// Opens channels into ports of type `T`.
pub(crate) struct OpenerOf<T> {
    /// Type of the port, which of a port of data is known at run time only.
    pub schema: Arc<Schema>,
    pub losses: LossCounter,
    pub gauges: QueueGauges,
    pub of: PhantomData<fn() -> T>,
}

impl<T: Message> ChannelOpener for OpenerOf<T> {
    fn open(
        &self,
        connection: ConnectionId,
        policy: &Policy,
        queue: Option<&mut SharedQueue>,
    ) -> Result<(Box<dyn AnySender>, ReadingEnd), OpenError> {
        if policy.pull {
            let (sender, receiver) = channel_ends(policy, queue)?;
            let receiver = InputReceiver::Pulled(receiver);
            self.joined(connection, policy, Box::new(PulledSender(sender)), receiver)
        } else {
            let (sender, receiver) = channel_ends::<T>(policy, queue)?;
            let receiver = InputReceiver::Own(receiver);
            self.joined(connection, policy, Box::new(sender), receiver)
        }
    }

    fn open_on_demand(
        &self,
        connection: ConnectionId,
        policy: &Policy,
    ) -> Result<(Box<dyn AnySender>, ReadingEnd), OpenError> {
        let pool: Pool<Stamped<T>> = Pool::on_demand(policy.kind);
        let receiver = InputReceiver::Own(pool.receiver());
        self.joined(connection, policy, Box::new(pool.sender()), receiver)
    }

    fn losses(&self) -> LossCounter {
        self.losses.clone()
    }

    fn waiting(&self) -> u64 {
        self.gauges.waiting()
    }
}

impl<T: Message> OpenerOf<T> {
    /// The two ends of a connection for the output and the port.
    fn joined(
        &self,
        connection: ConnectionId,
        policy: &Policy,
        sender: Box<dyn AnySender>,
        receiver: InputReceiver<T>,
    ) -> Result<(Box<dyn AnySender>, ReadingEnd), OpenError> {
        let zero: Option<T> = match policy.on_stale {
            // all fields of a message have initial values, so an empty record suffices
            OnStale::Zero => {
                let zeros = self.schema.complete(Datum::Record(Vec::new()));
                let zeros = zeros.and_then(|zeros| T::of_datum(&zeros));
                Some(zeros.map_err(OpenError::NoZero)?)
            }
            OnStale::Hold | OnStale::NoData => None,
        };
        let gauge = match &receiver {
            InputReceiver::Own(receiver) => receiver.gauge(),
            InputReceiver::Pulled(receiver) => receiver.gauge(),
        };
        if let Some(gauge) = gauge {
            self.gauges.add(gauge);
        }
        let channel = InputChannel {
            connection,
            policy: policy.clone(),
            zero,
            declared: true,
            has_ended: false,
            receiver,
        };
        let reading_end = ReadingEnd {
            channel: Box::new(channel),
            declared: true,
        };
        Ok((sender, reading_end))
    }
}

impl<T: Message> InputChannel<T> {
    /// Removes all waiting samples and passes them to `f`. Returns how many could not be converted to the port's
    /// type.
    pub(crate) fn drain(&mut self, mut f: impl FnMut(Stamped<T>)) -> u64 {
        match &mut self.receiver {
            InputReceiver::Own(receiver) => {
                receiver.drain(f);
                0
            }
            InputReceiver::Pulled(receiver) => {
                let mut unreadable = 0;
                receiver.drain(|Stamped { at, order, value }| match value.read() {
                    Ok(value) => f(Stamped { at, order, value }),
                    Err(_) => unreadable += 1,
                });
                unreadable
            }
        }
    }
}

impl<T: Message> InputChannel<T> {
    /// Returns the unread samples without consuming them.
    pub(crate) fn snapshot(&mut self) -> Result<Vec<SampleSnapshot>, DatumError> {
        let mut waiting = Vec::new();
        match &mut self.receiver {
            InputReceiver::Own(receiver) => {
                receiver.peek_each(|sample| waiting.push(SampleSnapshot::of(sample)));
            }
            InputReceiver::Pulled(receiver) => receiver.peek_each(|sample| {
                let datum = sample.value.to_datum();
                waiting.push(datum.map(|value| SampleSnapshot {
                    at: sample.at,
                    order: sample.order,
                    value,
                }));
            }),
        }
        waiting.into_iter().collect()
    }

    /// Discards the unread samples. Returns their number.
    pub(crate) fn clear(&mut self) -> u64 {
        let mut discarded = 0;
        match &mut self.receiver {
            InputReceiver::Own(receiver) => receiver.drain(|_| discarded += 1),
            InputReceiver::Pulled(receiver) => receiver.drain(|_| discarded += 1),
        }
        discarded
    }
}

impl<T> InputChannel<T> {
    /// Allocates the whole queue.
    pub(crate) fn reserve(&self) {
        match &self.receiver {
            InputReceiver::Own(receiver) => receiver.reserve(),
            InputReceiver::Pulled(receiver) => receiver.reserve(),
        }
    }

    /// Prefetches the queue.
    pub(crate) fn prefetch(&self) {
        match &self.receiver {
            InputReceiver::Own(receiver) => receiver.prefetch(),
            InputReceiver::Pulled(receiver) => receiver.prefetch(),
        }
    }

    /// Returns whether the writing end has been dropped.
    pub(crate) fn is_abandoned(&self) -> bool {
        match &self.receiver {
            InputReceiver::Own(receiver) => receiver.is_abandoned(),
            InputReceiver::Pulled(receiver) => receiver.is_abandoned(),
        }
    }
}

/// The two ends of a connection.
type Ends<T> = (Sender<Stamped<T>>, Receiver<Stamped<T>>);

/// Creates the two ends of a connection. The runtime's connection table admits an unsynchronised one only if both ends
/// are in the same thread.
fn channel_ends<T: Send + 'static>(
    policy: &Policy,
    queue: Option<&mut SharedQueue>,
) -> Result<Ends<T>, OpenError> {
    let make = || match policy.lock {
        Lock::LockFree => Pool::lock_free(policy.kind),
        Lock::Locked => Pool::locked(policy.kind),
        Lock::Unsync => one_thread::pool(policy.kind),
    };
    let pool = match (queue, policy.lock) {
        (None, Lock::LockFree) => return Ok(asmotion_connection::channel(policy.kind)),
        (None, Lock::Locked | Lock::Unsync) => make(),
        (Some(queue), _) => {
            let queue = queue.get_or_insert_with(|| Box::new(make()));
            let pool: Option<&Pool<Stamped<T>>> = queue.downcast_ref();
            pool.ok_or(OpenError::TypeMismatch)?.clone()
        }
    };
    Ok((pool.sender(), pool.receiver()))
}
