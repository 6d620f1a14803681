//! Port writers: threads outside a system that write to one of its inputs, each through its own connection.

use std::sync::Arc;

use asmotion_datum::{DatumError, Message};
use asmotion_port::{LossCounter, PortSender, PushOutcome, Stamped};

use crate::handle::RunHandle;

/// Writes to an input port from outside the system; see [`Run::writer`](crate::Run::writer).
pub struct PortWriter<T: Message> {
    pub(super) port: String,
    pub(super) sender: PortSender<T>,
    /// The component to trigger; `None` if a sample on this port triggers no cycle.
    pub(super) trigger: Option<usize>,
    pub(super) mandatory: bool,
    pub(super) dropped: u64,
    /// The input's counter of lost messages.
    pub(super) losses: LossCounter,
    pub(super) handle: Arc<dyn RunHandle>,
}

/// The reason that a sample was not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// The system has ended.
    #[error("`{port}` is closed: its system has ended")]
    Gone {
        /// The input, as `component.port`.
        port: String,
    },
    /// The connection is mandatory, and full.
    #[error("`{port}` is full")]
    Full {
        /// The input, as `component.port`.
        port: String,
    },
    /// The port cannot read the sample.
    #[error("invalid sample for `{port}`: {source}")]
    Unreadable {
        /// The input, as `component.port`.
        port: String,
        /// The first difference between the sample and the port's type.
        source: DatumError,
    },
}

impl<T: Message> PortWriter<T> {
    /// Writes a sample, which the component sees in its next cycle. If the connection is full, the sample is dropped
    /// and counted; if the connection is mandatory, this is an error instead.
    ///
    /// # Errors
    /// [`WriteError::Gone`] after the end of the system, [`WriteError::Unreadable`] if the sample does not fit the type
    /// of the port, [`WriteError::Full`] if a mandatory connection has no room.
    pub fn write(&mut self, sample: T) -> Result<(), WriteError> {
        let port = || self.port.clone();
        if !self.handle.is_running() {
            return Err(WriteError::Gone { port: port() });
        }
        let delivery = self.sender.send_owned(Stamped {
            at: self.handle.now(),
            order: self.handle.next_order(),
            value: sample,
        });
        let delivery = delivery.map_err(|source| WriteError::Unreadable {
            port: port(),
            source,
        })?;
        let dropped = u64::from(delivery != PushOutcome::Stored);
        self.dropped += dropped;
        self.losses.add(dropped);
        if delivery == PushOutcome::DroppedNewest {
            return if self.mandatory {
                Err(WriteError::Full { port: port() })
            } else {
                Ok(())
            };
        }
        if let Some(component) = self.trigger {
            self.handle.trigger(component);
        }
        Ok(())
    }

    /// Number of samples dropped because the connection was full.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}
