//! Contact as the encoders show it: a wheel that is commanded to turn and does not.

use std::time::Duration;

use asmotion_component::{Properties, Time};
use serde::{Deserialize, Serialize};

use crate::drive::Velocity;

/// Limits from which a wheel counts as stalled.
#[derive(Debug, Clone, Copy, PartialEq, Properties)]
pub struct StallLimits {
    /// Time for which a wheel turns at less than half of the commanded speed until it counts as stalled. Must exceed the
    /// delay between a command and its effect on the encoders.
    #[property(range = "20ms"..="10s", default = "100ms")]
    pub stall_s: Duration,
    /// Commanded speed of the rim of a wheel below which the wheel need not turn.
    #[property(unit = "m/s", range = 0.001..=10.0, default = 0.05)]
    pub stall_speed: f64,
}

/// Compares the commanded with the measured speed of one wheel.
///
/// The measured speed is compared with the least commanded one since it was last sufficient, so that neither a ramp nor the
/// delay of the encoders counts as a stall.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct WheelWatch {
    /// Least speed commanded since the wheel last turned as it should, m/s with its sign, and that time.
    short: Option<(f64, Time)>,
}

impl WheelWatch {
    /// Compares the speeds of the rim, m/s, at a reading of the encoders. Returns whether the wheel is stalled.
    pub fn update(
        &mut self,
        now: Time,
        commanded: f64,
        measured: f64,
        limits: &StallLimits,
    ) -> bool {
        if commanded.abs() < limits.stall_speed {
            self.short = None;
            return false;
        }
        let (least, since) = match self.short {
            Some((least, since)) if least * commanded > 0.0 => {
                (commanded.signum() * least.abs().min(commanded.abs()), since)
            }
            Some(_) | None => (commanded, now),
        };
        let turns = measured * least.signum() >= least.abs() / 2.0;
        let (least, since) = if turns {
            (commanded, now)
        } else {
            (least, since)
        };
        self.short = Some((least, since));
        now.since(since) >= limits.stall_s
    }
}

/// A contact that holds the robot: commands in the direction in which it drove are refused until another one arrives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Velocity that was commanded when the wheels stalled.
    velocity: Velocity,
}

impl Contact {
    /// The contact of a robot with this commanded velocity.
    pub fn new(velocity: Velocity) -> Self {
        Self { velocity }
    }

    /// Returns whether a command pushes against the obstacle again. A robot that was turning on the spot, slower than
    /// `standing` m/s, may not turn on.
    pub fn holds(&self, command: Velocity, standing: f64) -> bool {
        if self.velocity.speed.abs() >= standing {
            self.velocity.speed * command.speed > 0.0
        } else {
            self.velocity.turn * command.turn > 0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: StallLimits = StallLimits {
        stall_s: Duration::from_millis(100),
        stall_speed: 0.05,
    };

    /// Compares the speeds every 20 ms; returns the first reading at which the wheel is stalled.
    fn stalled(speeds: impl IntoIterator<Item = (f64, f64)>) -> Option<usize> {
        let mut watch = WheelWatch::default();
        speeds
            .into_iter()
            .enumerate()
            .position(|(reading, (commanded, measured))| {
                let now = Time::from_nanos(reading as i64 * 20_000_000);
                watch.update(now, commanded, measured, &LIMITS)
            })
    }

    #[test]
    fn a_wheel_that_stops_against_its_command_is_stalled_after_the_time() {
        for sign in [1.0, -1.0] {
            let rolls = [(0.5 * sign, 0.5 * sign); 10];
            let stands = [(0.5 * sign, 0.0); 10];
            assert_eq!(stalled(rolls.into_iter().chain(stands)), Some(14));
        }
        let pushed_back = [(0.5, -0.5); 10];
        assert_eq!(stalled(pushed_back), Some(5));
    }

    #[test]
    fn a_braking_wheel_that_stands_already_is_stalled() {
        let braking = (0..25).map(|reading| (0.5 - 0.02 * f64::from(reading), 0.0));
        assert_eq!(stalled(braking), Some(5));
    }

    #[test]
    fn neither_a_ramp_nor_a_delay_is_a_stall() {
        for acceleration in [0.1, 1.0, 5.0, 50.0] {
            for delay in 0..4 {
                let speed =
                    |reading: i32| (acceleration * 0.02 * f64::from(reading.max(0))).min(2.0);
                let up = (0..200).map(|reading| (speed(reading), speed(reading - delay)));
                let down =
                    (0..200).map(|reading| (speed(100 - reading), speed(100 - reading + delay)));
                assert_eq!(stalled(up), None, "{acceleration} m/s², {delay} readings");
                assert_eq!(stalled(down), None);
            }
        }
        let reversing = (0..200).map(|reading| {
            let speed = |reading: i32| 1.0 - 0.02 * f64::from(reading.max(0));
            (speed(reading), speed(reading - 3))
        });
        assert_eq!(stalled(reversing), None);
    }

    #[test]
    fn a_slow_command_expects_nothing() {
        assert_eq!(stalled([(0.04, 0.0); 100]), None);
        let now_and_then = (0..100).map(|reading| (0.5, if reading % 4 == 0 { 0.3 } else { 0.0 }));
        assert_eq!(stalled(now_and_then), None);
    }

    #[test]
    fn it_holds_what_pushes_and_nothing_else() {
        let velocity = |speed, turn| Velocity { speed, turn };
        let ahead = Contact::new(velocity(0.3, -0.5));
        for (command, holds) in [
            (velocity(0.1, 0.0), true),
            (velocity(0.5, 1.0), true),
            (velocity(0.0, 0.0), false),
            (velocity(0.0, 1.0), false),
            (velocity(-0.1, 0.5), false),
        ] {
            assert_eq!(ahead.holds(command, 0.05), holds, "{command:?}");
        }
        let turning = Contact::new(velocity(0.01, -0.5));
        assert!(turning.holds(velocity(0.0, -0.2), 0.05));
        assert!(!turning.holds(velocity(0.2, 0.0), 0.05));
    }
}
