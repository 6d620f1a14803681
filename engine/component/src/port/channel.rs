//! The channel of a connection, as its policy wants it.

use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;

use asmotion_connection::{Pool, Receiver, Sender};
use asmotion_datum::{Datum, DatumError, Message, Sample};

use super::{AnySender, Unread, one_thread};
use crate::Time;
use crate::policy::{Lock, OnStale, Policy};
use crate::system::ConnectionId;

/// A sample on its way.
#[derive(Debug, Clone)]
pub(crate) struct Stamped<T> {
    /// When it left its component.
    pub at: Time,
    /// Its place among all samples of the run, so that a reader of several connections sees them as they came.
    pub order: u64,
    pub value: T,
}

/// A queue that several connections have in common, as soon as the first one has made it.
pub(crate) type Queue = Option<Box<dyn Any + Send>>;

/// Why a connection cannot be made.
#[derive(Debug)]
pub(crate) enum OpenError {
    /// There is no sample of zeros.
    NoZero(DatumError),
    /// The queue carries samples of another type.
    OtherType,
}

/// The type of an input port, without the port: opens ways into it, whoever has the port.
pub(crate) trait Inlet: Send + Sync {
    /// Opens a way for a connection; with others, if there is a queue to have in common.
    fn open(
        &self,
        connection: ConnectionId,
        policy: &Policy,
        queue: Option<&mut Queue>,
    ) -> Result<(Box<dyn AnySender>, Incoming), OpenError>;
}

/// The reading end of a connection, on its way to its port.
pub(crate) struct Incoming(pub(super) Box<dyn Any + Send>);

/// The reading end of a connection.
pub(super) struct Way<T> {
    pub connection: ConnectionId,
    pub policy: Policy,
    /// What stands for a stale sample, if zeros do.
    pub zero: Option<T>,
    pub receiver: Receiving<T>,
}

/// How samples come out of a connection.
pub(super) enum Receiving<T> {
    /// As what the port takes.
    Own(Receiver<Stamped<T>>),
    /// As they were written.
    Pulled(Receiver<Stamped<Arc<dyn Sample>>>),
}

/// An inlet of this type.
pub(super) struct Of<T>(pub PhantomData<fn() -> T>);

impl<T: Message> Inlet for Of<T> {
    fn open(
        &self,
        connection: ConnectionId,
        policy: &Policy,
        queue: Option<&mut Queue>,
    ) -> Result<(Box<dyn AnySender>, Incoming), OpenError> {
        let zero: Option<T> = match policy.on_stale {
            // All fields of a message have an initial value.
            OnStale::Zero => {
                let zeros = Datum::Record(Vec::new());
                Some(zeros.to().map_err(OpenError::NoZero)?)
            }
            OnStale::Hold | OnStale::NoData => None,
        };
        let (sender, receiver): (Box<dyn AnySender>, _) = if policy.pull {
            let (sender, receiver) = ends(policy, queue)?;
            (Box::new(Unread(sender)), Receiving::Pulled(receiver))
        } else {
            let (sender, receiver) = ends::<T>(policy, queue)?;
            (Box::new(sender), Receiving::Own(receiver))
        };
        let way = Way {
            connection,
            policy: policy.clone(),
            zero,
            receiver,
        };
        Ok((sender, Incoming(Box::new(way))))
    }
}

impl<T: Message> Way<T> {
    /// Hands over what is there now. Counts what cannot be read.
    pub(super) fn drain(&mut self, mut give: impl FnMut(Stamped<T>)) -> u64 {
        match &mut self.receiver {
            Receiving::Own(receiver) => {
                receiver.drain(give);
                0
            }
            Receiving::Pulled(receiver) => {
                let mut unreadable = 0;
                receiver.drain(|Stamped { at, order, value }| match value.read() {
                    Ok(value) => give(Stamped { at, order, value }),
                    Err(_) => unreadable += 1,
                });
                unreadable
            }
        }
    }
}

impl<T> Way<T> {
    /// Whether nobody is there to write any more.
    pub(super) fn is_abandoned(&self) -> bool {
        match &self.receiver {
            Receiving::Own(receiver) => receiver.is_abandoned(),
            Receiving::Pulled(receiver) => receiver.is_abandoned(),
        }
    }
}

/// The two ends of a connection.
type Ends<T> = (Sender<Stamped<T>>, Receiver<Stamped<T>>);

/// Makes the two ends of a connection. `Joints::admit` has seen to it that both ends of an unsynchronised one are in one
/// thread.
fn ends<T: Send + 'static>(
    policy: &Policy,
    queue: Option<&mut Queue>,
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
            pool.ok_or(OpenError::OtherType)?.clone()
        }
    };
    Ok((pool.sender(), pool.receiver()))
}
