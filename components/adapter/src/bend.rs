//! The bend: the cheapest path around obstacles, within a few lanes left and right of the planned path.
//!
//! Dynamic programming over stations × lanes (Viterbi), as in the lateral planners of road vehicles (Werling et al.,
//! 2010, *Optimal trajectory generation for dynamic street scenarios in a Frenét frame*; here without time). The result
//! is optimal on the lattice: if no path is found, there is none within the limits.

use asmotion_geometry::{Distances, Point};

use crate::bend_limits::BendLimits;
use crate::route::BendableRoute;

/// A place that no detour passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Barrier {
    /// The obstacle there, map frame.
    pub point: Point,
    /// Straight distance from the robot to this place on the path, m.
    pub ahead: f64,
}

/// Obstacles near the path, for distance queries.
#[derive(Debug, Clone, Copy)]
pub struct BendObstacles<'a> {
    /// Points seen by the laser, map frame, ordered by x.
    scanned: &'a [Point],
    /// Distances to the map's obstacles, if there is a map.
    mapped: Option<&'a Distances>,
    /// Distance in m beyond which obstacles are ignored.
    within: f64,
}

/// Distance between adjacent lanes, m.
const LANE: f64 = 0.05;

/// Limit on the lane changes between two stations. Keeps the loss of clearance halfway between two free stations below
/// three centimetres.
const STEEP: usize = 4;

/// Length in m of the return to the planned path per metre of offset.
const RETURN: f64 = 3.0;

/// Number of passes that round the corners of a detour.
const ROUNDINGS: usize = 4;

/// Cost of a station per metre of distance from the planned path.
const OFF: f64 = 0.3;

/// Cost of a station at minimum clearance; falls to zero at the comfort distance.
const TIGHT: f64 = 1.0;

/// Cost of a station at which the path is at 45° to the planned one.
const SLOPE: f64 = 0.2;

/// Cost of a station per metre of distance from the previous bend.
const CHANGE: f64 = 0.3;

/// Minimum growth of the clearance, per metre driven, for a robot that is too near to an obstacle.
const ESCAPE: f64 = 0.3;

/// Distance in m beyond the comfort distance at which obstacles are ignored.
const FARTHER: f64 = 0.1;

/// Tolerance in m for a robot that is too near to an obstacle and must not come nearer.
const SLACK: f64 = 0.02;

impl<'a> BendObstacles<'a> {
    /// Creates the obstacles for queries within these limits from points seen by the laser, which are sorted here, and
    /// those of the map.
    pub fn new(
        scanned: &'a mut [Point],
        mapped: Option<&'a Distances>,
        limits: &BendLimits,
    ) -> Self {
        scanned.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        Self {
            scanned,
            mapped,
            within: limits.comfort().max(limits.clearance()) + FARTHER,
        }
    }

    /// Distance in m from `point` to the nearest point seen by the laser; infinite beyond `within`.
    fn scanned_distance(&self, point: Point) -> f64 {
        let first = self
            .scanned
            .partition_point(|seen| seen.x < point.x - self.within);
        let nearby = self.scanned[first..].iter();
        nearby
            .take_while(|seen| seen.x <= point.x + self.within)
            .map(|seen| (seen - point).norm_squared())
            .fold(f64::INFINITY, f64::min)
            .sqrt()
    }

    /// Distance in m from `point` to the nearest obstacle of the map; 0 outside the map, infinite without one.
    fn mapped_distance(&self, point: Point) -> f64 {
        self.mapped.map_or(f64::INFINITY, |map| {
            let cell = map.layout().cell(point);
            let to_middle = cell.and_then(|cell| map.metres(cell)).unwrap_or(0.0);
            (to_middle - map.layout().resolution() / 2.0).max(0.0)
        })
    }

    /// Distances in m from a robot at `point` to obstacles.
    fn clearance(&self, point: Point) -> Clearance {
        Clearance {
            scanned: self.scanned_distance(point),
            mapped: self.mapped_distance(point),
        }
    }

    /// The point seen by the laser that is nearest to `point`.
    fn nearest(&self, point: Point) -> Option<Point> {
        let squared = |seen: &Point| (seen - point).norm_squared();
        let seen = self.scanned.iter().copied();
        seen.min_by(|a, b| squared(a).total_cmp(&squared(b)))
    }
}

/// Distances in m to the nearest point seen by the laser and to the nearest obstacle of the map. The planner knows the
/// map: where its path is nearer to the map's obstacles than the clearance, the path's own distance is required
/// instead.
#[derive(Debug, Clone, Copy)]
struct Clearance {
    scanned: f64,
    mapped: f64,
}

impl Clearance {
    /// Returns whether both distances are at least `needed` plus `spare` metres. A positive `spare` does not apply to
    /// the map's obstacles, which the planner has taken into account.
    fn suffices(&self, needed: &Self, spare: f64) -> bool {
        self.scanned >= needed.scanned + spare && self.mapped >= needed.mapped + spare.min(0.0)
    }

    fn nearest(&self) -> f64 {
        self.scanned.min(self.mapped)
    }
}

/// The part of the path ahead of the robot.
#[derive(Debug, Clone, Copy)]
pub struct Window<'a> {
    /// Path of which this is a part, with its present offsets.
    pub route: &'a BendableRoute,
    /// Index of the last station not ahead of the robot. The robot is there already, so it is not checked.
    pub from: usize,
    /// Position of the robot, map frame, m.
    pub robot: Point,
    /// Distance of the robot to the left of the planned path, m.
    pub offset: f64,
}

impl Window<'_> {
    /// Number of stations within the horizon.
    pub fn len(&self, limits: &BendLimits) -> usize {
        self.route.within(self.from, limits.horizon_m)
    }

    /// Returns whether the path with these offsets at the stations keeps `spare` metres more than the clearance. Checks
    /// between stations too, because a path could jump across a wall there.
    pub fn is_free(
        &self,
        limits: &BendLimits,
        obstacles: &BendObstacles<'_>,
        spare: f64,
        offset: impl Fn(usize) -> f64,
    ) -> bool {
        let clearance = obstacles.clearance(self.robot);
        let point = |at: usize| self.route.point(self.from + at, offset(self.from + at));
        (1..self.len(limits)).all(|at| {
            let (from, to) = (point(at - 1), point(at));
            let pieces = ((to - from).norm() / LANE).ceil().max(1.0) as u32;
            let needed = self.needed(limits, obstacles, &clearance, at);
            // the first piece begins behind the robot
            let first = if at == 1 { pieces } else { 1 };
            (first..=pieces)
                .map(|piece| from + (to - from) * (f64::from(piece) / f64::from(pieces)))
                .all(|between| obstacles.clearance(between).suffices(&needed, spare))
        })
    }

    /// A smooth return to the planned path for a robot beside it, if the return is free with `spare` metres more than
    /// the clearance.
    pub fn back(
        &self,
        limits: &BendLimits,
        obstacles: &BendObstacles<'_>,
        spare: f64,
    ) -> Option<Vec<f64>> {
        let length = (RETURN * self.offset.abs()).max(1.0);
        let offset = |station: usize| {
            let share = (station - self.from) as f64 * self.route.step() / length;
            self.offset * smooth_step_down(share)
        };
        self.is_free(limits, obstacles, spare, offset).then(|| {
            (self.from..self.from + self.len(limits))
                .map(offset)
                .collect()
        })
    }

    /// Distances required at a station: reduced near the robot if it is too near to an obstacle, then growing.
    fn needed(
        &self,
        limits: &BendLimits,
        obstacles: &BendObstacles<'_>,
        here: &Clearance,
        at: usize,
    ) -> Clearance {
        let gained = at as f64 * self.route.step() * ESCAPE - SLACK;
        let planned = self.route.point(self.from + at, 0.0);
        let mapped = obstacles.mapped_distance(planned).min(here.mapped + gained);
        Clearance {
            scanned: limits.clearance().min(here.scanned + gained),
            mapped: limits.clearance().min(mapped),
        }
    }
}

/// Computes bends; keeps its tables to reuse the allocation.
#[derive(Debug, Clone, Default)]
pub struct Bender {
    /// Cost of the cheapest path to each lane of the current station.
    cost: Vec<f64>,
    next: Vec<f64>,
    /// The preceding lane, for each station and lane.
    predecessors: Vec<u16>,
}

impl Bender {
    /// Finds the cheapest path through the window. Returns the offset to the left at each station, m.
    pub fn bend(
        &mut self,
        window: &Window<'_>,
        limits: &BendLimits,
        obstacles: &BendObstacles<'_>,
    ) -> Result<Vec<f64>, Barrier> {
        let lanes = Lanes::new(limits.reach_m);
        let stations = window.len(limits);
        let here = obstacles.clearance(window.robot);
        self.initialise(&lanes, window.offset, stations);
        for at in 1..stations {
            self.advance(&lanes, window.route.step(), at);
            let needed = window.needed(limits, obstacles, &here, at);
            if !self.add_obstacle_costs(&lanes, window, limits, obstacles, at, &needed) {
                let middle = window.route.stations()[window.from + at].point;
                return Err(Barrier {
                    point: obstacles.nearest(middle).unwrap_or(middle),
                    ahead: (window.robot - middle).norm(),
                });
            }
        }
        let mut offsets = self.back_trace(&lanes, stations);
        for _ in 0..ROUNDINGS {
            smooth(&mut offsets, window, limits, obstacles);
        }
        Ok(offsets)
    }

    /// Resets the tables; all paths start at the robot's own lane.
    fn initialise(&mut self, lanes: &Lanes, offset: f64, stations: usize) {
        self.cost.clear();
        self.cost.resize(lanes.count, f64::INFINITY);
        self.next.clear();
        self.next.resize(lanes.count, f64::INFINITY);
        self.predecessors.clear();
        self.predecessors.resize(lanes.count * stations, 0);
        self.cost[lanes.nearest(offset)] = 0.0;
    }

    /// Extends the paths from each lane to the reachable lanes of the next station.
    fn advance(&mut self, lanes: &Lanes, step: f64, at: usize) {
        self.next.fill(f64::INFINITY);
        let before = &mut self.predecessors[at * lanes.count..][..lanes.count];
        let reachable = self
            .cost
            .iter()
            .enumerate()
            .filter(|(_, cost)| cost.is_finite());
        for (lane, cost) in reachable {
            let first = lane.saturating_sub(STEEP);
            let nearby = self.next.iter_mut().zip(before.iter_mut()).enumerate();
            for (to, (best, from)) in nearby.take(lane + STEEP + 1).skip(first) {
                let slope = to.abs_diff(lane) as f64 * LANE / step;
                let total = cost + SLOPE * slope * slope;
                if total < *best {
                    *best = total;
                    *from = lane as u16;
                }
            }
        }
        std::mem::swap(&mut self.cost, &mut self.next);
    }

    /// Adds the cost of each lane at a station, and closes the lanes that are not free. Returns whether one is left.
    fn add_obstacle_costs(
        &mut self,
        lanes: &Lanes,
        window: &Window<'_>,
        limits: &BendLimits,
        obstacles: &BendObstacles<'_>,
        at: usize,
        needed: &Clearance,
    ) -> bool {
        let station = window.from + at;
        let taken = window.route.offsets()[station];
        let is_goal = station + 1 == window.route.stations().len();
        let mut open = false;
        let reachable = self
            .cost
            .iter_mut()
            .enumerate()
            .filter(|(_, cost)| cost.is_finite());
        for (lane, cost) in reachable {
            let offset = lanes.offset(lane);
            let room = obstacles.clearance(window.route.point(station, offset));
            if !room.suffices(needed, 0.0) || (is_goal && lane != lanes.middle) {
                *cost = f64::INFINITY;
                continue;
            }
            let spare = (limits.comfort() - limits.clearance()).max(1e-6);
            let tight = ((limits.comfort() - room.nearest()) / spare).clamp(0.0, 1.0);
            let change = if taken == 0.0 { 0.0 } else { offset - taken };
            *cost += OFF * offset * offset + TIGHT * tight * tight + CHANGE * change * change;
            open = true;
        }
        open
    }

    /// Reconstructs the cheapest path from its end.
    fn back_trace(&self, lanes: &Lanes, stations: usize) -> Vec<f64> {
        let ends = self.cost.iter().enumerate();
        let end = ends.min_by(|(_, a), (_, b)| a.total_cmp(b));
        let mut lane = end.map_or(lanes.middle, |(lane, _)| lane);
        let mut offsets = vec![0.0; stations];
        for at in (0..stations).rev() {
            offsets[at] = lanes.offset(lane);
            lane = usize::from(self.predecessors[at * lanes.count + lane]);
        }
        offsets
    }
}

/// A smooth step from 1 at 0 to 0 at 1, with zero slope at both ends.
fn smooth_step_down(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    1.0 - share * share * (3.0 - 2.0 * share)
}

/// Rounds the corners of a lattice path where this keeps the clearance.
fn smooth(
    offsets: &mut [f64],
    window: &Window<'_>,
    limits: &BendLimits,
    obstacles: &BendObstacles<'_>,
) {
    for at in 1..offsets.len().saturating_sub(1) {
        let rounded = (offsets[at - 1] + 2.0 * offsets[at] + offsets[at + 1]) / 4.0;
        let nearest = |offset| {
            obstacles
                .clearance(window.route.point(window.from + at, offset))
                .nearest()
        };
        let enough = nearest(offsets[at]).min(limits.comfort());
        if rounded != offsets[at] && nearest(rounded) >= enough {
            offsets[at] = rounded;
        }
    }
}

/// The lanes, parallel to the planned path; the middle one is on it.
struct Lanes {
    count: usize,
    middle: usize,
}

impl Lanes {
    fn new(reach: f64) -> Self {
        // limits the number of lanes to 1025
        let middle = (reach / LANE).clamp(1.0, 512.0) as usize;
        Self {
            count: 2 * middle + 1,
            middle,
        }
    }

    /// Offset of a lane to the left of the planned path, m.
    fn offset(&self, lane: usize) -> f64 {
        (lane as f64 - self.middle as f64) * LANE
    }

    fn nearest(&self, offset: f64) -> usize {
        let lane = offset / LANE + self.middle as f64;
        lane.round().clamp(0.0, (self.count - 1) as f64) as usize
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use asmotion_messages::{Path, Pose};
    use proptest::prelude::*;

    pub const LIMITS: BendLimits = BendLimits {
        robot_radius_m: 0.2,
        margin_m: 0.05,
        comfort_m: 0.2,
        reach_m: 1.0,
        horizon_m: 4.0,
    };

    fn road() -> BendableRoute {
        let ends = [Pose::planar(0.0, 0.0, 0.0), Pose::planar(6.0, 0.0, 0.0)];
        BendableRoute::new(Path::from_poses(1, "map", ends)).unwrap()
    }

    fn window(route: &BendableRoute) -> Window<'_> {
        Window {
            route,
            from: 0,
            robot: Point::origin(),
            offset: 0.0,
        }
    }

    fn bend(seen: &[Point]) -> Result<Vec<f64>, Barrier> {
        let mut seen = seen.to_vec();
        let obstacles = BendObstacles::new(&mut seen, None, &LIMITS);
        Bender::default().bend(&window(&road()), &LIMITS, &obstacles)
    }

    /// Points on a line across the road, with gaps narrower than the robot.
    fn across(x: f64, from: f64, to: f64) -> Vec<Point> {
        let count = ((to - from) / 0.1).round() as u32;
        (0..=count)
            .map(|step| Point::new(x, from + 0.1 * f64::from(step)))
            .collect()
    }

    #[test]
    fn a_free_road_stays_as_it_is() {
        assert!(bend(&[]).unwrap().iter().all(|offset| *offset == 0.0));
        assert!(
            bend(&[Point::new(2.0, 0.9)])
                .unwrap()
                .iter()
                .all(|offset| *offset == 0.0)
        );
    }

    #[test]
    fn it_passes_on_the_side_where_there_is_more_room() {
        for side in [1.0, -1.0] {
            let offsets = bend(&[Point::new(2.0, 0.1 * side)]).unwrap();
            assert!(offsets[20] * side < -0.1, "{offsets:?}");
            assert!(offsets[40].abs() < 0.11, "it comes back");
        }
    }

    #[test]
    fn it_says_where_there_is_no_way() {
        let barrier = bend(&across(2.0, -1.2, 1.2)).unwrap_err();
        assert!((barrier.point - Point::new(2.0, 0.0)).norm() < 0.1);
        assert!((barrier.ahead - 1.8).abs() < 0.11);
        // a gap of 0.5 m suffices for a robot that needs 0.25 m on each side; a narrower one does not
        let gap = |width: f64| {
            [
                across(2.0, -1.2, -width / 2.0),
                across(2.0, width / 2.0, 1.2),
            ]
            .concat()
        };
        assert!(bend(&gap(0.52)).is_ok());
        assert!(bend(&gap(0.46)).is_err());
    }

    #[test]
    fn it_does_not_leap_through_a_wall_along_the_road() {
        // the road is closed to the right of a long wall and open to its left; the robot is on the right
        let along: Vec<Point> = (0..=35)
            .map(|step| Point::new(f64::from(step) * 0.1, 0.35))
            .collect();
        let seen = [along, across(2.5, -1.2, 0.35)].concat();
        assert!(bend(&seen).is_err());
    }

    #[test]
    fn the_goal_is_not_moved() {
        let route = road();
        let mut seen = [Point::new(6.0, 0.1)];
        let near_goal = Window {
            from: 40,
            robot: Point::new(4.0, 0.0),
            ..window(&route)
        };
        let obstacles = BendObstacles::new(&mut seen, None, &LIMITS);
        assert!(
            Bender::default()
                .bend(&near_goal, &LIMITS, &obstacles)
                .is_err()
        );
    }

    #[test]
    fn a_robot_that_stands_too_near_to_something_gets_away() {
        let route = road();
        let mut seen = [Point::new(0.22, 0.0)];
        let obstacles = BendObstacles::new(&mut seen, None, &LIMITS);
        let offsets = Bender::default()
            .bend(&window(&route), &LIMITS, &obstacles)
            .unwrap();
        assert!(offsets[2].abs() >= 0.2, "{offsets:?}");
    }

    #[test]
    fn it_keeps_away_from_what_the_map_knows_but_follows_the_planner() {
        let layout = asmotion_geometry::GridLayout::new(
            0.05,
            140,
            40,
            asmotion_geometry::heading(Point::new(-0.5, -1.0), 0.0),
        )
        .unwrap();
        let mut grid = asmotion_geometry::Grid::new(layout, asmotion_geometry::FREE);
        grid.stroke(
            &[Point::new(-0.4, -0.2), Point::new(6.4, -0.2)],
            0.0,
            asmotion_geometry::OCCUPIED,
        );
        let map = Distances::to_occupied(&grid);
        let route = road();
        let pass = |seen: &[Point]| {
            let mut seen = seen.to_vec();
            let obstacles = BendObstacles::new(&mut seen, Some(&map), &LIMITS);
            Bender::default().bend(&window(&route), &LIMITS, &obstacles)
        };
        // the planner itself went within 0.2 m of the wall, so this is accepted
        assert!(pass(&[]).is_ok());
        let offsets = pass(&[Point::new(2.0, 0.1)]).unwrap();
        assert!(
            offsets[20] > 0.3,
            "not between the thing and the wall: {offsets:?}"
        );
        assert!(offsets.iter().all(|offset| *offset > -0.1));
    }

    proptest! {
        #[test]
        fn a_way_that_is_found_is_free(things in prop::collection::vec((0.8..5.0, -1.2..1.2), 1..12)) {
            let mut seen: Vec<Point> = things.iter().map(|(x, y)| Point::new(*x, *y)).collect();
            let obstacles = BendObstacles::new(&mut seen, None, &LIMITS);
            let route = road();
            let window = window(&route);
            if let Ok(offsets) = Bender::default().bend(&window, &LIMITS, &obstacles) {
                // between stations the clearance is slightly less; see `STEEP`
                prop_assert!(window.is_free(&LIMITS, &obstacles, -0.04, |station| offsets[station]));
            }
        }

        #[test]
        fn the_way_back_is_free_and_ends_on_the_path(offset in -1.0..1.0, things in prop::collection::vec((0.8..5.0, -1.2..1.2), 0..6)) {
            let mut seen: Vec<Point> = things.iter().map(|(x, y)| Point::new(*x, *y)).collect();
            let obstacles = BendObstacles::new(&mut seen, None, &LIMITS);
            let route = road();
            let aside = Window { robot: Point::new(0.0, offset), offset, ..window(&route) };
            if let Some(back) = aside.back(&LIMITS, &obstacles, 0.0) {
                prop_assert!((back[0] - offset).abs() < 1e-12 && back[40] == 0.0);
                prop_assert!(aside.is_free(&LIMITS, &obstacles, -1e-9, |station| back[station]));
            }
        }
    }
}
