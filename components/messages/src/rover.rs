//! `rover`: the two wheels of a differential drive.

use crate::builtin_interfaces::Time;

asmotion_datum::message! {
    /// How fast each wheel shall turn, or turns; forward positive.
    #[derive(Copy)]
    pub struct WheelSpeeds = "rover/WheelSpeeds" {
        /// rad/s.
        pub left: f64,
        /// rad/s.
        pub right: f64,
    }

    /// How far each wheel has turned since the encoders' zero; forward positive, never wrapped.
    #[derive(Copy)]
    pub struct Encoders = "rover/Encoders" {
        /// When both were read.
        pub stamp: Time,
        /// rad.
        pub left: f64,
        /// rad.
        pub right: f64,
    }
}
