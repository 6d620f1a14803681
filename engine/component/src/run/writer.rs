//! Writers: those outside of a system who write to one of its ports, by a connection of their own.

use std::sync::Arc;

use asmotion_connection::Delivery;
use asmotion_datum::{DatumError, Message};

use super::Beyond;
use crate::port::{Outlet, Stamped};

/// Writes to an input port from outside of the system; see [`Run::writer`](crate::Run::writer).
pub struct Writer<T: Message> {
    pub(super) port: String,
    pub(super) outlet: Outlet<T>,
    /// The component to tell, if it is to be triggered.
    pub(super) tell: Option<usize>,
    pub(super) mandatory: bool,
    pub(super) dropped: u64,
    pub(super) beyond: Arc<dyn Beyond>,
}

/// Why a sample was not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// The system is gone.
    #[error("`{port}` is gone: its system has ended")]
    Gone {
        /// The port.
        port: String,
    },
    /// The connection is mandatory, and full.
    #[error("`{port}` is full")]
    Full {
        /// The port.
        port: String,
    },
    /// The port cannot read the sample.
    #[error("`{port}` cannot read the sample: {source}")]
    Unreadable {
        /// The port.
        port: String,
        /// Why.
        source: DatumError,
    },
}

impl<T: Message> Writer<T> {
    /// Writes a sample; the component sees it in its next cycle. One that does not fit is dropped and counted, or an
    /// error if the connection is mandatory.
    pub fn write(&mut self, sample: T) -> Result<(), WriteError> {
        let port = || self.port.clone();
        if !self.beyond.is_there() {
            return Err(WriteError::Gone { port: port() });
        }
        let delivery = self.outlet.hand_over(Stamped {
            at: self.beyond.now(),
            order: self.beyond.next_order(),
            value: sample,
        });
        let delivery = delivery.map_err(|source| WriteError::Unreadable {
            port: port(),
            source,
        })?;
        self.dropped += u64::from(delivery != Delivery::Stored);
        if delivery == Delivery::DroppedNewest {
            return match self.mandatory {
                true => Err(WriteError::Full { port: port() }),
                false => Ok(()),
            };
        }
        if let Some(component) = self.tell {
            self.beyond.news(component);
        }
        Ok(())
    }

    /// How many samples had to go for want of room.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}
