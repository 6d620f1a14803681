//! The table of planners.

use crate::astar::AStar;
use crate::planner::{Planner, PlannerSettings};

/// Creates a planner with these settings.
pub type MakePlanner = fn(&PlannerSettings) -> Box<dyn Planner>;

/// The planners of this crate by name.
pub const PLANNERS: &[(&str, MakePlanner)] =
    &[("astar", |settings| Box::new(AStar::new(settings)))];

/// A selection of planners, by name.
#[derive(Clone, Debug)]
pub struct Planners(Vec<(&'static str, MakePlanner)>);

impl Planners {
    /// All planners of [`PLANNERS`].
    pub fn standard() -> Self {
        Self(PLANNERS.to_vec())
    }

    /// Adds a planner. A planner with a name that is taken replaces the earlier one.
    pub fn with(mut self, name: &'static str, make: MakePlanner) -> Self {
        self.0.retain(|(known, _)| *known != name);
        self.0.push((name, make));
        self
    }

    /// Names, in the order in which the planners were added.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|(name, _)| *name)
    }

    /// Creates the planner with this name; `None` without one.
    pub fn make(&self, name: &str, settings: &PlannerSettings) -> Option<Box<dyn Planner>> {
        let row = self.0.iter().find(|(known, _)| *known == name)?;
        Some((row.1)(settings))
    }
}
