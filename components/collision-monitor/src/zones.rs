//! The decision: how much of a command leaves room to brake.

use asmotion_component::Properties;
use asmotion_geometry::{Arc, Brakes, DECELERATION, Point};
use serde::{Deserialize, Serialize};

/// The robot's size and brakes, and the zones around it.
#[derive(Debug, Clone, Copy, PartialEq, Properties)]
pub struct Zones {
    /// Radius of the disc that covers the robot, about the midpoint between the driven wheels.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.2)]
    pub robot_radius_m: f64,
    /// Distance between the robot's disc and an obstacle at which the robot stands at the latest.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.02)]
    pub stop_margin_m: f64,
    /// Depth within the robot's disc from which a point of the scan shows a contact; must exceed the error of the laser.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.05)]
    pub contact_depth_m: f64,
    /// Width of the zone beside the swept area in which an obstacle slows the robot down to `slow_speed`.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.2)]
    pub slow_margin_m: f64,
    /// Lower bound of the speed that an obstacle in the slow zone leaves.
    #[property(unit = "m/s", range = 0.0..=10.0, default = 0.6)]
    pub slow_speed: f64,
    /// Deceleration that the rover can brake with; must not exceed the rover's `max_acceleration`.
    #[property(unit = "m/s²", range = 0.01..=50.0, default = DECELERATION)]
    pub deceleration: f64,
    /// Time between a scan and the beginning of braking.
    #[property(unit = "s", range = 0.0..=10.0, default = 0.2)]
    pub reaction_s: f64,
}

/// Velocity of a body that moves in the plane without sliding sideways.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PlanarVelocity {
    /// Forward speed, m/s.
    pub speed: f64,
    /// Turn rate, rad/s counter-clockwise.
    pub turn: f64,
}

/// The velocity that a command leaves, and the reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// The command may be driven.
    Pass(PlanarVelocity),
    /// The command is driven along the same curve, but more slowly.
    Slow(PlanarVelocity),
    /// The robot brakes to a stop along the curve that it drives.
    Stop(PlanarVelocity),
}

/// Speed in m/s up to which the robot counts as standing.
const STANDING: f64 = 0.02;

/// Number of points of a scan that show a contact; fewer may be errors of the laser.
const CONTACT_POINTS: usize = 3;

/// Time in s for which a command acts before the next one does.
const COMMANDED: f64 = 0.1;

impl PlanarVelocity {
    /// Returns whether both numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.speed.is_finite() && self.turn.is_finite()
    }
}

impl Verdict {
    /// The velocity to drive.
    pub fn velocity(&self) -> PlanarVelocity {
        match self {
            Self::Pass(velocity) | Self::Slow(velocity) | Self::Stop(velocity) => *velocity,
        }
    }
}

impl Zones {
    /// Judges a command for a robot with this velocity; `points` are obstacles in the base frame, m.
    pub fn judge(
        &self,
        command: PlanarVelocity,
        robot: PlanarVelocity,
        points: &[Point],
    ) -> Verdict {
        let goes_on = robot.speed * command.speed >= 0.0;
        if let Some(arc) = Arc::of(robot.speed, robot.turn)
            && goes_on
            && robot.speed.abs() > STANDING
        {
            let free = self.free(&arc, points, self.stop_margin_m);
            if self.brakes().distance(robot.speed) > free {
                return Verdict::Stop(self.braking(&arc, robot));
            }
        }
        // a round robot that turns on the spot sweeps nothing
        let Some(arc) = Arc::of(command.speed, command.turn) else {
            return Verdict::Pass(command);
        };
        let allowed = self.allowed(&arc, points);
        if command.speed.abs() <= allowed {
            return Verdict::Pass(command);
        }
        let speed = allowed.copysign(command.speed);
        // the curve stays the same also while the robot is faster than it may be
        let rolling = if goes_on { self.rolling(robot) } else { 0.0 };
        let along = speed.abs().max(rolling).min(command.speed.abs());
        let turn = command.turn * along / command.speed.abs();
        let velocity = PlanarVelocity { speed, turn };
        if allowed > 0.0 {
            Verdict::Slow(velocity)
        } else {
            Verdict::Stop(velocity)
        }
    }

    /// Returns whether a scan ends within the robot: something touches it. `points` are in the base frame, m.
    pub fn is_touched(&self, points: &[Point]) -> bool {
        let inside = self.robot_radius_m - self.contact_depth_m;
        let within = points.iter().filter(|point| point.coords.norm() < inside);
        within.take(CONTACT_POINTS).count() == CONTACT_POINTS
    }

    fn brakes(&self) -> Brakes {
        Brakes {
            deceleration: self.deceleration,
            reaction_s: self.reaction_s,
        }
    }

    /// Distance in m that the robot's disc with a margin can move along the arc.
    fn free(&self, arc: &Arc, points: &[Point], margin: f64) -> f64 {
        arc.free(points.iter().copied(), self.robot_radius_m + margin)
    }

    /// The highest speed along the arc, m/s.
    fn allowed(&self, arc: &Arc, points: &[Point]) -> f64 {
        let brakes = self.brakes();
        let stoppable = brakes.speed(self.free(arc, points, self.stop_margin_m));
        let wide = self.slow_margin_m.max(self.stop_margin_m);
        let slow = brakes.speed(self.free(arc, points, wide));
        stoppable.min(slow.max(self.slow_speed))
    }

    /// Speed of a braking robot when the next command arrives, m/s, not negative.
    fn rolling(&self, robot: PlanarVelocity) -> f64 {
        (robot.speed.abs() - self.deceleration * COMMANDED).max(0.0)
    }

    /// The command that brakes along the curve the robot drives.
    fn braking(&self, arc: &Arc, robot: PlanarVelocity) -> PlanarVelocity {
        let rolling = self.rolling(robot).copysign(robot.speed);
        PlanarVelocity {
            speed: 0.0,
            turn: arc.curvature() * rolling,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ZONES: Zones = Zones {
        robot_radius_m: 0.2,
        stop_margin_m: 0.02,
        contact_depth_m: 0.05,
        slow_margin_m: 0.2,
        slow_speed: 0.6,
        deceleration: 1.0,
        reaction_s: 0.2,
    };

    fn velocity(speed: f64, turn: f64) -> PlanarVelocity {
        PlanarVelocity { speed, turn }
    }

    #[test]
    fn a_free_command_passes() {
        let behind = [Point::new(-0.3, 0.0), Point::new(1.0, 0.5)];
        let command = velocity(2.0, 0.0);
        let verdict = ZONES.judge(command, command, &behind);
        assert_eq!(verdict, Verdict::Pass(command));
        // what touches the robot does not hold it
        let (back, ahead) = (velocity(-0.5, 0.0), [Point::new(0.15, 0.0)]);
        let verdict = ZONES.judge(back, velocity(0.0, 0.0), &ahead);
        assert_eq!(verdict, Verdict::Pass(back));
        let spot = velocity(0.0, 1.0);
        assert_eq!(ZONES.judge(spot, spot, &ahead), Verdict::Pass(spot));
    }

    #[test]
    fn an_obstacle_ahead_slows_the_robot_down_and_one_within_the_stopping_distance_stops_it() {
        let ahead = [Point::new(1.72, 0.0)];
        let command = velocity(2.0, 0.0);
        let Verdict::Slow(slow) = ZONES.judge(command, velocity(0.5, 0.0), &ahead) else {
            panic!("it is slowed down");
        };
        // 1.32 m are left beyond radius and slow zone
        assert!((ZONES.brakes().distance(slow.speed) - 1.32).abs() < 1e-9);
        let verdict = ZONES.judge(command, velocity(1.9, 0.0), &ahead);
        assert_eq!(verdict, Verdict::Stop(velocity(0.0, 0.0)));
        let touching = [Point::new(0.2, 0.0)];
        let verdict = ZONES.judge(command, velocity(0.0, 0.0), &touching);
        assert_eq!(verdict, Verdict::Stop(velocity(0.0, 0.0)));
    }

    #[test]
    fn three_points_within_the_disc_are_a_contact() {
        let inside = [0.14, -0.14, 0.0].map(|x| Point::new(x, 0.0));
        assert!(ZONES.is_touched(&inside));
        assert!(!ZONES.is_touched(&inside[..2]));
        assert!(!ZONES.is_touched(&[Point::new(0.16, 0.0); 9]));
    }

    #[test]
    fn an_obstacle_beside_the_way_slows_the_robot_down() {
        let beside = [Point::new(0.3, 0.3)];
        let verdict = ZONES.judge(velocity(2.0, 0.0), velocity(0.6, 0.0), &beside);
        assert_eq!(verdict, Verdict::Slow(velocity(ZONES.slow_speed, 0.0)));
    }

    proptest! {
        #[test]
        fn it_is_never_faster_than_it_can_stop(
            speed in prop_oneof![-3.0..-0.05, 0.05..3.0],
            turn in -2.0..2.0,
            points in prop::collection::vec((-3.0..3.0, -3.0..3.0), 1..20),
        ) {
            let points: Vec<Point> = points.into_iter().map(|(x, y)| Point::new(x, y)).collect();
            let command = velocity(speed, turn);
            let passed = ZONES.judge(command, velocity(0.0, 0.0), &points).velocity();
            let arc = Arc::of(speed, turn).unwrap();
            let free = arc.free(points, ZONES.robot_radius_m);
            prop_assert!(passed.speed.abs() <= speed.abs());
            prop_assert!(ZONES.brakes().distance(passed.speed) <= free + 1e-9);
            prop_assert!(passed.speed.abs() <= (2.0 * ZONES.deceleration * free).sqrt() + 1e-9);
        }
    }
}
