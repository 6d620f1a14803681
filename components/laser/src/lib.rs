//! The laser driver: ray casting with seeded noise.
//!
//! [`Optics`] makes a sweep, [`LaserDriver`] is the component.

mod driver;
mod sweep;

pub use driver::LaserDriver;
pub use sweep::Optics;
