//! A running system seen and driven from outside, over any bus.
//!
//! Both ends of the contact are here. The system's: what it says of itself ([`Presence`]), what may be done to it
//! ([`Order`]), and who does both ([`Contact`]). The outside's: [`Remote`] finds [`Component`]s, whose life cycle,
//! properties, ports and services are at hand as if they were here. `docs/wire.md` says what goes over the wire.
//!
//! With the feature `amqp`, of a broker by its address:
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
//!     .then(|answer| println!("{answer:?}"))?;
//! # Ok(())
//! # }
//! ```

mod call;
mod contact;
mod error;
mod handle;
mod herald;
mod newest;
mod order;
mod presence;
mod refusal;
mod remote;
mod roster;
mod watch;

pub use self::call::Sent;
pub use self::contact::Contact;
pub use self::error::RemoteError;
pub use self::handle::{Component, Service};
pub use self::newest::Newest;
pub use self::order::{Begun, Order, Wish, control_address};
pub use self::presence::{
    Joined, PRESENCE, Presence, Present, PresentOperation, PresentService, PresentTopic, Typed,
    Word, key, presence_topic,
};
pub use self::refusal::{OrderError, Reason};
pub use self::remote::{Remote, listen};
pub use self::watch::Watch;
