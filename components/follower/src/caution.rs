//! The speed that leaves room to brake.
//!
//! Two limits hold at once. Along the path: at each point ahead the robot may have the speed that clearance and curvature
//! allow there, and before it the speed from which it can brake to that (a backward pass over the speed profile, as in
//! time-optimal path parameterisation: Bobrow, Dubowsky, Gibson, IJRR 1985). Along the arc that is about to be driven:
//! the robot must be able to stop before the arc touches something.

use asmotion_component::Properties;
use asmotion_geometry::{Arc, Brakes, DECELERATION, Point, Polyline, Pose, turn, yaw};
use asmotion_messages::Twist;

use crate::motion::MeasuredMotion;
use crate::pursuit::Pursuit;

/// The robot's size and brakes, and the distance it keeps.
#[derive(Debug, Clone, Copy, PartialEq, Properties)]
pub struct Caution {
    /// Radius of the disc that covers the robot.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.2)]
    pub robot_radius_m: f64,
    /// Distance between the robot's disc and an obstacle on its way at which it must be able to stand.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.03)]
    pub stop_margin_m: f64,
    /// Clearance beside the path divided by the speed it allows.
    #[property(unit = "s", range = 0.0..=60.0, default = 0.2)]
    pub clearance_s: f64,
    /// Lower bound of the speed beside obstacles that the path does not touch, unless `max_speed` is lower.
    #[property(unit = "m/s", range = 0.01..=10.0, default = 0.3)]
    pub min_clearance_speed: f64,
    /// Deceleration that the rover can brake with; must not exceed the rover's `max_acceleration`.
    #[property(unit = "m/s²", range = 0.01..=50.0, default = DECELERATION)]
    pub deceleration: f64,
    /// Time between a scan and the beginning of braking.
    #[property(unit = "s", range = 0.0..=10.0, default = 0.2)]
    pub reaction_s: f64,
}

/// Obstacles around the robot.
#[derive(Debug, Clone, Copy)]
pub struct CautiousView<'a> {
    /// The robot's size and brakes.
    pub caution: &'a Caution,
    /// Points seen by the laser, in the frame of the path.
    pub points: &'a [Point],
}

/// Distance in m between two points of the path at which the speed is limited.
const STEP: f64 = 0.1;

/// Half the length in m of the chord over which the curvature of the path is measured.
const CHORD: f64 = 0.2;

/// Share of the turn rate limit that curves of the path may need; the rest is left for corrections.
const TURN_SHARE: f64 = 0.8;

/// Speed in m/s below which the robot turns towards the carrot on the spot instead of driving.
const CREEP: f64 = 0.02;

/// Bearing of the carrot in rad from which a robot that must not drive turns towards it.
const ASIDE: f64 = 0.1;

/// Time in s for which a command acts before the next one does.
const COMMANDED: f64 = 0.1;

/// The position of the robot on its path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaceOnPath<'a> {
    pub(crate) line: &'a Polyline,
    /// Distance from the start of the line, m.
    pub(crate) along: f64,
    /// Point of the line that the robot drives to, body frame, m.
    pub(crate) carrot: Point,
}

impl CautiousView<'_> {
    /// Limits the speed of a twist that drives to the carrot. The curve remains the same also while the robot is faster
    /// than it may be: the turn rate is that of the speed it has.
    pub(crate) fn limit(
        &self,
        pursuit: &Pursuit,
        place: &PlaceOnPath<'_>,
        motion: &MeasuredMotion,
        twist: Twist,
    ) -> Twist {
        let Some(arc) = Arc::of(twist.linear.x, twist.angular.z) else {
            return twist;
        };
        let limit = self
            .along_the_path(pursuit, place, &motion.pose)
            .min(self.along_the_arc(&arc, place, &motion.pose));
        let speed = twist.linear.x.min(limit);
        let aside = place.carrot.y.atan2(place.carrot.x);
        if speed < CREEP && motion.speed < CREEP && aside.abs() > ASIDE {
            return pursuit.rotate(aside);
        }
        let rolling = motion.speed - self.caution.deceleration * COMMANDED;
        let turn = arc.curvature() * speed.max(rolling);
        Twist::planar(speed, turn.clamp(-pursuit.max_turn, pursuit.max_turn))
    }

    /// The speed from which the robot can slow down for everything ahead on the path, m/s.
    fn along_the_path(&self, pursuit: &Pursuit, place: &PlaceOnPath<'_>, robot: &Pose) -> f64 {
        let (caution, brakes) = (self.caution, self.caution.brakes());
        let horizon = brakes.distance(pursuit.max_speed) + caution.stop_margin_m;
        let ahead = horizon.min(place.line.length() - place.along);
        let (here, reach) = (
            Point::from(robot.translation.vector),
            caution.reach(pursuit),
        );
        let near = |point: &&Point| (*point - here).norm() <= horizon + reach;
        let points: Vec<Point> = self.points.iter().filter(near).copied().collect();
        let samples = (ahead / STEP).floor().max(0.0) as u32;
        (0..=samples)
            .map(|sample| f64::from(sample) * STEP)
            .filter_map(|on| {
                let there = place.line.at(place.along + on)?.translation.vector.into();
                let free = clearance(&points, there) - caution.robot_radius_m;
                let curvature = curvature(place.line, place.along + on)?;
                Some(caution.allowed(pursuit, on, free, curvature))
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// The speed from which the robot can stop before it touches something on the way to the carrot, m/s.
    fn along_the_arc(&self, arc: &Arc, place: &PlaceOnPath<'_>, robot: &Pose) -> f64 {
        let back = robot.inverse();
        let seen = self.points.iter().map(|point| back * point);
        let radius = self.caution.robot_radius_m;
        let free = arc.free(seen, radius);
        // beyond the carrot the robot leaves the arc
        if free > place.carrot.coords.norm() {
            return f64::INFINITY;
        }
        self.caution
            .brakes()
            .speed(free - self.caution.stop_margin_m)
    }
}

impl Caution {
    fn brakes(&self) -> Brakes {
        Brakes {
            deceleration: self.deceleration,
            reaction_s: self.reaction_s,
        }
    }

    /// Distance in m from the path within which obstacles limit the speed.
    fn reach(&self, pursuit: &Pursuit) -> f64 {
        self.robot_radius_m + pursuit.max_speed * self.clearance_s
    }

    /// The speed, m/s, allowed now by a point `on` metres ahead on the path with this clearance (m) and curvature (1/m).
    fn allowed(&self, pursuit: &Pursuit, on: f64, free: f64, curvature: f64) -> f64 {
        let brakes = self.brakes();
        if free <= 0.0 && on > self.robot_radius_m {
            return brakes.speed(on - self.stop_margin_m);
        }
        let turnable = TURN_SHARE * pursuit.max_turn / curvature.abs().max(1e-9);
        let in_curve = turnable.max(pursuit.min_curve_speed);
        let beside = (free / self.clearance_s.max(1e-9)).max(self.min_clearance_speed);
        brakes.speed_before(on, in_curve.min(beside))
    }
}

/// Distance from a point to the nearest of `points`, m; infinite if there is none.
fn clearance(points: &[Point], from: Point) -> f64 {
    let squares = points.iter().map(|point| (point - from).norm_squared());
    squares.fold(f64::INFINITY, f64::min).sqrt()
}

/// Curvature of a line at a distance from its start, 1/m.
fn curvature(line: &Polyline, along: f64) -> Option<f64> {
    let (before, after) = (line.at(along - CHORD)?, line.at(along + CHORD)?);
    Some(turn(yaw(&before), yaw(&after)) / (2.0 * CHORD))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pursuit::tests::PURSUIT;
    use asmotion_geometry::heading;

    const CAUTION: Caution = Caution {
        robot_radius_m: 0.2,
        stop_margin_m: 0.03,
        clearance_s: 0.2,
        min_clearance_speed: 0.3,
        deceleration: 1.0,
        reaction_s: 0.2,
    };

    const FAST: Pursuit = Pursuit {
        max_speed: 2.0,
        ..PURSUIT
    };

    /// A robot on a path along the x axis, 10 m long, that wants to drive at 2 m/s.
    struct Scene {
        points: Vec<(f64, f64)>,
        line: Vec<(f64, f64)>,
        along: f64,
        carrot: (f64, f64),
        speed: f64,
        turn: f64,
    }

    impl Default for Scene {
        fn default() -> Self {
            Self {
                points: Vec::new(),
                line: vec![(0.0, 0.0), (10.0, 0.0)],
                along: 0.0,
                carrot: (0.6, 0.0),
                speed: 2.0,
                turn: 0.0,
            }
        }
    }

    impl Scene {
        /// The command: speed and turn rate. It is the same wherever the world is turned.
        fn command(&self) -> (f64, f64) {
            let [one, other] = [Pose::identity(), heading(Point::new(5.0, -3.0), 2.0)]
                .map(|world| self.command_in(&world));
            assert!((one.0 - other.0).abs() < 1e-9 && (one.1 - other.1).abs() < 1e-9);
            one
        }

        fn command_in(&self, world: &Pose) -> (f64, f64) {
            let place = |&(x, y): &(f64, f64)| world * Point::new(x, y);
            let line = Polyline::new(self.line.iter().map(place));
            let points: Vec<Point> = self.points.iter().map(place).collect();
            let robot = line.at(self.along).unwrap();
            let view = CautiousView {
                caution: &CAUTION,
                points: &points,
            };
            let place = PlaceOnPath {
                line: &line,
                along: self.along,
                carrot: Point::new(self.carrot.0, self.carrot.1),
            };
            let motion = MeasuredMotion {
                pose: robot,
                speed: self.speed,
                turn: 0.0,
            };
            let twist = view.limit(&FAST, &place, &motion, Twist::planar(2.0, self.turn));
            (twist.linear.x, twist.angular.z)
        }

        #[track_caller]
        fn allows(&self, speed: f64) {
            let (allowed, _) = self.command();
            assert!(
                (allowed - speed).abs() < 1e-9,
                "{allowed} instead of {speed}"
            );
        }
    }

    fn points(points: &[(f64, f64)]) -> Scene {
        Scene {
            points: points.to_vec(),
            ..Scene::default()
        }
    }

    #[test]
    fn nothing_near_allows_everything() {
        points(&[]).allows(2.0);
        points(&[(1.0, 3.0), (-1.0, 0.0), (8.0, 0.0)]).allows(2.0);
    }

    #[test]
    fn clearance_beside_the_path_limits_the_speed() {
        // 0.08 m beside the robot, in 0.2 s
        points(&[(0.0, 0.28)]).allows(0.4);
        points(&[(0.0, -0.28)]).allows(0.4);
        points(&[(0.0, 0.22)]).allows(0.3);
        // 0.6 m ahead it may be faster than beside the point, but has to brake before
        let ahead = (0.1_f64.hypot(0.28) - 0.2) / 0.2;
        let braked = CAUTION.brakes().speed_before(0.6, ahead);
        points(&[(0.7, 0.28)]).allows(braked);
        // a tenth of a metre beyond the horizon of 2.43 m, and just within it
        points(&[(2.9, 0.28)]).allows(2.0);
        let slower = Scene {
            along: 1.0,
            ..points(&[(1.7, 0.28)])
        };
        slower.allows(braked);
    }

    #[test]
    fn obstacles_count_as_far_from_the_path_as_they_limit_the_speed() {
        let caution = Caution {
            clearance_s: 2.0,
            ..CAUTION
        };
        // a radius of 0.2 m, and 2 s at 2 m/s
        assert_eq!(caution.reach(&FAST), 4.2);
    }

    #[test]
    fn the_robot_can_stop_before_what_the_path_touches() {
        let brakes = CAUTION.brakes();
        // it is beside the robot 0.8 m ahead, and touched 0.9 m ahead
        points(&[(1.05, 0.0)]).allows(brakes.speed_before(0.8, 0.3));
        // only the path touches it: the arc leads elsewhere
        let aside = Scene {
            turn: -2.0,
            ..points(&[(0.6, 0.15)])
        };
        let first = (0..7)
            .map(|n| f64::from(n) * 0.1)
            .find(|on| (0.6 - on).hypot(0.15) <= 0.2)
            .unwrap();
        let before = brakes.speed_before(first - 0.1, 0.3);
        aside.allows(brakes.speed(first - 0.03).min(before));
    }

    #[test]
    fn the_robot_can_stop_before_what_the_arc_touches() {
        let brakes = CAUTION.brakes();
        let wall = |carrot| Scene {
            carrot,
            turn: 2.0,
            line: vec![(0.0, 0.0), (0.05, 0.0)],
            ..points(&[(0.6, 0.1)])
        };
        // at 1 m radius the disc touches the point after this way
        let free = Arc::of(2.0, 2.0)
            .unwrap()
            .free([Point::new(0.6, 0.1)], CAUTION.robot_radius_m);
        assert!((0.4..0.5).contains(&free), "{free}");
        wall((1.0, 0.5)).allows(brakes.speed(free - 0.03));
        // beyond the carrot the robot leaves the arc
        wall((free - 0.01, 0.0)).allows(2.0);
    }

    #[test]
    fn what_the_robot_touches_allows_no_motion_towards_it() {
        points(&[(0.15, 0.1)]).allows(0.0);
        // it may leave
        points(&[(-0.15, 0.1)]).allows(0.3);
    }

    #[test]
    fn a_curve_allows_the_speed_at_which_it_can_be_turned() {
        let corner = |along| Scene {
            line: vec![(0.0, 0.0), (1.0, 0.0), (1.0, 5.0)],
            along,
            ..Scene::default()
        };
        // a quarter turn over 0.4 m, with four fifths of 1.2 rad/s
        let in_curve = 0.8 * 1.2 / (std::f64::consts::FRAC_PI_2 / 0.4);
        corner(0.9).allows(in_curve);
        let on = 0.3; // the first place whose chord reaches the corner
        corner(0.55).allows(CAUTION.brakes().speed_before(on, in_curve));
        let hairpin = Scene {
            line: vec![(0.0, 0.0), (1.0, 0.0), (0.0, 0.001)],
            along: 0.95,
            ..Scene::default()
        };
        hairpin.allows(FAST.min_curve_speed);
    }

    #[test]
    fn a_robot_that_must_not_drive_turns_towards_the_carrot() {
        let blocked = |carrot, speed| Scene {
            carrot,
            speed,
            ..points(&[(0.19, 0.0)])
        };
        let (speed, turn) = blocked((0.5, 0.2), 0.0).command();
        let aside = 0.2_f64.atan2(0.5);
        assert_eq!((speed, turn), (0.0, FAST.rotate(aside).angular.z));
        let (speed, turn) = blocked((0.5, -0.2), 0.019).command();
        assert_eq!((speed, turn), (0.0, -FAST.rotate(aside).angular.z));
        // not while it rolls, nor when it looks at the carrot
        assert_eq!(blocked((0.5, 0.2), 0.02).command(), (0.0, 0.0));
        assert_eq!(blocked((0.5, 0.049), 0.0).command(), (0.0, 0.0));
        // nor when it may drive
        let free = Scene {
            carrot: (0.5, 0.2),
            speed: 0.0,
            ..Scene::default()
        };
        assert_eq!(free.command(), (2.0, 0.0));
    }

    #[test]
    fn a_robot_that_is_too_fast_keeps_its_curve() {
        let beside = |speed, turn| Scene {
            speed,
            turn,
            ..points(&[(0.0, 0.22)])
        };
        // curvature 0.25 1/m
        let close = |(speed, turn): (f64, f64), wanted: (f64, f64)| {
            assert!((speed - wanted.0).abs() < 1e-9, "{speed}");
            assert!((turn - wanted.1).abs() < 1e-9, "{turn}");
        };
        close(beside(1.0, -0.5).command(), (0.3, -0.25 * 0.9));
        close(beside(0.3, -0.5).command(), (0.3, -0.25 * 0.3));
        close(beside(2.0, -2.0).command(), (0.3, -1.2));
    }
}
