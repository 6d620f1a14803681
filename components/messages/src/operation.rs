//! The operations of the navigation services, and their fault codes.

use asmotion_component::Operation;

use crate::nav::{Place, PlanRequest};
use crate::nav_msgs::{OccupancyGrid, Path};

/// Returns the map of a place.
#[derive(Debug, Clone, Copy)]
pub struct GetMap;

impl Operation for GetMap {
    type Request = Place;
    type Response = OccupancyGrid;
    const INTERFACE: &'static str = "nav/MapService";
    const NAME: &'static str = "getMap";
}

/// Plans a path from the robot's pose to a goal.
#[derive(Debug, Clone, Copy)]
pub struct Plan;

impl Operation for Plan {
    type Request = PlanRequest;
    type Response = Path;
    const INTERFACE: &'static str = "nav/PlanService";
    const NAME: &'static str = "plan";
}

impl Plan {
    /// Fault code: start and goal are free, but no path connects them.
    pub const NO_PATH: &str = "NO_PATH";
    /// Fault code: the robot cannot stand at the start.
    pub const START_OCCUPIED: &str = "START_OCCUPIED";
    /// Fault code: the robot cannot stand at the goal.
    pub const GOAL_OCCUPIED: &str = "GOAL_OCCUPIED";
    /// Fault code: start or goal is outside the map.
    pub const OUTSIDE: &str = "OUTSIDE";
    /// Fault code: there is no map, or it is invalid.
    pub const BAD_MAP: &str = "BAD_MAP";
}
