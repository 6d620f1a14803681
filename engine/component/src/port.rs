//! Ports at run time: typed inside, joined without knowing the type.

mod channel;
mod input;
mod one_thread;
mod outlet;
mod output;

use std::sync::Arc;

use asmotion_datum::{DatumError, Message, Sample};

use asmotion_connection::{Delivery, Sender};

pub(crate) use self::channel::{Incoming, Inlet, OpenError, Queue, Stamped};
pub(crate) use self::input::{AnyInput, Input};
pub(crate) use self::outlet::Outlet;
pub(crate) use self::output::{AnyOutput, Link, News, Output, Reader};

use crate::Time;

/// What an input port shows (RTT `FlowStatus`; TCA `receiveLast`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow<T> {
    /// Nothing has ever come.
    NoData,
    /// The newest sample, seen by an earlier cycle too.
    OldData(T),
    /// The newest sample, come since the last cycle.
    NewData(T),
}

impl<T> Flow<T> {
    /// The sample, if it is new.
    #[allow(
        clippy::new_ret_no_self,
        clippy::wrong_self_convention,
        reason = "RTT's word: NewData"
    )]
    pub fn new(self) -> Option<T> {
        match self {
            Self::NewData(sample) => Some(sample),
            Self::NoData | Self::OldData(_) => None,
        }
    }

    /// The sample, new or old.
    pub fn any(self) -> Option<T> {
        match self {
            Self::NewData(sample) | Self::OldData(sample) => Some(sample),
            Self::NoData => None,
        }
    }

    /// Whether the sample is new.
    pub fn is_new(&self) -> bool {
        matches!(self, Self::NewData(_))
    }
}

/// A sending end whose type is the reader's, not the writer's.
pub(crate) trait AnySender: std::any::Any + Send {
    /// Whether a sample can be read as what the reader takes.
    fn accepts(&self, sample: &Arc<dyn Sample>) -> Result<(), DatumError>;

    /// Sends a sample, read as what the reader takes.
    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        at: Time,
        order: u64,
    ) -> Result<Delivery, DatumError>;
}

/// A way into a port of this type.
impl<T: Message> AnySender for Sender<Stamped<T>> {
    fn accepts(&self, sample: &Arc<dyn Sample>) -> Result<(), DatumError> {
        Arc::clone(sample).read::<T>().map(drop)
    }

    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        at: Time,
        order: u64,
    ) -> Result<Delivery, DatumError> {
        let value = sample.read()?;
        Ok(self.send(Stamped { at, order, value }))
    }
}

/// A way on which samples stay as they are: the reader reads them as what it takes.
struct Unread(Sender<Stamped<Arc<dyn Sample>>>);

impl AnySender for Unread {
    fn accepts(&self, _: &Arc<dyn Sample>) -> Result<(), DatumError> {
        Ok(())
    }

    fn send_sample(
        &mut self,
        value: Arc<dyn Sample>,
        at: Time,
        order: u64,
    ) -> Result<Delivery, DatumError> {
        Ok(self.0.send(Stamped { at, order, value }))
    }
}
