//! The differential drive: converts between body velocity and wheel speeds, within the limits of the motors.

use asmotion_component::Properties;
use asmotion_geometry::DECELERATION;
use asmotion_messages::WheelSpeeds;
use serde::{Deserialize, Serialize};

/// Geometry of a differential drive.
#[derive(Debug, Clone, Copy, PartialEq, Properties, Serialize, Deserialize)]
pub struct DifferentialDrive {
    /// Radius of the driven wheels.
    #[property(unit = "m", range = 0.001..=1.0, default = 0.05)]
    pub wheel_radius_m: f64,
    /// Distance between the contact points of the two driven wheels.
    #[property(unit = "m", range = 0.01..=5.0, default = 0.3)]
    pub track_m: f64,
}

/// The velocity of a body that rolls without sliding sideways.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Velocity {
    /// Forward speed, m/s.
    pub speed: f64,
    /// Turn rate, rad/s counter-clockwise.
    pub turn: f64,
}

/// Limits of the rover. A command beyond them is scaled as a whole: same curve, driven more slowly.
#[derive(Debug, Clone, Copy, PartialEq, Properties)]
pub struct DriveLimits {
    /// Speed limit, forward and backward.
    #[property(unit = "m/s", range = 0.0..=10.0, default = 0.6)]
    pub max_speed: f64,
    /// Turn rate limit, in either direction.
    #[property(unit = "rad/s", range = 0.0..=20.0, default = 1.5)]
    pub max_turn: f64,
    /// Limit of acceleration and braking.
    #[property(unit = "m/s²", range = 0.01..=50.0, default = DECELERATION)]
    pub max_acceleration: f64,
    /// Limit of the change of the turn rate.
    #[property(unit = "rad/s²", range = 0.01..=100.0, default = 3.0)]
    pub max_turn_acceleration: f64,
    /// Speed limit of either wheel's motor.
    #[property(unit = "rad/s", range = 0.0..=1000.0, default = 20.0)]
    pub max_wheel_speed: f64,
}

impl DifferentialDrive {
    /// Wheel speeds, rad/s, for a velocity of the body.
    pub fn wheels(&self, velocity: Velocity) -> WheelSpeeds {
        let rim = velocity.turn * self.track_m / 2.0;
        WheelSpeeds {
            left: (velocity.speed - rim) / self.wheel_radius_m,
            right: (velocity.speed + rim) / self.wheel_radius_m,
        }
    }

    /// Velocity of the body for wheel speeds, rad/s. Works for angles as for speeds:
    /// rad in gives metres and radians out.
    pub fn body(&self, left: f64, right: f64) -> Velocity {
        Velocity {
            speed: (left + right) / 2.0 * self.wheel_radius_m,
            turn: (right - left) / self.track_m * self.wheel_radius_m,
        }
    }
}

impl DriveLimits {
    /// The velocity to drive for the next `dt` seconds on the way from `current` to `target`.
    ///
    /// A command beyond the speed limits is scaled as a whole, so that the robot follows the commanded curve more
    /// slowly instead of another curve.
    pub fn toward(
        &self,
        drive: &DifferentialDrive,
        current: Velocity,
        target: Velocity,
        dt: f64,
    ) -> Velocity {
        let target = self.limit_wheel_speeds(drive, target);
        Velocity {
            speed: step(current.speed, target.speed, self.max_acceleration * dt),
            turn: step(current.turn, target.turn, self.max_turn_acceleration * dt),
        }
    }

    fn limit_wheel_speeds(&self, drive: &DifferentialDrive, target: Velocity) -> Velocity {
        if !(target.speed.is_finite() && target.turn.is_finite()) {
            return Velocity::default(); // ignores a command that is not finite
        }
        let wheels = drive.wheels(target);
        let scale = [
            (target.speed, self.max_speed),
            (target.turn, self.max_turn),
            (wheels.left, self.max_wheel_speed),
            (wheels.right, self.max_wheel_speed),
        ]
        .into_iter()
        .filter(|(value, limit)| value.abs() > *limit)
        .map(|(value, limit)| limit / value.abs())
        .fold(1.0, f64::min);
        Velocity {
            speed: target.speed * scale,
            turn: target.turn * scale,
        }
    }
}

/// Moves `current` towards `target` by at most `most`.
fn step(current: f64, wanted: f64, most: f64) -> f64 {
    current + (wanted - current).max(-most).min(most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DRIVE: DifferentialDrive = DifferentialDrive {
        wheel_radius_m: 0.05,
        track_m: 0.3,
    };

    const LIMITS: DriveLimits = DriveLimits {
        max_speed: 0.6,
        max_turn: 1.5,
        max_acceleration: 1.0,
        max_turn_acceleration: 3.0,
        max_wheel_speed: 10.0,
    };

    fn velocity(speed: f64, turn: f64) -> Velocity {
        Velocity { speed, turn }
    }

    #[test]
    fn it_turns_the_wheels_as_the_body_moves() {
        for (speed, turn, left, right) in [
            (0.5, 0.0, 10.0, 10.0),    // straight on
            (0.0, 1.0, -3.0, 3.0),     // left on the spot
            (0.15, 1.0, 0.0, 6.0),     // about the left wheel
            (-0.5, 0.0, -10.0, -10.0), // backwards
        ] {
            let wheels = DRIVE.wheels(velocity(speed, turn));
            assert!((wheels.left - left).abs() < 1e-9 && (wheels.right - right).abs() < 1e-9);
        }
    }

    #[test]
    fn it_stops_for_a_command_that_is_no_number() {
        for target in [velocity(f64::NAN, 0.0), velocity(0.1, f64::INFINITY)] {
            let next = LIMITS.toward(&DRIVE, velocity(0.01, 0.0), target, 0.02);
            assert_eq!(next, Velocity::default());
        }
    }

    proptest! {
        #[test]
        fn body_and_wheels_agree(speed in -2.0..2.0, turn in -4.0..4.0) {
            let wheels = DRIVE.wheels(velocity(speed, turn));
            let body = DRIVE.body(wheels.left, wheels.right);
            prop_assert!((body.speed - speed).abs() < 1e-12 && (body.turn - turn).abs() < 1e-12);
        }

        #[test]
        fn it_keeps_every_limit(speed in -5.0..5.0, turn in -9.0..9.0, dt in 0.001..0.1) {
            let mut now = Velocity::default();
            for _ in 0..2000 {
                let next = LIMITS.toward(&DRIVE, now, velocity(speed, turn), dt);
                let wheels = DRIVE.wheels(next);
                let few = 1.0 + 1e-9;
                prop_assert!((next.speed - now.speed).abs() <= LIMITS.max_acceleration * dt * few);
                prop_assert!((next.turn - now.turn).abs() <= LIMITS.max_turn_acceleration * dt * few);
                prop_assert!(next.speed.abs() <= LIMITS.max_speed * few && next.turn.abs() <= LIMITS.max_turn * few);
                prop_assert!(wheels.left.abs().max(wheels.right.abs()) <= LIMITS.max_wheel_speed * few);
                now = next;
            }
            // in the end, the curve is the commanded one
            prop_assert!((now.speed * turn - now.turn * speed).abs() < 1e-9);
        }
    }
}
