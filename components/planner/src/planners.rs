//! The table of planners.

use crate::astar::AStar;
use crate::planner::{Planner, PlannerSettings};

/// Creates a planner with these settings.
pub type MakePlanner = fn(&PlannerSettings) -> Box<dyn Planner>;

/// All planners by name.
pub const PLANNERS: &[(&str, MakePlanner)] =
    &[("astar", |settings| Box::new(AStar::new(settings)))];

/// Creates the planner with this name; `None` if it is not in [`PLANNERS`].
pub fn planner(name: &str, settings: &PlannerSettings) -> Option<Box<dyn Planner>> {
    let row = PLANNERS.iter().find(|(known, _)| *known == name)?;
    Some((row.1)(settings))
}
