//! `rover`: the two wheels of a differential drive.

use crate::builtin_interfaces::Time;
use asmotion_datum::DatumError;

use crate::plausible::{LARGEST_ANGLE, LARGEST_SPEED, bounded};

asmotion_datum::message! {
    /// Commanded or measured speed of each wheel; positive is forward.
    #[derive(Copy)]
    pub struct WheelSpeeds = "rover/WheelSpeeds", check = check_speeds {
        /// Speed of the left wheel, rad/s.
        pub left: f64,
        /// Speed of the right wheel, rad/s.
        pub right: f64,
    }

    /// Angle of each wheel since the encoders' zero; positive is forward, never wrapped.
    #[derive(Copy)]
    pub struct Encoders = "rover/Encoders", check = check_encoders {
        /// Time at which both were read.
        pub stamp: Time,
        /// Angle of the left wheel, rad.
        pub left: f64,
        /// Angle of the right wheel, rad.
        pub right: f64,
    }
}

fn check_speeds(speeds: &WheelSpeeds) -> Result<(), DatumError> {
    bounded("left", speeds.left, LARGEST_SPEED)?;
    bounded("right", speeds.right, LARGEST_SPEED)
}

fn check_encoders(encoders: &Encoders) -> Result<(), DatumError> {
    bounded("left", encoders.left, LARGEST_ANGLE)?;
    bounded("right", encoders.right, LARGEST_ANGLE)
}
