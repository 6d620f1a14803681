//! Priorities of messages, which tell our writers' messages from those of others.

/// The priority of a message. The kernel delivers higher priorities first, and messages of one priority in order. Other
/// programs, RTT among them, send with priority 0 and ignore the priority of what they receive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum QueuePriority {
    /// A message of a program other than ours, which may show its layout only.
    Foreign,
    /// Data from one of our writers.
    Data,
    /// A message from one of our writers that only shows the layout. Sent into an empty queue, so that the priority
    /// does not change the order.
    Layout,
}

impl QueuePriority {
    /// The priority's number on the wire.
    pub(crate) fn number(self) -> u32 {
        match self {
            Self::Foreign => 0,
            Self::Data => 1,
            Self::Layout => 2,
        }
    }

    /// The meaning of a number.
    pub(crate) fn of(number: u32) -> Self {
        match number {
            1 => Self::Data,
            2 => Self::Layout,
            _ => Self::Foreign,
        }
    }
}
