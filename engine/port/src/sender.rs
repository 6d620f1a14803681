//! The writing ends of connections.

use std::any::Any;
use std::sync::Arc;

use asmotion_connection::{PushOutcome, Sender};
use asmotion_datum::{DatumError, Message, Sample};

use crate::time::Time;

/// A sample with the time and order in which it was written.
#[derive(Debug, Clone)]
pub struct Stamped<T> {
    /// Time of the writer's cycle.
    pub at: Time,
    /// Order number among all samples of the run, by which a port merges its connections.
    pub order: u64,
    /// The sample in the writer's type.
    pub value: T,
}

/// A writing end that accepts samples of any type and converts them to the reader's type.
pub trait AnySender: Any + Send {
    /// Checks that a sample can be read as the reader's type.
    ///
    /// # Errors
    /// The first difference between the types.
    fn check(&self, sample: &Arc<dyn Sample>) -> Result<(), DatumError>;

    /// Sends a sample, converted to the reader's type.
    ///
    /// # Errors
    /// The first difference between the types; in this case nothing has been sent.
    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        at: Time,
        order: u64,
    ) -> Result<PushOutcome, DatumError>;
}

impl<T: Message> AnySender for Sender<Stamped<T>> {
    fn check(&self, sample: &Arc<dyn Sample>) -> Result<(), DatumError> {
        Arc::clone(sample).read::<T>().map(drop)
    }

    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        at: Time,
        order: u64,
    ) -> Result<PushOutcome, DatumError> {
        let value = sample.read()?;
        Ok(self.send(Stamped { at, order, value }))
    }
}

/// A writing end whose reader converts: samples are passed as written ([`Policy::pull`](crate::Policy::pull)).
pub(crate) struct PulledSender(pub Sender<Stamped<Arc<dyn Sample>>>);

impl AnySender for PulledSender {
    fn check(&self, _: &Arc<dyn Sample>) -> Result<(), DatumError> {
        Ok(())
    }

    fn send_sample(
        &mut self,
        value: Arc<dyn Sample>,
        at: Time,
        order: u64,
    ) -> Result<PushOutcome, DatumError> {
        Ok(self.0.send(Stamped { at, order, value }))
    }
}

/// The writing end of a connection, at an output of type `T`.
pub enum PortSender<T> {
    /// The reader has the same type and gets the sample itself.
    Same(Sender<Stamped<T>>),
    /// The reader has another type, or is outside the system; it gets a pointer and converts.
    Shared(Box<dyn AnySender>),
}

impl<T: Message> PortSender<T> {
    /// Determines once whether the reader has the same type, in which case no conversion is needed. Never returns
    /// `None`: the downcast follows a check of the type.
    pub fn of(sender: Box<dyn AnySender>) -> Option<Self> {
        if !(&*sender as &dyn Any).is::<Sender<Stamped<T>>>() {
            return Some(Self::Shared(sender));
        }
        let same = (sender as Box<dyn Any>).downcast();
        same.map(|sender| Self::Same(*sender)).ok()
    }

    /// Prefetches the queue, if the reader has the same type.
    pub(crate) fn prefetch(&self) {
        match self {
            Self::Same(sender) => sender.prefetch(),
            Self::Shared(sender) => asmotion_connection::prefetch(&**sender),
        }
    }

    /// Sends a copy of the sample.
    ///
    /// # Errors
    /// An error if the sample cannot be converted to the reader's type.
    pub fn send(&mut self, sample: &Stamped<T>) -> Result<PushOutcome, DatumError> {
        match self {
            Self::Same(sender) => Ok(sender.send(sample.clone())),
            Self::Shared(sender) => {
                sender.send_sample(sample.value.to_shared(), sample.at, sample.order)
            }
        }
    }

    /// Sends the sample itself.
    ///
    /// # Errors
    /// An error if the sample cannot be converted to the reader's type.
    pub fn send_owned(&mut self, sample: Stamped<T>) -> Result<PushOutcome, DatumError> {
        match self {
            Self::Same(sender) => Ok(sender.send(sample)),
            Self::Shared(sender) => {
                sender.send_sample(Arc::new(sample.value), sample.at, sample.order)
            }
        }
    }
}
