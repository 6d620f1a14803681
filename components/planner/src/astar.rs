//! The grid planner: costs, search, shortcuts.

use asmotion_geometry::{Cell, Grid, Occupancy, Point, Polyline, Pose, heading, yaw};

use crate::costs::{Costs, TIGHT, WALL};
use crate::planner::{Blocked, NoPath, PathEnd, PlannedPath, Planner, PlannerSettings};
use crate::search::GridSearch;
use crate::smooth::{Knot, smooth};

/// A* over the inflated grid; then replaces parts of the path by straight lines that cost no more.
///
/// A robot that stands nearer to an obstacle than the inflation may leave by the shortest way; no other part of a path
/// comes that near.
pub struct AStar {
    settings: PlannerSettings,
    costs: Costs,
    search: GridSearch,
    way: Vec<(usize, u32)>,
    knots: Vec<Knot>,
}

impl AStar {
    /// Creates a planner with these settings.
    pub fn new(settings: &PlannerSettings) -> Self {
        Self {
            settings: settings.clone(),
            costs: Costs::default(),
            search: GridSearch::new(),
            way: Vec::new(),
            knots: Vec::new(),
        }
    }

    /// The cell of an end, or the reason that the robot cannot be there.
    fn end(&self, grid: &Grid, end: PathEnd, at: Point) -> Result<Cell, NoPath> {
        let outside = NoPath::Outside { end, at };
        let cell = grid.layout().cell(at).ok_or(outside)?;
        match self.blocked(grid, cell, end) {
            None => Ok(cell),
            Some(why) => Err(match end {
                PathEnd::Start => NoPath::StartOccupied { at, why },
                PathEnd::Goal => NoPath::GoalOccupied { at, why },
            }),
        }
    }

    fn blocked(&self, grid: &Grid, cell: Cell, end: PathEnd) -> Option<Blocked> {
        match (self.costs.at(self.costs.index(cell)), end) {
            (WALL, _) => {
                let occupied = grid.get(cell).map(Occupancy::of) == Some(Occupancy::Occupied);
                Some(if occupied {
                    Blocked::Occupied
                } else {
                    Blocked::Unknown
                })
            }
            (TIGHT, PathEnd::Goal) => Some(Blocked::Near {
                distance: self.costs.clearance(cell),
                inflation: self.settings.inflation_m,
            }),
            _ => None,
        }
    }

    /// Collects the points of the path: the requested ends, and the centres of the cells between them.
    fn collect_points(&mut self, grid: &Grid, start: Point, goal: Point) {
        let layout = grid.layout();
        let centres = self.way.iter().map(|(cell, cost)| Knot {
            point: layout.centre(self.costs.cell(*cell)),
            cell: *cell,
            cost: *cost,
        });
        self.knots.clear();
        self.knots.extend(centres);
        if let [only] = self.knots[..] {
            self.knots.push(only);
        }
        if let [first, .., last] = &mut self.knots[..] {
            first.point = start;
            last.point = goal;
        }
    }
}

impl Planner for AStar {
    fn plan(&mut self, grid: &Grid, start: &Pose, goal: &Pose) -> Result<PlannedPath, NoPath> {
        self.costs.update(grid, &self.settings);
        let (from, to) = (position(start), position(goal));
        let first = self.end(grid, PathEnd::Start, from)?;
        let last = self.end(grid, PathEnd::Goal, to)?;
        let (first, last) = (self.costs.index(first), self.costs.index(last));
        let found = self.search.run(&self.costs, first, last);
        let explored = found.explored;
        if !found.reached {
            return Err(NoPath::Unreachable { explored });
        }
        self.search.collect_path(&self.costs, last, &mut self.way);
        self.collect_points(grid, from, to);
        smooth(grid.layout(), &self.costs, &mut self.knots);
        let line = Polyline::new(self.knots.iter().map(|knot| knot.point));
        let mut poses = line.resampled(self.settings.step_m);
        if let Some(end) = poses.last_mut() {
            *end = heading(to, yaw(goal));
        }
        Ok(PlannedPath {
            poses,
            length: line.length(),
            explored,
        })
    }
}

fn position(pose: &Pose) -> Point {
    Point::from(pose.translation.vector)
}
