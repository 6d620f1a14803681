//! Regulated pure pursuit: the speed and the turn that follow a line.
//!
//! Macenski, Singh, Martín, Ginés: *Regulated Pure Pursuit for Robot Path Tracking*, Autonomous Robots 47, 2023.
//! Pure pursuit (Coulter, 1992) drives the circle that ends in a carrot on the line ahead; regulation slows down in
//! tight curves and before the goal. Added here: the carrot comes nearer where the chord to it would cut a corner.

use std::f64::consts::FRAC_PI_2;

use geometry::{Point, Polyline, Pose, Vector};
use messages::Twist;

/// How to drive; the numbers of the paper under the names of Nav2's controller where it has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// m/s, on a straight line.
    pub speed: f64,
    /// m/s, never slower than this on account of a curve.
    pub speed_in_curves: f64,
    /// m/s, never slower than this before the goal.
    pub speed_at_goal: f64,
    /// rad/s, the fastest turn.
    pub turn: f64,
    /// m/s², the braking on which the approach to the goal counts.
    pub braking: f64,
    /// rad/s², the braking of a turn on the spot.
    pub turn_braking: f64,
    /// s, how far ahead of the robot the carrot is at the present speed.
    pub lookahead_time: f64,
    /// m, the nearest carrot.
    pub lookahead_min: f64,
    /// m, the farthest carrot.
    pub lookahead_max: f64,
    /// m, how far the way to the carrot may leave the line.
    pub cut: f64,
    /// m, curves tighter than this are driven more slowly.
    pub regulated_radius: f64,
    /// m before the goal, from where on the robot slows down.
    pub approach: f64,
    /// rad, a carrot farther aside is first turned to on the spot.
    pub rotate_from: f64,
}

/// A turn on the spot ends when the carrot is this close to straight ahead, rad.
const ROTATED: f64 = 0.15;

/// The gain of a turn on the spot, 1/s.
const ROTATE_GAIN: f64 = 3.0;

impl Settings {
    /// How far ahead the carrot is at `speed` m/s, m.
    pub fn lookahead(&self, speed: f64) -> f64 {
        (speed.abs() * self.lookahead_time)
            .max(self.lookahead_min)
            .min(self.lookahead_max.max(self.lookahead_min))
    }

    /// The carrot for a robot at `from` whose nearest place on the line is `along` metres from the line's start: the
    /// farthest place within the lookahead to which the straight way stays within `cut` of the line.
    pub fn carrot(&self, line: &Polyline, from: Point, along: f64, speed: f64) -> Option<Point> {
        let mut ahead = self.lookahead(speed);
        loop {
            let carrot = place(line, along + ahead)?;
            if ahead <= self.lookahead_min || self.keeps_to(line, from, carrot, along, ahead) {
                return Some(carrot);
            }
            ahead = (ahead * 0.8).max(self.lookahead_min);
        }
    }

    /// Whether the straight way from `from` to the carrot stays within `cut` of the line. A robot that is off the line
    /// has to come back first: so much more is allowed as a straight way back needs.
    fn keeps_to(&self, line: &Polyline, from: Point, carrot: Point, along: f64, ahead: f64) -> bool {
        let off = place(line, along).map_or(0.0, |here| (here - from).norm());
        let chord = Polyline::new([from, carrot]);
        let samples = (ahead / self.cut.max(0.01)).ceil().min(64.0) as u32;
        (1..samples)
            .map(|sample| f64::from(sample) / f64::from(samples))
            .filter_map(|share| Some((share, chord.nearest(place(line, along + ahead * share)?)?)))
            .all(|(share, nearest)| nearest.distance <= self.cut + off * (1.0 - share))
    }

    /// The command that drives towards `carrot` (in the body's frame) with `remaining` metres of line before the goal.
    /// `rotating` says whether the last command was a turn on the spot; it is updated.
    pub fn drive(&self, carrot: Vector, remaining: f64, rotating: &mut bool) -> Twist {
        let aside = carrot.y.atan2(carrot.x);
        let tolerated = if *rotating { ROTATED } else { self.rotate_from };
        *rotating = aside.abs() > tolerated.min(FRAC_PI_2);
        if *rotating {
            return self.rotate(aside);
        }
        let curvature = 2.0 * carrot.y / carrot.norm_squared().max(1e-6);
        let speed = self.regulated(curvature, remaining);
        let turn = speed * curvature;
        if turn.abs() > self.turn {
            return Twist::planar(self.turn / curvature.abs(), self.turn.copysign(turn));
        }
        Twist::planar(speed, turn)
    }

    /// The speed for a curve of `curvature` 1/m with `remaining` metres of line before the goal, m/s.
    pub fn regulated(&self, curvature: f64, remaining: f64) -> f64 {
        let in_curve = self.speed * (self.regulated_radius * curvature.abs()).max(1.0).recip();
        let in_curve = in_curve.max(self.speed_in_curves.min(self.speed));
        let before_goal = self.speed * (remaining / self.approach.max(1e-6)).min(1.0);
        let stoppable = (2.0 * self.braking * remaining.max(0.0)).sqrt();
        let before_goal = before_goal.min(stoppable).max(self.speed_at_goal.min(self.speed));
        in_curve.min(before_goal)
    }

    /// The turn on the spot by `angle` radians: as fast as it can still be stopped.
    pub fn rotate(&self, angle: f64) -> Twist {
        let stoppable = (2.0 * self.turn_braking * angle.abs()).sqrt();
        let turn = (ROTATE_GAIN * angle.abs()).min(stoppable).min(self.turn);
        Twist::planar(0.0, turn.copysign(angle))
    }
}

fn place(line: &Polyline, along: f64) -> Option<Point> {
    line.at(along).map(|pose: Pose| pose.translation.vector.into())
}
