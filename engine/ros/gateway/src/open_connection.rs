//! A connection of a bridge with its topics and operations.

use std::time::{Duration, Instant};

use asmotion_component::Losses;

use crate::frames::TransformReceivers;
use crate::operation::{OperationCaller, OperationServer};
use crate::shown::ComponentDisplay;
use crate::transport::{MessageReceiver, MessageSender, RosConnection};

/// Longest wait for the last messages to leave, when the bridge ends.
const LEAVE: Duration = Duration::from_millis(500);

/// A connection, with a sender or receiver for each mapping, in their order.
pub(crate) struct OpenConnection {
    // before the connection, which ends when it is dropped
    pub(crate) senders: Vec<Box<dyn MessageSender>>,
    pub(crate) receivers: Vec<Box<dyn MessageReceiver>>,
    pub(crate) callers: Vec<Box<dyn OperationCaller>>,
    pub(crate) servers: Vec<Box<dyn OperationServer>>,
    pub(crate) transforms: TransformReceivers,
    /// `None` if no component is shown.
    pub(crate) display: Option<Box<dyn ComponentDisplay>>,
    pub(crate) connection: Box<dyn RosConnection>,
}

/// Messages that have been sent leave before the node does.
impl Drop for OpenConnection {
    fn drop(&mut self) {
        let until = Instant::now() + LEAVE;
        for sender in &mut self.senders {
            sender.finish(until);
        }
    }
}

impl OpenConnection {
    /// The losses of all mappings.
    pub(crate) fn losses(&self) -> Losses {
        let senders = self.senders.iter().map(|it| it.losses());
        let receivers = self.receivers.iter().map(|it| it.losses());
        senders.chain(receivers).fold(Losses::default(), sum)
    }
}

/// The sum of losses.
pub(crate) fn sum(one: Losses, other: Losses) -> Losses {
    Losses {
        dropped: one.dropped + other.dropped,
        misfits: one.misfits + other.misfits,
    }
}
