//! `std_msgs`: primitives and the header.

use crate::builtin_interfaces::Time;

asmotion_datum::message! {
    /// A truth value (`std_msgs/Bool`).
    #[derive(Copy)]
    pub struct Bool = "std_msgs/Bool" {
        /// The value.
        pub data: bool,
    }

    /// A text (`std_msgs/String`; named `Text` so as not to hide Rust's own).
    pub struct Text = "std_msgs/String" {
        /// The value.
        pub data: String,
    }

    /// A number (`std_msgs/Float64`).
    #[derive(Copy)]
    pub struct Float64 = "std_msgs/Float64" {
        /// The value.
        pub data: f64,
    }

    /// Nothing but the fact that it came (`std_msgs/Empty`).
    #[derive(Copy)]
    pub struct Empty = "std_msgs/Empty" {}

    /// When something was measured, and in which frame its coordinates are (`std_msgs/Header`).
    pub struct Header = "std_msgs/Header" {
        /// The instant of measurement, not of sending.
        pub stamp: Time,
        /// The coordinate frame (REP-105): `map`, `odom`, `base_link`, `laser`.
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
