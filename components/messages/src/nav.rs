//! `nav`: messages between navigation components that ROS does not define.

use crate::builtin_interfaces::Time;
use crate::geometry_msgs::PoseStamped;
use crate::nav_msgs::OccupancyGrid;
use crate::world::Vertex;

asmotion_datum::message! {
    /// An event of interest to a coordinator.
    pub struct Event = "nav/Event" {
        /// Time of the event.
        pub stamp: Time,
        /// Stamp of the path that the event is about: of the last order to drive or to stop; zero if there is none.
        pub plan: Time,
        /// Kind of event: a short name in capitals, see the constants.
        pub code: String,
        /// Explanation for a human reader: place and cause.
        pub detail: String,
    }

    /// A place that has a map.
    pub struct Place = "nav/Place" {
        /// Name of the place at the map server.
        pub name: String,
    }

    /// A request for a path between two poses.
    pub struct PlanRequest = "nav/PlanRequest" {
        /// The map to plan on.
        pub map: OccupancyGrid,
        /// Pose of the robot, in the map's frame.
        pub start: PoseStamped,
        /// Pose to reach, in the map's frame.
        pub goal: PoseStamped,
    }

    /// Obstacles that a robot saw and that may be missing on the map, map frame.
    pub struct Obstacles = "nav/Obstacles" {
        /// Time at which the newest of them was seen.
        pub stamp: Time,
        /// Points of their surfaces, where beams of a laser ended.
        pub points: Vec<Vertex>,
    }
}

impl Event {
    /// The follower stands at the end of its path.
    pub const REACHED: &str = "REACHED";
    /// The follower had to stop and now stands.
    pub const HALTED: &str = "HALTED";
    /// The adapter finds no way past an obstacle.
    pub const BLOCKED: &str = "BLOCKED";
    /// The robot touches something, as its own sensors show.
    pub const CONTACT: &str = "CONTACT";
    /// The robot touched something, as the simulated world knows.
    pub const COLLISION: &str = "COLLISION";

    /// An event of this kind, `nanos` nanoseconds after the clock's zero.
    pub fn new(nanos: i64, code: &str, detail: impl Into<String>) -> Self {
        Self {
            stamp: Time::from_nanos(nanos),
            plan: Time::default(),
            code: code.to_owned(),
            detail: detail.into(),
        }
    }

    /// The same event about the path with this stamp.
    #[must_use]
    pub fn about(self, plan: Time) -> Self {
        Self { plan, ..self }
    }
}
