//! Path planning: planners on occupancy grids, and the component that provides them as a service.
//!
//! Metres and radians in the frame of the map (REP-103, REP-105).

mod astar;
mod component;
mod costs;
mod planner;
mod search;
mod smooth;

pub use self::component::TrajectoryPlanner;
pub use astar::AStar;
pub use planner::{
    Blocked, MakePlanner, NoPath, PLANNERS, PathEnd, PlannedPath, Planner, PlannerSettings, planner,
};
