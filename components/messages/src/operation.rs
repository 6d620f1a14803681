//! The operations of the navigation services, and the faults they may answer with.

use asmotion_component::Operation;

use crate::nav::{Place, PlanRequest};
use crate::nav_msgs::{OccupancyGrid, Path};

/// The map of a place.
#[derive(Debug, Clone, Copy)]
pub struct GetMap;

impl Operation for GetMap {
    type Request = Place;
    type Response = OccupancyGrid;
    const INTERFACE: &'static str = "nav/MapService";
    const NAME: &'static str = "getMap";
}

/// A path from where the robot is to where it shall be.
#[derive(Debug, Clone, Copy)]
pub struct Plan;

impl Operation for Plan {
    type Request = PlanRequest;
    type Response = Path;
    const INTERFACE: &'static str = "nav/PlanService";
    const NAME: &'static str = "plan";
}

impl Plan {
    /// Fault code: start and goal are free, but nothing leads from one to the other.
    pub const NO_PATH: &str = "NO_PATH";
    /// Fault code: the robot cannot stand where it starts.
    pub const START_OCCUPIED: &str = "START_OCCUPIED";
    /// Fault code: the robot cannot stand where it shall go.
    pub const GOAL_OCCUPIED: &str = "GOAL_OCCUPIED";
    /// Fault code: start or goal is not on the map.
    pub const OUTSIDE: &str = "OUTSIDE";
    /// Fault code: there is no map, or it is none.
    pub const BAD_MAP: &str = "BAD_MAP";
}
