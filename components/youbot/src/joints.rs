//! Simulated joints, which turn to their targets or report random values.

use asmotion_component::{Properties, Time};
use asmotion_messages::JointStatus;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::limits::Limits;

/// Joints with their targets and last status.
#[derive(Serialize, Deserialize)]
pub(crate) struct Joints {
    chance: ChaCha8Rng,
    goal: Vec<f64>,
    last: JointStatus,
    /// They have been held since the last status, and begin to turn with the next one.
    is_held: bool,
}

/// The motion of the joints, and the values that they report.
#[derive(Properties)]
pub(crate) struct Manner {
    /// Whether every reported value is random, instead of following the commands.
    pub random: bool,
    /// Speed of a turning joint.
    #[property(unit = "rad/s", range = 0.01..=10.0, default = 1.0)]
    pub speed: f64,
    /// Error bits to report, joint by joint; ten bits each.
    pub faults: Vec<u16>,
    #[property(flatten)]
    pub limits: Limits,
}

/// A goal for another number of joints.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{positions} positions for {joints} joints")]
pub(crate) struct WrongCount {
    joints: usize,
    positions: usize,
}

/// Mask of the ten error bits of a joint.
const ERROR_BITS: u16 = 0x3ff;

/// Largest random position of a joint, rad.
const FAR: f64 = 2.9;

impl Joints {
    /// Creates joints at position zero.
    pub(crate) fn new(count: usize, seed: u64) -> Self {
        Self {
            chance: ChaCha8Rng::seed_from_u64(seed),
            goal: vec![0.0; count],
            last: JointStatus {
                position: vec![0.0; count],
                ..JointStatus::default()
            },
            is_held: false,
        }
    }

    /// Sets the target positions, rad. A goal for another number of joints changes nothing.
    ///
    /// # Errors
    /// Both numbers.
    pub(crate) fn turn_to(&mut self, goal: &[f64]) -> Result<(), WrongCount> {
        if goal.len() != self.goal.len() {
            return Err(WrongCount {
                joints: self.goal.len(),
                positions: goal.len(),
            });
        }
        self.goal.copy_from_slice(goal);
        Ok(())
    }

    /// Ends the motion where the joints are: a driver that stops must not go on when it starts again.
    pub(crate) fn hold(&mut self) {
        self.goal.clone_from(&self.last.position);
        self.is_held = true;
    }

    pub(crate) fn are_resting(&self) -> bool {
        self.last.position == self.goal
    }

    /// Computes and returns the status at `now`. With and without `random`, the same number of random numbers is drawn for each
    /// joint.
    pub(crate) fn measure(&mut self, now: Time, manner: &Manner) -> &JointStatus {
        let stamp = asmotion_messages::Time::from_nanos(now.nanos());
        let passed = if std::mem::take(&mut self.is_held) {
            0.0
        } else {
            (stamp.as_nanos() - self.last.stamp.as_nanos()) as f64 * 1e-9
        };
        let step = manner.speed * passed;
        let next = JointStatus {
            stamp,
            ..JointStatus::default()
        };
        let before = std::mem::replace(&mut self.last, next);
        for (joint, (&goal, &from)) in self.goal.iter().zip(&before.position).enumerate() {
            let noise: f64 = self.chance.random_range(-1.0..1.0);
            let bits = self.chance.random_range(0..=ERROR_BITS);
            let (turn, flags) = if manner.random {
                (FAR * noise - from, bits)
            } else {
                let injected = manner.faults.get(joint).map_or(0, |bits| bits & ERROR_BITS);
                ((goal - from).clamp(-step, step), injected)
            };
            let velocity = turn / passed.max(1e-3);
            let effort = velocity.abs().min(2.0);
            self.last.position.push(from + turn);
            self.last.velocity.push(velocity);
            self.last.current.push(0.2 + 0.8 * effort + 0.05 * noise);
            self.last.temperature.push(35.0 + 5.0 * effort + noise);
            self.last.error_flags.push(flags);
        }
        &self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manner(random: bool) -> Manner {
        Manner {
            random,
            speed: 0.5,
            faults: vec![0, 0xffff],
            limits: Limits::default(),
        }
    }

    /// The status in 20 cycles of 100 ms.
    fn stream(seed: u64, random: bool) -> Vec<JointStatus> {
        let mut joints = Joints::new(2, seed);
        joints.turn_to(&[0.12, -1.0]).unwrap();
        let mut stream = Vec::new();
        for cycle in 1..=20 {
            let now = Time::from_nanos(cycle * 100_000_000);
            stream.push(joints.measure(now, &manner(random)).clone());
        }
        stream
    }

    #[test]
    fn it_turns_no_faster_than_it_can_and_stops_at_the_goal() {
        let stream = stream(1, false);
        let first: Vec<f64> = stream.iter().map(|status| status.position[0]).collect();
        assert!((first[0] - 0.05).abs() < 1e-12);
        assert_eq!((first[2], first[19]), (0.12, 0.12));
        assert!((stream[19].position[1] + 1.0).abs() < 1e-9);
        assert_eq!(stream[19].velocity[0], 0.0);
    }

    #[test]
    fn it_reports_the_faults_it_is_given_ten_bits_each() {
        for status in stream(1, false) {
            assert_eq!(status.error_flags, [0, ERROR_BITS]);
        }
    }

    #[test]
    fn its_values_are_plausible_and_its_seeds_decide() {
        for random in [false, true] {
            let one = stream(7, random);
            assert_eq!(one, stream(7, random));
            assert_ne!(one, stream(8, random));
            for status in one {
                assert!(status.position.iter().all(|rad| rad.abs() <= FAR));
                assert!(
                    status
                        .current
                        .iter()
                        .all(|ampere| (0.1..2.0).contains(ampere))
                );
                assert!(
                    status
                        .temperature
                        .iter()
                        .all(|celsius| (30.0..50.0).contains(celsius))
                );
                assert!(status.error_flags.iter().all(|bits| *bits <= ERROR_BITS));
            }
        }
    }

    #[test]
    fn a_goal_for_another_number_of_joints_is_none() {
        let mut joints = Joints::new(2, 1);
        let refused = joints.turn_to(&[1.0; 5]).unwrap_err();
        assert_eq!(refused.to_string(), "5 positions for 2 joints");
        joints.measure(Time::from_nanos(100_000_000), &manner(false));
        assert!(joints.are_resting());
    }
}
