//! The collision monitor: the last limit of a command before the rover.
//!
//! [`Zones`] decides how fast a command may be driven, [`CollisionMonitor`] is the component.

mod collision_monitor;
mod zones;

pub use collision_monitor::CollisionMonitor;
pub use zones::{PlanarVelocity, Verdict, Zones};

/// Protocol of the collision monitor: what it sends, depending on what it receives.
pub const PROTOCOL: &str = include_str!("../protocol.asm");
