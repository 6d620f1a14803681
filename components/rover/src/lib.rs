//! The rover driver: differential-drive kinematics and odometry.
//!
//! [`Drive`] and [`Limits`] say how the wheels turn, [`Odometer`] where that leads, [`RoverDriver`] is the component.

mod drive;
mod driver;
mod odometry;

pub use drive::{Drive, Limits, Velocity};
pub use driver::RoverDriver;
pub use odometry::{Odometer, roll};
