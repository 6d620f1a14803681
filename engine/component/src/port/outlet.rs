//! The writing end of a connection, at its writer.

use std::any::Any;
use std::sync::Arc;

use asmotion_connection::{Delivery, Sender};
use asmotion_datum::{DatumError, Message, Sample};

use super::AnySender;
use super::channel::Stamped;

/// How samples get into a connection.
pub(crate) enum Outlet<T> {
    /// The reader has the same type: the sample itself.
    Same(Sender<Stamped<T>>),
    /// The reader has another type, or is a bus: the sample behind a pointer, for the other end to read.
    Shared(Box<dyn AnySender>),
}

impl<T: Message> Outlet<T> {
    pub(crate) fn of(sender: Box<dyn AnySender>) -> Option<Self> {
        if !(&*sender as &dyn Any).is::<Sender<Stamped<T>>>() {
            return Some(Self::Shared(sender));
        }
        let same = (sender as Box<dyn Any>).downcast();
        same.map(|sender| Self::Same(*sender)).ok()
    }

    /// Sends a copy.
    pub(crate) fn send(&mut self, sample: &Stamped<T>) -> Result<Delivery, DatumError> {
        match self {
            Self::Same(sender) => Ok(sender.send(sample.clone())),
            Self::Shared(sender) => {
                sender.send_sample(sample.value.to_shared(), sample.at, sample.order)
            }
        }
    }

    /// Sends the sample itself.
    pub(crate) fn hand_over(&mut self, sample: Stamped<T>) -> Result<Delivery, DatumError> {
        match self {
            Self::Same(sender) => Ok(sender.send(sample)),
            Self::Shared(sender) => {
                sender.send_sample(Arc::new(sample.value), sample.at, sample.order)
            }
        }
    }
}
