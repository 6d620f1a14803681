//! Regulated pure pursuit: the speed and the turn that follow a line.
//!
//! Macenski, Singh, Martín, Ginés: *Regulated Pure Pursuit for Robot Path Tracking*, Autonomous Robots 47, 2023.
//! Pure pursuit (Coulter, 1992) drives the circle that ends in a carrot on the line ahead; regulation slows down in
//! tight curves and before the goal. Added here: the carrot comes nearer where the chord to it would cut a corner.

use std::f64::consts::FRAC_PI_2;

use asmotion_geometry::{Point, Polyline, Pose, Vector};
use asmotion_messages::Twist;

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
    fn keeps_to(
        &self,
        line: &Polyline,
        from: Point,
        carrot: Point,
        along: f64,
        ahead: f64,
    ) -> bool {
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
        let before_goal = before_goal
            .min(stoppable)
            .max(self.speed_at_goal.min(self.speed));
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
    line.at(along)
        .map(|pose: Pose| pose.translation.vector.into())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use asmotion_geometry::heading;
    use proptest::prelude::*;

    pub const SETTINGS: Settings = Settings {
        speed: 0.5,
        speed_in_curves: 0.15,
        speed_at_goal: 0.05,
        turn: 1.2,
        braking: 0.4,
        turn_braking: 1.5,
        lookahead_time: 1.2,
        lookahead_min: 0.25,
        lookahead_max: 0.7,
        cut: 0.05,
        regulated_radius: 0.8,
        approach: 0.6,
        rotate_from: 0.785,
    };

    fn line(points: &[(f64, f64)]) -> Polyline {
        Polyline::new(points.iter().map(|(x, y)| Point::new(*x, *y)))
    }

    fn driven(x: f64, y: f64, remaining: f64) -> (f64, f64) {
        let twist = SETTINGS.drive(Vector::new(x, y), remaining, &mut false);
        (twist.linear.x, twist.angular.z)
    }

    #[test]
    fn it_looks_farther_ahead_when_it_is_faster() {
        for (speed, ahead) in [(0.0, 0.25), (0.5, 0.6), (-0.5, 0.6), (2.0, 0.7)] {
            assert_eq!(SETTINGS.lookahead(speed), ahead);
        }
    }

    #[test]
    fn it_drives_the_circle_that_ends_in_the_carrot() {
        assert_eq!(driven(0.6, 0.0, 9.0), (0.5, 0.0));
        // a carrot at (0.6, 0.2) lies on a circle of radius (0.6² + 0.2²) / (2 · 0.2) = 1 m
        let (speed, turn) = driven(0.6, 0.2, 9.0);
        assert!((turn / speed - 1.0).abs() < 1e-12);
        let (_, right) = driven(0.6, -0.2, 9.0);
        assert_eq!(right, -turn);
    }

    #[test]
    fn it_slows_down_in_curves_and_before_the_goal() {
        for (curvature, remaining, speed) in [
            (0.0, 9.0, 0.5),
            (1.0, 9.0, 0.5),    // wider than the regulated radius
            (2.5, 9.0, 0.25),   // half of it
            (50.0, 9.0, 0.15),  // never slower for a curve
            (0.0, 0.3, 0.25),   // half of the approach
            (0.0, 0.001, 0.05), // never slower for the goal
            (50.0, 0.001, 0.05),
        ] {
            assert!(
                (SETTINGS.regulated(curvature, remaining) - speed).abs() < 1e-9,
                "{curvature} {remaining}"
            );
        }
    }

    #[test]
    fn it_turns_on_the_spot_first_and_does_not_dither() {
        let mut rotating = false;
        let mut towards = |angle: f64| {
            let carrot = Vector::new(angle.cos(), angle.sin());
            SETTINGS.drive(carrot, 9.0, &mut rotating).linear.x > 0.0
        };
        assert!(towards(0.7));
        assert!(!towards(0.8));
        assert!(
            !towards(0.7),
            "once turning, it turns until the carrot is ahead"
        );
        assert!(!towards(-0.2));
        assert!(towards(0.1));
        assert!(towards(0.7));
    }

    #[test]
    fn it_does_not_cut_corners() {
        let corner = line(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]);
        let far = SETTINGS
            .carrot(&corner, Point::new(0.5, 0.0), 0.5, 0.5)
            .unwrap();
        assert!((far - Point::new(1.1, 0.0)).norm() < 1e-9);
        let near = SETTINGS
            .carrot(&corner, Point::new(1.7, 0.0), 1.7, 0.5)
            .unwrap();
        assert!((near - Point::new(2.0, 0.0)).norm() < 0.15, "{near}");
    }

    #[test]
    fn the_end_of_the_line_is_the_last_carrot() {
        let short = line(&[(0.0, 0.0), (0.3, 0.0)]);
        assert_eq!(
            SETTINGS.carrot(&short, Point::origin(), 0.0, 0.5),
            Some(Point::new(0.3, 0.0))
        );
        assert_eq!(
            SETTINGS.carrot(&Polyline::default(), Point::origin(), 0.0, 0.5),
            None
        );
    }

    proptest! {
        #[test]
        fn it_never_drives_faster_than_it_may(x in -2.0..2.0, y in -2.0..2.0, remaining in 0.0..5.0, rotating: bool) {
            let twist = SETTINGS.drive(Vector::new(x, y), remaining, &mut rotating.clone());
            prop_assert!((0.0..=SETTINGS.speed).contains(&twist.linear.x));
            prop_assert!(twist.angular.z.abs() <= SETTINGS.turn);
        }

        #[test]
        fn it_comes_to_a_line_from_anywhere_near(y in -1.0..1.0, angle in -3.1..3.1) {
            let straight = line(&[(0.0, 0.0), (20.0, 0.0)]);
            let (mut pose, mut speed, mut rotating) = (heading(Point::new(1.0, y), angle), 0.0, false);
            for _ in 0..400 {
                let here = Point::from(pose.translation.vector);
                let along = straight.nearest(here).unwrap().along;
                let carrot = SETTINGS.carrot(&straight, here, along, speed).unwrap();
                let carrot = pose.inverse() * carrot;
                let twist = SETTINGS.drive(carrot.coords, 20.0 - along, &mut rotating);
                speed = twist.linear.x;
                let moved = pose * Point::new(speed * 0.05, 0.0);
                pose = heading(moved, asmotion_geometry::yaw(&pose) + twist.angular.z * 0.05);
            }
            prop_assert!(pose.translation.y.abs() < 0.02, "{pose}");
        }
    }
}
