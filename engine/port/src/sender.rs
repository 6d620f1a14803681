//! The writing end of a connection, at its writer.

use std::any::Any;
use std::sync::Arc;

use asmotion_connection::{PushOutcome, Sender};
use asmotion_datum::{DatumError, Message, Sample};

use crate::time::Time;

/// A sample on its way.
#[derive(Debug, Clone)]
pub struct Stamped<T> {
    /// The time of the writer's cycle.
    pub at: Time,
    /// Position among all samples of the run: a reader of several connections sorts by it.
    pub order: u64,
    /// The sample itself.
    pub value: T,
}

/// A writing end that accepts samples of any type, and converts them to its reader's.
pub trait AnySender: Any + Send {
    /// Checks that a sample can be read as the reader's type.
    ///
    /// # Errors
    /// The first field that does not fit.
    fn accepts(&self, sample: &Arc<dyn Sample>) -> Result<(), DatumError>;

    /// Sends a sample, converted to the reader's type.
    ///
    /// # Errors
    /// The first field that does not fit; nothing has been sent then.
    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        at: Time,
        order: u64,
    ) -> Result<PushOutcome, DatumError>;
}

impl<T: Message> AnySender for Sender<Stamped<T>> {
    fn accepts(&self, sample: &Arc<dyn Sample>) -> Result<(), DatumError> {
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

/// A writing end whose reader converts: samples stay as they were written ([`Policy::pull`](crate::Policy::pull)).
pub(crate) struct PulledSender(pub Sender<Stamped<Arc<dyn Sample>>>);

impl AnySender for PulledSender {
    fn accepts(&self, _: &Arc<dyn Sample>) -> Result<(), DatumError> {
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

/// How samples of a type get into a connection.
pub enum PortSender<T> {
    /// The reader has the same type: it gets the sample itself.
    Same(Sender<Stamped<T>>),
    /// The reader has another type, or is a bus: it gets the sample behind a pointer, and reads it.
    Shared(Box<dyn AnySender>),
}

impl<T: Message> PortSender<T> {
    /// A sender whose type is looked up once, so that equal types need no conversion. `None` never happens: the type
    /// has been checked.
    pub fn of(sender: Box<dyn AnySender>) -> Option<Self> {
        if !(&*sender as &dyn Any).is::<Sender<Stamped<T>>>() {
            return Some(Self::Shared(sender));
        }
        let same = (sender as Box<dyn Any>).downcast();
        same.map(|sender| Self::Same(*sender)).ok()
    }

    /// Sends a copy.
    ///
    /// # Errors
    /// The reader's type does not fit the sample.
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
    /// The reader's type does not fit the sample.
    pub fn hand_over(&mut self, sample: Stamped<T>) -> Result<PushOutcome, DatumError> {
        match self {
            Self::Same(sender) => Ok(sender.send(sample)),
            Self::Shared(sender) => {
                sender.send_sample(Arc::new(sample.value), sample.at, sample.order)
            }
        }
    }
}
