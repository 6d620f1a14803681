//! Detects the end of motions: a motion begins with a command and ends when the measured values stay near the commanded
//! ones. (In the paper's listing, `idle` follows as soon as the command has been written.)

use asmotion_component::Time;
use asmotion_datum::Datum;

use super::IdleCriterion;

/// The current motion, if any.
pub(super) struct MotionMonitor {
    idle: IdleCriterion,
    pub goal: Option<Vec<f64>>,
    pub near_since: Option<Time>,
}

impl MotionMonitor {
    pub(super) fn new(idle: IdleCriterion) -> Self {
        Self {
            idle,
            goal: None,
            near_since: None,
        }
    }

    /// Returns whether commands go through this port.
    pub(super) fn is_commanded_by(&self, port: &str) -> bool {
        self.idle.commanded.0 == port
    }

    /// The port that commands go through.
    pub(super) fn commanded_port(&self) -> &str {
        &self.idle.commanded.0
    }

    /// A command begins a motion and ends the previous one.
    pub(super) fn command(&mut self, message: &Datum) {
        let goal = message.get(&self.idle.commanded.1);
        self.goal = Some(goal.map(|goal| numbers(&goal)).unwrap_or_default());
        self.near_since = None;
    }

    /// Called when the target cannot carry out the command: there is no motion that could end. Returns whether there was one.
    pub(super) fn abandon(&mut self) -> bool {
        self.goal.take().is_some()
    }

    /// Handles a sample. If it ends the motion, returns the distance from the goal.
    pub(super) fn measure(&mut self, port: &str, sample: &Datum, now: Time) -> Option<f64> {
        if self.idle.measured.0 != port {
            return None;
        }
        let measured = numbers(&*sample.get(&self.idle.measured.1)?);
        let error = distance(&measured, self.goal.as_ref()?);
        if error > self.idle.within || error.is_nan() {
            self.near_since = None;
            return None;
        }
        let since = *self.near_since.get_or_insert(now);
        if now.since(since) < self.idle.settle_time {
            return None;
        }
        self.goal = None;
        Some(error)
    }
}

/// The greatest absolute difference; infinite if the lengths differ.
fn distance(measured: &[f64], goal: &[f64]) -> f64 {
    if measured.len() != goal.len() {
        return f64::INFINITY;
    }
    let differences = measured
        .iter()
        .zip(goal)
        .map(|(is, shall)| (is - shall).abs());
    // not `f64::max`, which ignores NaN
    differences.fold(0.0, |greatest, next| {
        if next > greatest || next.is_nan() {
            next
        } else {
            greatest
        }
    })
}

/// A number, or the numbers of a list.
fn numbers(value: &Datum) -> Vec<f64> {
    match value.as_float() {
        Some(number) => vec![number],
        None => (0..value.count().unwrap_or(0))
            .filter_map(|index| value.element(index)?.as_float())
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn at(ms: u64) -> Time {
        Time::ZERO + Duration::from_millis(ms)
    }

    fn positions(values: &[f64]) -> Datum {
        let values = values.iter().copied().map(Datum::Float).collect();
        Datum::record([("position", Datum::List(values))])
    }

    fn motion() -> MotionMonitor {
        MotionMonitor::new(IdleCriterion {
            within: 0.01,
            commanded: ("commands".to_owned(), "position".to_owned()),
            measured: ("status".to_owned(), "position".to_owned()),
            settle_time: Duration::from_millis(200),
        })
    }

    #[test]
    fn it_ends_when_the_goal_has_been_near_for_long_enough() {
        let mut motion = motion();
        motion.command(&positions(&[1.0, 2.0]));
        for (ms, measured, ended) in [
            (100, [0.5, 2.0], false),
            (200, [1.0, 2.005], false),
            (300, [1.02, 2.0], false),
            (400, [1.0, 2.0], false),
            (599, [1.0, 2.0], false),
            (600, [1.0, 2.0], true),
            (700, [1.0, 2.0], false),
        ] {
            let end = motion.measure("status", &positions(&measured), at(ms));
            assert_eq!(end.is_some(), ended, "at {ms} ms");
        }
    }

    #[test]
    fn it_never_ends_at_what_is_no_number() {
        let mut motion = motion();
        motion.command(&positions(&[f64::NAN, 0.0]));
        for ms in [0, 500] {
            assert_eq!(
                motion.measure("status", &positions(&[0.0, 0.0]), at(ms)),
                None
            );
        }
    }
}
