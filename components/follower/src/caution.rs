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
