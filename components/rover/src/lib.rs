//! The rover driver: differential-drive kinematics and odometry.
//!
//! [`Drive`] and [`Limits`] turn velocities into wheel speeds, [`Odometer`] integrates wheel angles, [`RoverDriver`] is the
//! component.

mod drive;
mod driver;
mod odometry;

pub use drive::{Drive, Limits, Velocity};
pub use driver::RoverDriver;
pub use odometry::{Odometer, roll};
