//! The laser driver: ray casting with seeded noise.
//!
//! [`Optics`] makes a sweep, [`LaserDriver`] is the component.

mod driver;
mod sweep;

pub use driver::LaserDriver;
pub use sweep::Optics;

/// Protocol of the laser scanner: what it sends, depending on what it receives.
pub const PROTOCOL: &str = include_str!("../protocol.asm");
