//! The state of the bus as a topic, for components that must act when it is gone.

/// The topic on which every system tells its own components how its bus is: a [`BusHealth`] at the start, and one at
/// every change. It stays inside.
pub const HEALTH_TOPIC: &str = "bus";

asmotion_datum::message! {
    /// How the bus of a system is.
    pub struct BusHealth = "bus/Health" {
        /// `UP`; `BLOCKED`: the broker takes nothing; `DOWN`: nothing goes out or comes in
        pub state: String = BusHealth::UP.to_owned(),
        /// why it is not up
        pub reason: String,
        /// since when, in nanoseconds of the run
        pub since: i64,
    }
}

impl BusHealth {
    /// Messages go through.
    pub const UP: &'static str = "UP";
    /// The broker takes nothing.
    pub const BLOCKED: &'static str = "BLOCKED";
    /// Nothing goes out or comes in.
    pub const DOWN: &'static str = "DOWN";
}
