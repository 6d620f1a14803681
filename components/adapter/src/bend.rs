//! The bend: the cheapest way past the obstacles within a few lanes left and right of the planned path.
//!
//! Dynamic programming over stations × lanes (Viterbi), as in the lateral planners of road vehicles (Werling et al.,
//! 2010, *Optimal trajectory generation for dynamic street scenarios in a Frenét frame*; here without time). It is
//! exact on its lattice: if it finds no way, there is none within these limits.

use geometry::{Distances, Point};

use crate::route::Route;

/// What a way has to keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// m, between the way and an obstacle at least.
    pub clearance: f64,
    /// m, between the way and an obstacle if it costs little.
    pub comfort: f64,
    /// m, how far from the planned path the way may lead, left or right.
    pub reach: f64,
    /// m ahead of the robot, how far the way is looked at.
    pub horizon: f64,
}

/// Where no way leads past.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Barrier {
    /// The obstacle there, map frame.
    pub point: Point,
    /// m ahead of the robot along the path.
    pub ahead: f64,
}

/// What the robot must not touch.
#[derive(Debug, Clone, Copy)]
pub struct Obstacles<'a> {
    /// What the laser saw, map frame.
    pub seen: &'a [Point],
    /// What the map knows, if there is a map.
    pub mapped: Option<&'a Distances>,
}

/// m, from lane to lane.
const LANE: f64 = 0.05;

/// Lanes changed at most from one station to the next: so few that halfway between two free stations the clearance is
/// less by two or three centimetres at most.
const STEEP: usize = 4;

/// m of path a metre of offset, on which the robot returns to the planned path.
const RETURN: f64 = 3.0;

/// How often the corners of a way are rounded.
const ROUNDINGS: usize = 4;

/// The cost of a station one metre off the path.
const OFF: f64 = 0.3;

/// The cost of a station at bare clearance; none at comfort.
const TIGHT: f64 = 1.0;

/// The cost of one station driven at 45° to the path.
const SLOPE: f64 = 0.2;

/// The cost of a station one metre off the way that was taken so far.
const CHANGE: f64 = 0.3;

/// Where the robot already is too near to something, it gains at least this clearance a metre driven.
const ESCAPE: f64 = 0.3;

/// m, of clearance: the least difference that counts when a robot that is too near shall not come nearer.
const SLACK: f64 = 0.02;

impl Obstacles<'_> {
    /// m from `point` to the nearest thing the laser saw.
    pub fn from_seen(&self, point: Point) -> f64 {
        let squared = self.seen.iter().map(|seen| (seen - point).norm_squared());
        squared.fold(f64::INFINITY, f64::min).sqrt()
    }

    /// m from `point` to the nearest thing on the map; 0 outside of it, infinite without a map.
    fn from_mapped(&self, point: Point) -> f64 {
        self.mapped.map_or(f64::INFINITY, |map| {
            let cell = map.layout().cell(point);
            cell.and_then(|cell| map.metres(cell)).unwrap_or(0.0)
        })
    }

    /// The thing the laser saw nearest to `point`.
    fn nearest(&self, point: Point) -> Option<Point> {
        let squared = |seen: &Point| (seen - point).norm_squared();
        let seen = self.seen.iter().copied();
        seen.min_by(|a, b| squared(a).total_cmp(&squared(b)))
    }
}

/// A stretch of road in front of the robot.
#[derive(Debug, Clone, Copy)]
pub struct Window<'a> {
    /// The road.
    pub route: &'a Route,
    /// The last station not ahead of the robot: the robot is there, whatever stands near it.
    pub from: usize,
    /// Where the robot is.
    pub robot: Point,
    /// m, how far to the left of the planned path it is.
    pub offset: f64,
}

impl Window<'_> {
    /// How many stations lie within the horizon.
    pub fn len(&self, limits: &Limits) -> usize {
        let left = self.route.stations().len() - self.from;
        let step = self.route.step();
        let within = if step > 0.0 { limits.horizon / step } else { 0.0 };
        left.min(within as usize + 1)
    }

    /// Whether the way with these offsets at the route's stations keeps `spare` metres more than the clearance from
    /// everything the laser saw; also between stations, for a way that leaps to the other side of a wall is not free.
    pub fn is_free(
        &self,
        limits: &Limits,
        obstacles: &Obstacles<'_>,
        spare: f64,
        offset: impl Fn(usize) -> f64,
    ) -> bool {
        let here = obstacles.from_seen(self.robot);
        let point = |at: usize| self.route.point(self.from + at, offset(self.from + at));
        (1..self.len(limits)).all(|at| {
            let (from, to) = (point(at - 1), point(at));
            let pieces = ((to - from).norm() / LANE).ceil().max(1.0) as u32;
            let required = self.required(limits, here, at) + spare;
            // the first piece starts behind the robot
            let first = if at == 1 { pieces } else { 1 };
            (first..=pieces)
                .map(|piece| from + (to - from) * (f64::from(piece) / f64::from(pieces)))
                .all(|between| obstacles.from_seen(between) >= required)
        })
    }

    /// The way back to the planned path, for a robot beside it: smooth, and only if it is free with `spare` metres more.
    pub fn back(&self, limits: &Limits, obstacles: &Obstacles<'_>, spare: f64) -> Option<Vec<f64>> {
        let length = (RETURN * self.offset.abs()).max(1.0);
        let offset = |station: usize| {
            let share = (station - self.from) as f64 * self.route.step() / length;
            self.offset * smooth_step_down(share)
        };
        self.is_free(limits, obstacles, spare, offset)
            .then(|| (self.from..self.from + self.len(limits)).map(offset).collect())
    }

    /// The clearance asked for at a station: less where the robot starts out too near, and then growing.
    fn required(&self, limits: &Limits, here: f64, at: usize) -> f64 {
        let gained = at as f64 * self.route.step() * ESCAPE;
        limits.clearance.min(here - SLACK + gained)
    }
}

/// Finds bends; keeps its tables from one time to the next.
#[derive(Debug, Clone, Default)]
pub struct Bender {
    /// For the lanes of the present station: the cost of the cheapest way there.
    cost: Vec<f64>,
    next: Vec<f64>,
    /// For each station and lane: the lane before.
    before: Vec<u16>,
}

impl Bender {
    /// The cheapest way through the window: for each of its stations the offset to the left, m.
    pub fn bend(
        &mut self,
        window: &Window<'_>,
        limits: &Limits,
        obstacles: &Obstacles<'_>,
    ) -> Result<Vec<f64>, Barrier> {
        let lanes = Lanes::new(limits.reach);
        let stations = window.len(limits);
        let here = obstacles.from_seen(window.robot);
        self.start(&lanes, window.offset, stations);
        for at in 1..stations {
            self.advance(&lanes, window.route.step(), at);
            let required = window.required(limits, here, at);
            if !self.charge(&lanes, window, limits, obstacles, at, required) {
                let middle = window.route.stations()[window.from + at].point;
                return Err(Barrier {
                    point: obstacles.nearest(middle).unwrap_or(middle),
                    ahead: (window.robot - middle).norm(),
                });
            }
        }
        let mut offsets = self.trace(&lanes, stations);
        for _ in 0..ROUNDINGS {
            round(&mut offsets, window, limits, obstacles);
        }
        Ok(offsets)
    }

    /// All ways start at the robot's own lane.
    fn start(&mut self, lanes: &Lanes, offset: f64, stations: usize) {
        self.cost.clear();
        self.cost.resize(lanes.count, f64::INFINITY);
        self.next.clear();
        self.next.resize(lanes.count, f64::INFINITY);
        self.before.clear();
        self.before.resize(lanes.count * stations, 0);
        self.cost[lanes.nearest(offset)] = 0.0;
    }

    /// From each lane to the lanes nearby, one station on.
    fn advance(&mut self, lanes: &Lanes, step: f64, at: usize) {
        self.next.fill(f64::INFINITY);
        let before = &mut self.before[at * lanes.count..];
        for (lane, cost) in self.cost.iter().enumerate() {
            if !cost.is_finite() {
                continue;
            }
            for to in lane.saturating_sub(STEEP)..(lane + STEEP + 1).min(lanes.count) {
                let slope = lanes.offset(to.abs_diff(lane) + lanes.middle) / step;
                let total = cost + SLOPE * slope * slope;
                if total < self.next[to] {
                    self.next[to] = total;
                    before[to] = lane as u16;
                }
            }
        }
        std::mem::swap(&mut self.cost, &mut self.next);
    }

    /// Adds what it costs to be at a station, and closes the lanes that are not free. Says whether one is left.
    fn charge(
        &mut self,
        lanes: &Lanes,
        window: &Window<'_>,
        limits: &Limits,
        obstacles: &Obstacles<'_>,
        at: usize,
        required: f64,
    ) -> bool {
        let station = window.from + at;
        let taken = window.route.offsets()[station];
        let is_goal = station + 1 == window.route.stations().len();
        // where the planned path itself is nearer to a wall on the map, that is near enough
        let on_map = obstacles.from_mapped(window.route.point(station, 0.0)).min(limits.clearance);
        let mut open = false;
        for (lane, cost) in self.cost.iter_mut().enumerate().filter(|(_, cost)| cost.is_finite()) {
            let offset = lanes.offset(lane);
            let point = window.route.point(station, offset);
            let (seen, mapped) = (obstacles.from_seen(point), obstacles.from_mapped(point));
            if seen < required || mapped < on_map || (is_goal && lane != lanes.middle) {
                *cost = f64::INFINITY;
                continue;
            }
            let spare = (limits.comfort - limits.clearance).max(1e-6);
            let tight = ((limits.comfort - seen.min(mapped)) / spare).clamp(0.0, 1.0);
            let change = if taken == 0.0 { 0.0 } else { offset - taken };
            *cost += OFF * offset * offset + TIGHT * tight * tight + CHANGE * change * change;
            open = true;
        }
        open
    }

    /// The cheapest way, back from its end.
    fn trace(&self, lanes: &Lanes, stations: usize) -> Vec<f64> {
        let ends = self.cost.iter().enumerate();
        let end = ends.min_by(|(_, a), (_, b)| a.total_cmp(b));
        let mut lane = end.map_or(lanes.middle, |(lane, _)| lane);
        let mut offsets = vec![0.0; stations];
        for at in (0..stations).rev() {
            offsets[at] = lanes.offset(lane);
            lane = usize::from(self.before[at * lanes.count + lane]);
        }
        offsets
    }
}

/// From 1 at 0 to 0 at 1, level at both ends.
fn smooth_step_down(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    1.0 - share * share * (3.0 - 2.0 * share)
}

/// Rounds the corners that the lattice left, where that does not lead below the clearance.
fn round(offsets: &mut [f64], window: &Window<'_>, limits: &Limits, obstacles: &Obstacles<'_>) {
    for at in 1..offsets.len().saturating_sub(1) {
        let rounded = (offsets[at - 1] + 2.0 * offsets[at] + offsets[at + 1]) / 4.0;
        let clearance = |offset| obstacles.from_seen(window.route.point(window.from + at, offset));
        let enough = clearance(offsets[at]).min(limits.comfort);
        if rounded != offsets[at] && clearance(rounded) >= enough {
            offsets[at] = rounded;
        }
    }
}

/// The lanes: parallel to the path, the middle one on it.
struct Lanes {
    count: usize,
    middle: usize,
}

impl Lanes {
    fn new(reach: f64) -> Self {
        // a lattice of more than a thousand lanes is no local detour
        let middle = (reach / LANE).clamp(1.0, 512.0) as usize;
        Self {
            count: 2 * middle + 1,
            middle,
        }
    }

    /// m to the left of the path.
    fn offset(&self, lane: usize) -> f64 {
        (lane as f64 - self.middle as f64) * LANE
    }

    fn nearest(&self, offset: f64) -> usize {
        let lane = offset / LANE + self.middle as f64;
        lane.round().clamp(0.0, (self.count - 1) as f64) as usize
    }
}
