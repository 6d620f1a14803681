//! A door to Orocos components of other processes: ports joined over POSIX message queues, with the wire format of RTT's
//! `mqueue` transport.
//!
//! ```no_run
//! use asmotion_mqueue::{Keep, Layout, Name, Room, Writer};
//!
//! asmotion_datum::message! {
//!     /// What the joints are told.
//!     pub struct Command = "example/Command" {
//!         /// radians
//!         pub position: [f64; 5],
//!     }
//! }
//!
//! let layout = Layout::of(<Command as asmotion_datum::Message>::schema())?;
//! let room = Room { messages: 10, size: layout.size_or(0) };
//! let mut writer = Writer::open(Name::new("/commands")?, layout, room, Keep::Oldest)?;
//! writer.send(&Command::default())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod layout;
mod name;
#[cfg(target_os = "linux")]
mod queue;
#[cfg(not(target_os = "linux"))]
#[path = "queue/absent.rs"]
mod queue;
mod reader;
mod wire;
mod writer;

pub use error::{QueueCheckError, UnsupportedTypeError};
pub use layout::QueueLayout;
pub use name::QueueName;
pub use reader::{FirstMessage, QueueReader};
pub use writer::{FullQueuePolicy, QueueCapacity, QueueWriter};
