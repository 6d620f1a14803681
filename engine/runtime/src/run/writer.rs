//! Port writers: threads outside of a system that write to one of its inputs, each by a connection of its own.

use std::sync::Arc;

use asmotion_datum::{DatumError, Message};
use asmotion_port::{PortSender, PushOutcome, Stamped};

use crate::handle::RunHandle;

/// Writes to an input port from outside of the system; see [`Run::writer`](crate::Run::writer).
pub struct PortWriter<T: Message> {
    pub(super) port: String,
    pub(super) sender: PortSender<T>,
    /// The component to trigger, if it is to be.
    pub(super) trigger: Option<usize>,
    pub(super) mandatory: bool,
    pub(super) dropped: u64,
    pub(super) handle: Arc<dyn RunHandle>,
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

impl<T: Message> PortWriter<T> {
    /// Writes a sample; the component sees it in its next cycle. One that does not fit is dropped and counted, or an
    /// error if the connection is mandatory.
    pub fn write(&mut self, sample: T) -> Result<(), WriteError> {
        let port = || self.port.clone();
        if !self.handle.is_running() {
            return Err(WriteError::Gone { port: port() });
        }
        let delivery = self.sender.hand_over(Stamped {
            at: self.handle.now(),
            order: self.handle.next_order(),
            value: sample,
        });
        let delivery = delivery.map_err(|source| WriteError::Unreadable {
            port: port(),
            source,
        })?;
        self.dropped += u64::from(delivery != PushOutcome::Stored);
        if delivery == PushOutcome::DroppedNewest {
            return match self.mandatory {
                true => Err(WriteError::Full { port: port() }),
                false => Ok(()),
            };
        }
        if let Some(component) = self.trigger {
            self.handle.trigger(component);
        }
        Ok(())
    }

    /// How many samples had to go for want of room.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}
