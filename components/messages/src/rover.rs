//! `rover`: the two wheels of a differential drive.

use crate::builtin_interfaces::Time;

asmotion_datum::message! {
    /// Commanded or measured speed of each wheel; positive is forward.
    #[derive(Copy)]
    pub struct WheelSpeeds = "rover/WheelSpeeds" {
        /// Speed of the left wheel, rad/s.
        pub left: f64,
        /// Speed of the right wheel, rad/s.
        pub right: f64,
    }

    /// Angle of each wheel since the encoders' zero; positive is forward, never wrapped.
    #[derive(Copy)]
    pub struct Encoders = "rover/Encoders" {
        /// Time at which both were read.
        pub stamp: Time,
        /// Angle of the left wheel, rad.
        pub left: f64,
        /// Angle of the right wheel, rad.
        pub right: f64,
    }
}
