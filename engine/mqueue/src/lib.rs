//! Connects ports to Orocos components of other processes over POSIX message queues, in the wire format of RTT's
//! `mqueue` transport.
//!
//! ```no_run
//! use asmotion_mqueue::{FullQueuePolicy, QueueCapacity, QueueLayout, QueueName, QueueWriter};
//!
//! asmotion_datum::message! {
//!     /// Commanded joint angles.
//!     pub struct Command = "example/Command" {
//!         /// radians
//!         pub position: [f64; 5],
//!     }
//! }
//!
//! let layout = QueueLayout::of(<Command as asmotion_datum::Message>::schema())?;
//! let capacity = QueueCapacity { messages: 10, size: layout.size_or(0) };
//! let mut writer = QueueWriter::open(QueueName::new("/commands")?, layout, capacity, FullQueuePolicy::Oldest)?;
//! writer.send(&Command::default())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod capacity;
mod claim;
mod error;
mod layout;
mod name;
#[cfg(target_os = "linux")]
mod queue;
#[cfg(not(target_os = "linux"))]
#[path = "queue/absent.rs"]
mod queue;
mod queue_priority;
mod reader;
mod wire;
mod writer;

pub use capacity::QueueCapacity;
pub use error::{QueueCheckError, UnsupportedTypeError};
pub use layout::QueueLayout;
pub use name::QueueName;
pub use reader::{QueueEvent, QueueReader};
pub use writer::{FullQueuePolicy, QueueWriter};
