//! Transport of samples from a writer to a reader within a process: the newest sample, or a queue (Orocos RTT's data,
//! buffer and circular buffer).
//!
//! A [`channel`] has one writer and one reader, and neither ever waits. A [`Pool`] has any number of both, and is
//! lock-free, locked or, if all of them are in one thread, unsynchronised.

mod buffer_kind;
mod channel;
#[cfg(not(feature = "loom"))]
mod gauge;
mod notifier;
mod pool;
mod prefetch;
mod push_outcome;
mod ring;
mod shared_buffer;
mod store;
mod sync;
mod triple;
mod unsync;

pub use buffer_kind::BufferKind;
pub use channel::{Receiver, Sender, channel};
#[cfg(not(feature = "loom"))]
pub use gauge::QueueGauge;
pub use notifier::Notifier;
pub use pool::Pool;
pub use prefetch::prefetch;
pub use push_outcome::PushOutcome;
