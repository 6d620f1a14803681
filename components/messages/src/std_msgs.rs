//! `std_msgs`: primitives and the header.

use crate::builtin_interfaces::Time;

asmotion_datum::message! {
    /// A Boolean (`std_msgs/Bool`).
    #[derive(Copy)]
    pub struct Bool = "std_msgs/Bool" {
        /// `true` or `false`.
        pub data: bool,
    }

    /// A text (`std_msgs/String`; named `Text` to avoid a clash with Rust's `String`).
    pub struct Text = "std_msgs/String" {
        /// UTF-8 text.
        pub data: String,
    }

    /// A number (`std_msgs/Float64`).
    #[derive(Copy)]
    pub struct Float64 = "std_msgs/Float64" {
        /// A finite number, infinity or NaN.
        pub data: f64,
    }

    /// A message without content (`std_msgs/Empty`).
    #[derive(Copy)]
    pub struct Empty = "std_msgs/Empty" {}

    /// The time of a measurement, and the frame of its coordinates (`std_msgs/Header`).
    pub struct Header = "std_msgs/Header" {
        /// Time of the measurement, not of sending.
        pub stamp: Time,
        /// Name of the coordinate frame (REP-105): `map`, `odom`, `base_link`, `laser`.
        pub frame_id: String,
    }
}

impl Header {
    /// The header of data taken `nanos` nanoseconds after the clock's zero, in frame `frame_id`.
    pub fn new(nanos: i64, frame_id: &str) -> Self {
        Self {
            stamp: Time::from_nanos(nanos),
            frame_id: frame_id.to_owned(),
        }
    }
}
