//! The decision about obstacles: keep the path, bend it, hold, or give up.

use std::time::Duration;

use asmotion_component::{Properties, Time};
use asmotion_geometry::{Distances, Point, Pose};
use asmotion_messages::Path;
use serde::{Deserialize, Serialize};

use crate::bend::{Barrier, BendObstacles, Bender, Window};
use crate::bend_limits::BendLimits;
use crate::route::BendableRoute;

/// Limits for holding before an obstacle, and for reporting the path as blocked.
#[derive(Debug, Clone, Copy, PartialEq, Properties)]
pub struct Patience {
    /// Distance to a barrier below which the robot stops at the first look.
    #[property(unit = "m", range = 0.0..=50.0, default = 1.0)]
    pub hold_m: f64,
    /// Time without progress on a free path after which the path counts as blocked.
    #[property(range = "500ms"..="3600s", default = "10s")]
    pub stuck_s: Duration,
    /// Consecutive looks that must find no way before the path counts as blocked.
    #[property(range = 1..=100, default = 3)]
    pub looks: u32,
}

/// The reason that a path counts as blocked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BlockedCause {
    /// There is no way past this barrier.
    Barrier(Barrier),
    /// The way looks free, but the robot does not get beyond this point (map frame, m).
    Stuck(Point),
}

/// Result of a look; usually empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Advice {
    /// The path to follow from now on, if it has changed; a path without poses is an order to stop.
    pub path: Option<Path>,
    /// Set once for each blocked path.
    pub blocked: Option<BlockedCause>,
}

/// The last order to the follower.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum LastAdvice {
    /// No order for this path yet.
    Nothing,
    /// The path as it was planned.
    Planned,
    /// The bent path.
    Bent,
    /// To stop temporarily.
    Hold,
    /// To stop for good: the path is blocked.
    Blocked,
}

/// State of the decision: the path, its bend, and the last order to the follower.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adviser {
    route: Option<BendableRoute>,
    last_advice: LastAdvice,
    fruitless: u32,
    /// `true` while the path leads back from a bend that is no longer needed.
    returns: bool,
    /// Progress along the path in m, and the time at which it was made.
    milestone: Option<(f64, Time)>,
    #[serde(skip)]
    bender: Bender,
    /// Remembered points near the robot; kept to reuse the allocation.
    #[serde(skip)]
    near: Vec<Point>,
}

/// Hysteresis in m: the path being driven may be this much nearer to an obstacle than a new one, so that noise does not
/// cause a bend.
const DRIVEN: f64 = 0.04;

/// Hysteresis in m: the planned path must be this much freer than required before the robot returns to it.
const FREED: f64 = 0.03;

/// Distance along the path in m that counts as progress.
const MILESTONE: f64 = 0.1;

/// Distance to the end of the path in m within which a robot at rest is not stuck.
const ALMOST_THERE: f64 = 0.3;

impl Default for Adviser {
    fn default() -> Self {
        Self {
            route: None,
            last_advice: LastAdvice::Nothing,
            fruitless: 0,
            returns: false,
            milestone: None,
            bender: Bender::default(),
            near: Vec::new(),
        }
    }
}

impl Adviser {
    /// Accepts a new path. The advice passes an empty path on.
    pub fn set_path(&mut self, path: &Path) -> Advice {
        self.route = BendableRoute::new(path.clone());
        self.last_advice = LastAdvice::Nothing;
        self.fruitless = 0;
        self.returns = false;
        self.milestone = None;
        Advice {
            path: self.route.is_none().then(|| empty(path)),
            blocked: None,
        }
    }

    /// Returns whether there is a path that is not blocked.
    pub fn is_busy(&self) -> bool {
        self.route.is_some() && self.last_advice != LastAdvice::Blocked
    }

    /// Decides without a scan: passes a path on as planned if there never was a scan, and stops if the laser has
    /// failed.
    pub fn advise_without_scan(&mut self, has_scanned: bool) -> Advice {
        let Some(route) = &self.route else {
            return Advice::default();
        };
        match self.last_advice {
            LastAdvice::Nothing | LastAdvice::Planned | LastAdvice::Bent if has_scanned => {
                self.last_advice = LastAdvice::Hold;
                advise_path(empty(route.planned()))
            }
            LastAdvice::Nothing => {
                self.last_advice = LastAdvice::Planned;
                advise_path(route.planned().clone())
            }
            LastAdvice::Planned | LastAdvice::Bent | LastAdvice::Hold | LastAdvice::Blocked => {
                Advice::default()
            }
        }
    }

    /// Restarts the measurement of progress, because the robot is not permitted to drive.
    pub fn reset_progress(&mut self) {
        self.milestone = None;
    }

    /// Checks the path ahead of the robot.
    pub fn advise(
        &mut self,
        now: Time,
        robot: &Pose,
        seen: impl Iterator<Item = Point>,
        map: Option<&Distances>,
        limits: &BendLimits,
        patience: &Patience,
    ) -> Advice {
        if !self.is_busy() {
            return Advice::default();
        }
        let Some(route) = &mut self.route else {
            return Advice::default();
        };
        let (from, offset) = route.locate(robot);
        let place = Point::from(robot.translation.vector);
        if self.is_stuck(now, patience) {
            return self.block(BlockedCause::Stuck(place));
        }
        let Some(route) = &self.route else {
            return Advice::default();
        };
        self.near.clear();
        let around = route.around(from, limits);
        self.near.extend(seen.filter(|point| around(point)));
        let obstacles = BendObstacles::new(&mut self.near, map, limits);
        let window = Window {
            route,
            from,
            robot: place,
            offset,
        };
        let driven = window.is_free(limits, &obstacles, -DRIVEN, |station| {
            route.offsets()[station]
        });
        if driven && (self.returns || !route.is_bent(from)) {
            self.fruitless = 0;
            return self.resume();
        }
        if let Some(back) = window.back(limits, &obstacles, FREED) {
            self.fruitless = 0;
            self.returns = true;
            return self.apply_offsets(from, &back);
        }
        if driven {
            self.fruitless = 0;
            return self.resume();
        }
        self.returns = false;
        match self.bender.bend(&window, limits, &obstacles) {
            Ok(offsets) => {
                self.fruitless = 0;
                self.apply_offsets(from, &offsets)
            }
            Err(barrier) => {
                self.fruitless += 1;
                self.handle_barrier(barrier, patience)
            }
        }
    }

    /// Called if the way is free: sends the path if the follower has no order or holds.
    fn resume(&mut self) -> Advice {
        match (&self.route, self.last_advice) {
            (Some(route), LastAdvice::Nothing | LastAdvice::Hold) => {
                let (last_advice, path) = if route.is_bent(0) {
                    (LastAdvice::Bent, route.bent())
                } else {
                    (LastAdvice::Planned, route.planned().clone())
                };
                self.last_advice = last_advice;
                advise_path(path)
            }
            (Some(_), LastAdvice::Planned | LastAdvice::Bent | LastAdvice::Blocked) | (None, _) => {
                Advice::default()
            }
        }
    }

    /// Called if there is a detour: sends it if it differs from the previous one.
    fn apply_offsets(&mut self, from: usize, offsets: &[f64]) -> Advice {
        let Some(route) = &mut self.route else {
            return Advice::default();
        };
        let before: Vec<f64> = route.offsets().to_vec();
        route.bend(from, offsets);
        if before != route.offsets() && self.last_advice != LastAdvice::Nothing {
            self.last_advice = LastAdvice::Hold; // the new order must be sent even if the follower has one
        }
        self.resume()
    }

    /// Called if there is no detour: holds before a near barrier, and gives up after `looks` attempts.
    fn handle_barrier(&mut self, barrier: Barrier, patience: &Patience) -> Advice {
        let Some(route) = &self.route else {
            return Advice::default();
        };
        let stop = empty(route.planned());
        if self.fruitless >= patience.looks {
            return self.block(BlockedCause::Barrier(barrier));
        }
        if barrier.ahead <= patience.hold_m && self.last_advice != LastAdvice::Hold {
            self.last_advice = LastAdvice::Hold;
            return advise_path(stop);
        }
        Advice::default()
    }

    /// Returns whether the robot has an order to drive and makes no progress.
    fn is_stuck(&mut self, now: Time, patience: &Patience) -> bool {
        let along = self
            .route
            .as_ref()
            .and_then(BendableRoute::progress)
            .unwrap_or(0.0);
        let left = self.route.as_ref().map_or(0.0, BendableRoute::length) - along;
        let drives = matches!(self.last_advice, LastAdvice::Planned | LastAdvice::Bent)
            && left > ALMOST_THERE;
        match self.milestone {
            Some((reached, since)) if drives && (along - reached).abs() < MILESTONE => {
                now.since(since) >= patience.stuck_s
            }
            _ => {
                self.milestone = Some((along, now));
                false
            }
        }
    }

    /// Stops the robot until the next path, and gives the reason.
    fn block(&mut self, cause: BlockedCause) -> Advice {
        let stop = self.route.as_ref().map(|route| empty(route.planned()));
        let stands = self.last_advice == LastAdvice::Hold;
        self.last_advice = LastAdvice::Blocked;
        Advice {
            path: stop.filter(|_| !stands),
            blocked: Some(cause),
        }
    }

    /// The current path; `None` before the first one.
    pub fn route(&self) -> Option<&BendableRoute> {
        self.route.as_ref()
    }
}

fn advise_path(path: Path) -> Advice {
    Advice {
        path: Some(path),
        blocked: None,
    }
}

/// The order to stop, with the header of the path that it replaces.
fn empty(path: &Path) -> Path {
    Path {
        header: path.header.clone(),
        poses: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bend::tests::LIMITS;
    use asmotion_geometry::heading;
    use asmotion_messages::Pose as PoseMessage;

    const PATIENCE: Patience = Patience {
        hold_m: 1.0,
        stuck_s: Duration::from_nanos(100),
        looks: 3,
    };

    fn path() -> Path {
        let ends = [
            PoseMessage::planar(0.0, 0.0, 0.0),
            PoseMessage::planar(8.0, 0.0, 0.0),
        ];
        Path::from_poses(5, "map", ends)
    }

    fn ordered() -> Adviser {
        let mut adviser = Adviser::default();
        assert_eq!(
            adviser.set_path(&path()),
            Advice::default(),
            "it looks first"
        );
        adviser
    }

    fn look(adviser: &mut Adviser, x: f64, seen: &[Point]) -> Advice {
        adviser.advise(
            Time::ZERO,
            &heading(Point::new(x, 0.0), 0.0),
            seen.iter().copied(),
            None,
            &LIMITS,
            &PATIENCE,
        )
    }

    fn wall(x: f64) -> Vec<Point> {
        (-15..=15)
            .map(|step| Point::new(x, f64::from(step) * 0.1))
            .collect()
    }

    fn is_stop(advice: &Advice) -> bool {
        advice
            .path
            .as_ref()
            .is_some_and(|path| path.poses.is_empty() && path.header.stamp.nanosec == 5)
    }

    #[test]
    fn where_nothing_is_in_the_way_the_path_is_passed_on_as_it_is_and_once() {
        let mut adviser = ordered();
        assert_eq!(
            look(&mut adviser, 0.0, &[Point::new(2.0, 0.6)]).path,
            Some(path())
        );
        assert_eq!(look(&mut adviser, 1.0, &[]), Advice::default());
    }

    #[test]
    fn a_stop_is_passed_on_at_once() {
        let mut adviser = ordered();
        let stop = Path::stop(9, "map");
        assert_eq!(adviser.set_path(&stop).path, Some(stop));
        assert!(!adviser.is_busy());
        assert_eq!(look(&mut adviser, 0.0, &wall(0.5)), Advice::default());
    }

    #[test]
    fn it_bends_once_for_one_thing_and_goes_back_when_it_is_gone() {
        let mut adviser = ordered();
        let thing = [Point::new(2.0, 0.0)];
        let bent = look(&mut adviser, 0.0, &thing).path.unwrap();
        assert!(
            bent.poses
                .iter()
                .any(|pose| pose.pose.position.y.abs() > 0.2)
        );
        for _ in 0..5 {
            assert_eq!(look(&mut adviser, 0.0, &thing), Advice::default());
        }
        let back = look(&mut adviser, 0.5, &[]).path.unwrap();
        assert!(
            back.poses
                .iter()
                .all(|pose| pose.pose.position.y.abs() < 1e-9)
        );
    }

    #[test]
    fn a_far_barrier_blocks_after_three_looks_and_once() {
        let mut adviser = ordered();
        look(&mut adviser, 0.0, &[]);
        for _ in 0..2 {
            assert_eq!(look(&mut adviser, 0.0, &wall(3.0)), Advice::default());
        }
        let blocked = look(&mut adviser, 0.0, &wall(3.0));
        assert!(is_stop(&blocked));
        let Some(BlockedCause::Barrier(barrier)) = blocked.blocked else {
            panic!("{blocked:?}");
        };
        assert!((barrier.point - Point::new(3.0, 0.0)).norm() < 0.1);
        for seen in [wall(3.0), Vec::new()] {
            assert_eq!(
                look(&mut adviser, 0.0, &seen),
                Advice::default(),
                "blocked is blocked"
            );
        }
        adviser.set_path(&path());
        assert!(
            look(&mut adviser, 0.0, &[]).path.is_some(),
            "until the next path"
        );
    }

    #[test]
    fn a_robot_that_gets_no_farther_on_a_free_path_is_blocked() {
        let mut adviser = ordered();
        let mut look_at = |now: i64, x: f64| {
            let robot = heading(Point::new(x, 0.0), 0.0);
            let seen = std::iter::empty();
            adviser.advise(
                Time::from_nanos(now),
                &robot,
                seen,
                None,
                &LIMITS,
                &PATIENCE,
            )
        };
        look_at(0, 0.0);
        for (now, x) in [
            (50, 0.06),
            (90, 0.12),
            (140, 0.18),
            (180, 0.24),
            (270, 0.25),
        ] {
            assert_eq!(look_at(now, x), Advice::default());
        }
        let stuck = look_at(280, 0.26);
        assert_eq!(
            stuck.blocked,
            Some(BlockedCause::Stuck(Point::new(0.26, 0.0)))
        );
        assert!(is_stop(&stuck));
        assert_eq!(look_at(2000, 1.15), Advice::default());
    }

    #[test]
    fn a_robot_that_arrived_is_not_stuck() {
        let mut adviser = ordered();
        for now in 0..9 {
            let robot = heading(Point::new(7.96, 0.0), 0.0);
            let seen = std::iter::empty();
            let now = Time::from_nanos(now * 50);
            let advice = adviser.advise(now, &robot, seen, None, &LIMITS, &PATIENCE);
            assert_eq!(advice.blocked, None);
        }
    }

    #[test]
    fn a_near_barrier_stops_at_once_and_need_not_block() {
        let mut adviser = ordered();
        look(&mut adviser, 0.0, &[]);
        let held = look(&mut adviser, 0.0, &wall(0.8));
        assert!(is_stop(&held) && held.blocked.is_none());
        assert_eq!(look(&mut adviser, 0.0, &wall(0.8)), Advice::default());
        assert_eq!(
            look(&mut adviser, 0.0, &[]).path,
            Some(path()),
            "somebody only passed by"
        );
        for _ in 0..2 {
            assert!(look(&mut adviser, 0.0, &wall(0.8)).blocked.is_none());
        }
        let blocked = look(&mut adviser, 0.0, &wall(0.8));
        assert!(
            blocked.blocked.is_some() && blocked.path.is_none(),
            "it was stopped before"
        );
    }

    #[test]
    fn a_path_that_is_given_before_a_barrier_is_never_driven() {
        let mut adviser = ordered();
        let last_advice: Vec<Advice> = (0..3)
            .map(|_| look(&mut adviser, 0.0, &wall(0.8)))
            .collect();
        assert!(
            is_stop(&last_advice[0])
                && last_advice[1] == Advice::default()
                && last_advice[2].blocked.is_some()
        );
    }

    #[test]
    fn without_eyes_it_trusts_the_planner_and_when_it_loses_them_it_stops() {
        let mut adviser = ordered();
        assert_eq!(adviser.advise_without_scan(false).path, Some(path()));
        assert_eq!(adviser.advise_without_scan(false), Advice::default());
        assert!(is_stop(&adviser.advise_without_scan(true)));
        assert_eq!(adviser.advise_without_scan(true), Advice::default());
        assert_eq!(look(&mut adviser, 0.0, &[]).path, Some(path()));
    }
}
