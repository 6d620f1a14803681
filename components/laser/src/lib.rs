//! The laser driver: ray casting with seeded noise.
//!
//! [`Optics`] makes a sweep, [`LaserDriver`] is the component.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod driver;
mod sweep;

pub use driver::LaserDriver;
pub use sweep::Optics;
