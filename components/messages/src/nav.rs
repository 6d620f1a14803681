//! `nav`: what the navigation components tell each other beyond ROS.

use crate::builtin_interfaces::Time;
use crate::geometry_msgs::PoseStamped;
use crate::nav_msgs::OccupancyGrid;
use crate::world::Disc;

asmotion_datum::message! {
    /// Something happened that a coordinator may care about.
    pub struct Event = "nav/Event" {
        /// When.
        pub stamp: Time,
        /// What, as a short name in capitals: see the constants.
        pub code: String,
        /// For people: where, why.
        pub detail: String,
    }

    /// A place that has a map.
    pub struct Place = "nav/Place" {
        /// Its name, as the map server knows it.
        pub name: String,
    }

    /// From where to where, on which map.
    pub struct PlanRequest = "nav/PlanRequest" {
        /// The map to plan on.
        pub map: OccupancyGrid,
        /// Where the robot is, in the map's frame.
        pub start: PoseStamped,
        /// Where it shall be, in the map's frame.
        pub goal: PoseStamped,
    }

    /// Things that a robot saw and that may be missing on the map, in the map frame.
    pub struct Obstacles = "nav/Obstacles" {
        /// When the newest of them was seen.
        pub stamp: Time,
        /// Their outlines, each covered by a disc.
        pub discs: Vec<Disc>,
    }
}

impl Event {
    /// The follower stands at the end of its path.
    pub const REACHED: &str = "REACHED";
    /// The follower had to stop and now stands.
    pub const HALTED: &str = "HALTED";
    /// The adapter finds no way past an obstacle.
    pub const BLOCKED: &str = "BLOCKED";
    /// The robot touched something.
    pub const COLLISION: &str = "COLLISION";

    /// The event `code` at `nanos` nanoseconds after the clock's zero.
    pub fn new(nanos: i64, code: &str, detail: impl Into<String>) -> Self {
        Self {
            stamp: Time::from_nanos(nanos),
            code: code.to_owned(),
            detail: detail.into(),
        }
    }
}
