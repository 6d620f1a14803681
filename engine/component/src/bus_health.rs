//! The state of the bus as a topic, for components that must react to its loss.

/// The topic on which every system publishes the state of its bus to its own components: a [`BusHealth`] at the start
/// and at every change. It is not forwarded to the bus.
pub const HEALTH_TOPIC: &str = "bus";

asmotion_datum::message! {
    /// The state of a system's bus.
    pub struct BusHealth = "bus/Health" {
        /// `UP`; `BLOCKED`: the broker accepts no messages; `DOWN`: no connection
        pub state: String = BusHealth::UP.to_owned(),
        /// the reason, if the bus is not up; else empty
        pub reason: String,
        /// time of the change, in nanoseconds since the start of the run
        pub since: i64,
    }
}

impl BusHealth {
    /// Messages are transported.
    pub const UP: &'static str = "UP";
    /// The broker accepts no messages.
    pub const BLOCKED: &'static str = "BLOCKED";
    /// There is no connection.
    pub const DOWN: &'static str = "DOWN";
}
