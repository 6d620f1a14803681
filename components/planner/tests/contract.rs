//! Every row of `PLANNERS` keeps the contract of planners, and what does not is found out.

#![allow(clippy::panic, reason = "a test fails by panicking")]

use asmotion_geometry::{Grid, Pose};
use asmotion_planner::contract::violations;
use asmotion_planner::{AStar, NoPath, PLANNERS, PlannedPath, Planner, PlannerSettings};

#[test]
fn n8_every_planner_keeps_the_contract() {
    for (name, make) in PLANNERS {
        assert_eq!(violations(*make), [""; 0], "{name}");
    }
}

/// A planner with a defect.
struct Defective(AStar, fn(&mut PlannedPath));

impl Planner for Defective {
    fn plan(&mut self, grid: &Grid, start: &Pose, goal: &Pose) -> Result<PlannedPath, NoPath> {
        let mut path = self.0.plan(grid, start, goal)?;
        (self.1)(&mut path);
        Ok(path)
    }
}

fn cases(violations: &[String]) -> Vec<&str> {
    let cases = violations.iter().filter_map(|it| it.split(':').next());
    cases.collect()
}

#[test]
fn a_planner_that_cuts_corners_lies_about_lengths_or_forgets_the_goal_is_found_out() {
    let straight = violations(|settings| {
        let careless = PlannerSettings {
            inflation_m: 0.0,
            ..settings.clone()
        };
        Box::new(AStar::new(&careless))
    });
    assert!(
        cases(&straight).contains(&"a path leads from room to room"),
        "{straight:?}"
    );
    let long =
        violations(|settings| Box::new(Defective(AStar::new(settings), |path| path.length *= 1.1)));
    assert!(
        cases(&long).contains(&"a path is straight where nothing is"),
        "{long:?}"
    );
    let short = violations(|settings| {
        Box::new(Defective(AStar::new(settings), |path| {
            path.poses.truncate(path.poses.len().max(2) - 1);
        }))
    });
    assert!(
        cases(&short).contains(&"a path begins and ends exactly at the poses"),
        "{short:?}"
    );
    let panics = violations(|_| panic!("no planner today"));
    assert!(
        panics.iter().all(|it| it.ends_with(": panicked")),
        "{panics:?}"
    );
}
