//! Ports at run time: typed inside, joined without knowing the type.

mod input;
mod output;

use std::sync::Arc;

use datum::{DatumError, Message, Sample};

pub(crate) use input::{AnyInput, Input};
pub(crate) use output::{AnyOutput, Link, Output};

use crate::Time;
use crate::connection::{Delivery, Sender, Stamped};

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

impl<T: Message> AnySender for Sender<T> {
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
