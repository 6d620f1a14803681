//! The rover driver: differential-drive kinematics and odometry.
//!
//! [`DifferentialDrive`] and [`DriveLimits`] turn velocities into wheel speeds, [`Odometer`] integrates wheel angles, [`RoverDriver`] is the
//! component.

mod drive;
mod driver;
mod odometry;

pub use drive::{DifferentialDrive, DriveLimits, Velocity};
pub use driver::RoverDriver;
pub use odometry::Odometer;
