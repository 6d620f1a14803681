//! The rover driver: differential-drive kinematics and odometry.
//!
//! [`DifferentialDrive`] and [`DriveLimits`] turn velocities into wheel speeds, [`Odometer`] integrates wheel angles,
//! [`WheelWatch`] notices stalled wheels, [`RoverDriver`] is the component.

mod drive;
mod driver;
mod odometry;
mod stall;

pub use drive::{DifferentialDrive, DriveLimits, Velocity};
pub use driver::RoverDriver;
pub use odometry::Odometer;
pub use stall::{Contact, StallLimits, WheelWatch};

/// Protocol of the rover driver: what it sends, depending on what it receives.
pub const PROTOCOL: &str = include_str!("../protocol.asm");
