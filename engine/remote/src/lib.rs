//! Observes and controls a running system from outside, over any bus.
//!
//! The crate contains both ends. In the system, a [`ProcessContact`] publishes a description of the process
//! ([`Presence`]) and carries out requests ([`Order`]). Outside, a [`Remote`] finds [`RemoteComponent`]s, which give
//! access to life cycle, properties, ports and services. `docs/wire.md` describes the messages.
//!
//! With the feature `amqp`, a `Remote` connects to a broker by its address:
//!
//! ```no_run
//! # #[cfg(feature = "amqp")]
//! # fn show() -> Result<(), Box<dyn std::error::Error>> {
//! use std::time::Duration;
//!
//! let rover = asmotion_remote::Remote::connect("amqp://ann:secret@rover1/cell", Some("navigation"))?;
//! let follower = rover.component("TrajectoryFollower")?;
//! follower.set("max_speed", 0.3)?;
//! let map = rover.component("MapServer")?.service("maps")?;
//! let request = asmotion_datum::Datum::record([("name", asmotion_datum::Datum::text("office"))]);
//! map.send("getMap", request, Duration::from_secs(1))?
//!     .on_completion(|answer| println!("{answer:?}"))?;
//! # Ok(())
//! # }
//! ```

mod call;
mod clock;
mod command;
mod contact;
mod error;
mod handle;
mod last_samples;
mod levels;
mod message_check;
mod offers;
mod order;
mod order_error;
mod presence;
mod presence_publisher;
mod remote;
mod robot_watch;
mod roster;
mod stand_in;
mod watch;

pub use self::call::SendHandle;
pub use self::clock::{CLOCK_REMEDY, CLOCK_TOLERANCE, ClockOffset, clock_offsets};
pub use self::command::{CommandOutcome, CommandRecord, TabLogin};
pub use self::contact::ProcessContact;
pub use self::error::RemoteError;
pub use self::handle::{RemoteComponent, RemoteServiceHandle};
pub use self::last_samples::LastSamples;
pub use self::message_check::check_message;
pub use self::offers::FoundService;
pub use self::order::{Order, OrderKind, OrderOutcome, control_address};
pub use self::order_error::{OrderError, OrderErrorCode};
pub use self::presence::{
    PRESENCE, Presence, PresentComponent, PresentConnection, PresentEndpoint, PresentOperation,
    PresentService, PresentTopic, RobotPresence, key, presence_topic,
};
pub use self::remote::{Remote, listen};
pub use self::stand_in::{RobotComponent, StandIn};
pub use self::watch::{OutputWatch, WatchedSample};
