//! Regulated pure pursuit: computes the twist that follows a line.
//!
//! Macenski, Singh, Martín, Ginés: *Regulated Pure Pursuit for Robot Path Tracking*, Autonomous Robots 47, 2023.
//! Pure pursuit (Coulter, 1992) drives the circle that ends in a carrot on the line ahead; regulation slows down in
//! tight curves and before the goal. Added here: the carrot comes nearer where the chord to it would cut a corner.

use std::f64::consts::FRAC_PI_2;

use asmotion_component::Properties;
use asmotion_geometry::{Point, Polyline, Pose, Vector};
use asmotion_messages::Twist;

/// The control law's parameters, under the names of Nav2's controller where it has them.
#[derive(Debug, Clone, Copy, PartialEq, Properties)]
pub struct Pursuit {
    /// Forward speed limit, driven on straight lines.
    #[property(unit = "m/s", range = 0.0..=10.0, default = 0.5)]
    pub max_speed: f64,
    /// Lower bound of the speed in tight curves, unless `max_speed` is lower.
    #[property(unit = "m/s", range = 0.01..=10.0, default = 0.15)]
    pub min_curve_speed: f64,
    /// Lower bound of the speed before the goal, unless `max_speed` is lower.
    #[property(unit = "m/s", range = 0.01..=10.0, default = 0.05)]
    pub min_approach_speed: f64,
    /// Turn rate limit.
    #[property(unit = "rad/s", range = 0.01..=20.0, default = 1.2)]
    pub max_turn: f64,
    /// Deceleration assumed when slowing down before the goal.
    #[property(unit = "m/s²", range = 0.01..=50.0, default = 0.4)]
    pub braking: f64,
    /// Angular deceleration assumed when turning on the spot.
    #[property(unit = "rad/s²", range = 0.01..=100.0, default = 1.5)]
    pub turn_braking: f64,
    /// Lookahead distance divided by the present speed.
    #[property(unit = "s", range = 0.0..=60.0, default = 1.2)]
    pub lookahead_s: f64,
    /// Shortest lookahead distance.
    #[property(unit = "m", range = 0.01..=100.0, default = 0.25)]
    pub lookahead_min_m: f64,
    /// Longest lookahead distance.
    #[property(unit = "m", range = 0.01..=100.0, default = 0.7)]
    pub lookahead_max_m: f64,
    /// Largest distance between the path and the chord from the robot to the carrot; where a corner would be cut by
    /// more, the carrot comes nearer.
    #[property(unit = "m", range = 0.001..=10.0, default = 0.04)]
    pub corner_cut_m: f64,
    /// Curves with a smaller radius are driven more slowly, in proportion.
    #[property(unit = "m", range = 0.0..=100.0, default = 0.8)]
    pub curve_radius_m: f64,
    /// Distance before the goal from which the robot slows down.
    #[property(unit = "m", range = 0.0..=100.0, default = 0.6)]
    pub approach_m: f64,
    /// Bearing of the carrot from which the robot turns on the spot first.
    #[property(unit = "rad", range = 0.2..=1.57, default = 0.785)]
    pub rotate_from: f64,
}

/// Bearing of the carrot in rad below which a turn on the spot ends.
const ROTATED: f64 = 0.15;

/// Proportional gain of a turn on the spot, 1/s.
const ROTATE_GAIN: f64 = 3.0;

impl Pursuit {
    /// Lookahead distance at `speed` m/s, m.
    pub fn lookahead(&self, speed: f64) -> f64 {
        (speed.abs() * self.lookahead_s)
            .max(self.lookahead_min_m)
            .min(self.lookahead_max_m.max(self.lookahead_min_m))
    }

    /// The carrot for a robot at `from` whose nearest point on the line is `along` metres from the line's start: the
    /// farthest point within the lookahead distance for which the chord stays within `corner_cut_m` of the line.
    pub fn carrot(&self, line: &Polyline, from: Point, along: f64, speed: f64) -> Option<Point> {
        let mut ahead = self.lookahead(speed);
        loop {
            let carrot = point_at(line, along + ahead)?;
            if ahead <= self.lookahead_min_m || self.stays_close(line, from, carrot, along, ahead) {
                return Some(carrot);
            }
            ahead = (ahead * 0.8).max(self.lookahead_min_m);
        }
    }

    /// Returns whether the chord from `from` to the carrot stays within `corner_cut_m` of the line. A robot off the
    /// line must return to it first, so its distance from the line is allowed in addition, decreasing to zero at the
    /// carrot.
    fn stays_close(
        &self,
        line: &Polyline,
        from: Point,
        carrot: Point,
        along: f64,
        ahead: f64,
    ) -> bool {
        let off = point_at(line, along).map_or(0.0, |here| (here - from).norm());
        let chord = Polyline::new([from, carrot]);
        let samples = (ahead / self.corner_cut_m.max(0.01)).ceil().min(64.0) as u32;
        (1..samples)
            .map(|sample| f64::from(sample) / f64::from(samples))
            .filter_map(|share| {
                Some((
                    share,
                    chord.nearest(point_at(line, along + ahead * share)?)?,
                ))
            })
            .all(|(share, nearest)| nearest.distance <= self.corner_cut_m + off * (1.0 - share))
    }

    /// The twist that drives towards `carrot` (body frame) with `remaining` metres of line before the goal. `rotating`
    /// tells whether the last command was a turn on the spot, and is updated.
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
        if turn.abs() > self.max_turn {
            return Twist::planar(
                self.max_turn / curvature.abs(),
                self.max_turn.copysign(turn),
            );
        }
        Twist::planar(speed, turn)
    }

    /// The speed for a curve of `curvature` 1/m with `remaining` metres of line before the goal, m/s.
    pub fn regulated(&self, curvature: f64, remaining: f64) -> f64 {
        let in_curve = self.max_speed * (self.curve_radius_m * curvature.abs()).max(1.0).recip();
        let in_curve = in_curve.max(self.min_curve_speed.min(self.max_speed));
        let before_goal = self.max_speed * (remaining / self.approach_m.max(1e-6)).min(1.0);
        let stoppable = (2.0 * self.braking * remaining.max(0.0)).sqrt();
        let before_goal = before_goal
            .min(stoppable)
            .max(self.min_approach_speed.min(self.max_speed));
        in_curve.min(before_goal)
    }

    /// A turn on the spot by `angle` radians, as fast as it can still be stopped.
    pub fn rotate(&self, angle: f64) -> Twist {
        let stoppable = (2.0 * self.turn_braking * angle.abs()).sqrt();
        let turn = (ROTATE_GAIN * angle.abs())
            .min(stoppable)
            .min(self.max_turn);
        Twist::planar(0.0, turn.copysign(angle))
    }
}

fn point_at(line: &Polyline, along: f64) -> Option<Point> {
    line.at(along)
        .map(|pose: Pose| pose.translation.vector.into())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use asmotion_geometry::heading;
    use proptest::prelude::*;

    pub const PURSUIT: Pursuit = Pursuit {
        max_speed: 0.5,
        min_curve_speed: 0.15,
        min_approach_speed: 0.05,
        max_turn: 1.2,
        braking: 0.4,
        turn_braking: 1.5,
        lookahead_s: 1.2,
        lookahead_min_m: 0.25,
        lookahead_max_m: 0.7,
        corner_cut_m: 0.05,
        curve_radius_m: 0.8,
        approach_m: 0.6,
        rotate_from: 0.785,
    };

    fn line(points: &[(f64, f64)]) -> Polyline {
        Polyline::new(points.iter().map(|(x, y)| Point::new(*x, *y)))
    }

    fn driven(x: f64, y: f64, remaining: f64) -> (f64, f64) {
        let twist = PURSUIT.drive(Vector::new(x, y), remaining, &mut false);
        (twist.linear.x, twist.angular.z)
    }

    #[test]
    fn it_looks_farther_ahead_when_it_is_faster() {
        for (speed, ahead) in [(0.0, 0.25), (0.5, 0.6), (-0.5, 0.6), (2.0, 0.7)] {
            assert_eq!(PURSUIT.lookahead(speed), ahead);
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
                (PURSUIT.regulated(curvature, remaining) - speed).abs() < 1e-9,
                "{curvature} {remaining}"
            );
        }
    }

    #[test]
    fn it_turns_on_the_spot_first_and_does_not_dither() {
        let mut rotating = false;
        let mut towards = |angle: f64| {
            let carrot = Vector::new(angle.cos(), angle.sin());
            PURSUIT.drive(carrot, 9.0, &mut rotating).linear.x > 0.0
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
        let far = PURSUIT
            .carrot(&corner, Point::new(0.5, 0.0), 0.5, 0.5)
            .unwrap();
        assert!((far - Point::new(1.1, 0.0)).norm() < 1e-9);
        let nearby = PURSUIT
            .carrot(&corner, Point::new(1.7, 0.0), 1.7, 0.5)
            .unwrap();
        assert!((nearby - Point::new(2.0, 0.0)).norm() < 0.15, "{nearby}");
    }

    #[test]
    fn the_end_of_the_line_is_the_last_carrot() {
        let short = line(&[(0.0, 0.0), (0.3, 0.0)]);
        assert_eq!(
            PURSUIT.carrot(&short, Point::origin(), 0.0, 0.5),
            Some(Point::new(0.3, 0.0))
        );
        assert_eq!(
            PURSUIT.carrot(&Polyline::default(), Point::origin(), 0.0, 0.5),
            None
        );
    }

    proptest! {
        #[test]
        fn it_never_drives_faster_than_it_may(x in -2.0..2.0, y in -2.0..2.0, remaining in 0.0..5.0, rotating: bool) {
            let twist = PURSUIT.drive(Vector::new(x, y), remaining, &mut rotating.clone());
            prop_assert!((0.0..=PURSUIT.max_speed).contains(&twist.linear.x));
            prop_assert!(twist.angular.z.abs() <= PURSUIT.max_turn);
        }

        #[test]
        fn it_comes_to_a_line_from_anywhere_near(y in -1.0..1.0, angle in -3.1..3.1) {
            let straight = line(&[(0.0, 0.0), (20.0, 0.0)]);
            let (mut pose, mut speed, mut rotating) = (heading(Point::new(1.0, y), angle), 0.0, false);
            for _ in 0..400 {
                let here = Point::from(pose.translation.vector);
                let along = straight.nearest(here).unwrap().along;
                let carrot = PURSUIT.carrot(&straight, here, along, speed).unwrap();
                let carrot = pose.inverse() * carrot;
                let twist = PURSUIT.drive(carrot.coords, 20.0 - along, &mut rotating);
                speed = twist.linear.x;
                let moved = pose * Point::new(speed * 0.05, 0.0);
                pose = heading(moved, asmotion_geometry::yaw(&pose) + twist.angular.z * 0.05);
            }
            prop_assert!(pose.translation.y.abs() < 0.02, "{pose}");
        }
    }
}
