//! Observes a run: the values of operands, the truth of conditions, and what follows from them.

use std::time::Duration;

use asmotion_component::Time;
use asmotion_runtime::Event;

use super::condition::{ObservedValue, RunCondition};
use super::expectation::WatchedExpectation;
use super::operand::Operand;

/// The trigger of an action.
#[derive(Clone, Debug)]
pub(super) enum ActionTrigger {
    At(Time),
    /// Position of a condition, and the delay after it.
    When(usize, Duration),
}

/// Observes a run until its end condition holds.
#[derive(Debug, Default)]
pub(super) struct RunMonitor {
    pub operands: Vec<Operand>,
    pub values: Vec<Option<ObservedValue>>,
    pub conditions: Vec<RunCondition>,
    /// Truths of the conditions; `None` if not known yet.
    pub truths: Vec<Option<bool>>,
    pub expectations: Vec<WatchedExpectation>,
    /// Values of an expectation's operands when it failed.
    pub evidence: Vec<Option<String>>,
    pub triggers: Vec<ActionTrigger>,
    /// Times of the actions, once they are known.
    pub due: Vec<Option<Time>>,
    /// Position of the end condition.
    pub end: Option<usize>,
    /// Set once all components have been started.
    pub started: bool,
    /// Time at which the end condition became true, or at which the run ended. Events of this instant still count: a step
    /// that ends the mission sends its messages after its updates.
    pub ended: Option<Time>,
    /// Set once everything open has been decided.
    finished: bool,
}

impl RunMonitor {
    /// Starts with the values that the startup of the components has left.
    pub(super) fn start(&mut self) {
        self.started = true;
        self.evaluate();
        self.evidence = vec![None; self.expectations.len()];
        self.due = vec![None; self.triggers.len()];
        for expectation in &mut self.expectations {
            expectation.start(&self.truths);
        }
        self.collect_evidence();
        self.trigger(Time::ZERO);
    }

    /// Takes an event of the run.
    pub(super) fn observe(&mut self, at: Time, event: &Event<'_>) {
        if self.finished || self.ended.is_some_and(|ended| at > ended) {
            return;
        }
        let mut is_new = false;
        let before = self.values.clone();
        for (operand, value) in self.operands.iter_mut().zip(&mut self.values) {
            if let Some(new) = operand.observation.update(at, event) {
                is_new |= value.as_ref() != Some(&new);
                *value = Some(new);
            }
        }
        if !is_new || !self.started {
            return;
        }
        let after = std::mem::replace(&mut self.values, before);
        self.pass(at);
        self.values = after;
        self.evaluate();
        for expectation in &mut self.expectations {
            expectation.decide(at, &self.truths);
        }
        self.collect_evidence();
        if self.ended.is_none() {
            self.trigger(at);
        }
    }

    /// Decides what is open at the end of the run. Later events are those of the shutdown.
    pub(super) fn finish(&mut self, now: Time) {
        if !self.started {
            self.start();
        }
        self.finished = true;
        let at = *self.ended.get_or_insert(now);
        self.pass(at);
        for expectation in &mut self.expectations {
            expectation.decide(at, &self.truths);
            expectation.finish(at);
        }
        self.collect_evidence();
    }

    fn pass(&mut self, to: Time) {
        for expectation in &mut self.expectations {
            expectation.pass(to, &self.truths);
        }
        self.collect_evidence();
    }

    fn evaluate(&mut self) {
        let values = &self.values;
        let truths = self.conditions.iter().map(|it| it.evaluate(values));
        self.truths = truths.collect();
    }

    /// Sets the times of actions whose conditions hold, and ends the run.
    fn trigger(&mut self, now: Time) {
        let is_true = |condition: usize| self.truths[condition] == Some(true);
        for (trigger, due) in self.triggers.iter().zip(&mut self.due) {
            match trigger {
                ActionTrigger::At(time) => *due = Some(*time),
                ActionTrigger::When(condition, delay) if due.is_none() && is_true(*condition) => {
                    *due = Some(now + *delay);
                }
                ActionTrigger::When(..) => {}
            }
        }
        if self.end.is_some_and(is_true) {
            self.ended = Some(now);
        }
    }

    /// Keeps the values of expectations that have just failed.
    fn collect_evidence(&mut self) {
        for (index, expectation) in self.expectations.iter().enumerate() {
            if expectation.failure.is_some() && self.evidence[index].is_none() {
                self.evidence[index] = Some(self.shown(expectation.condition));
            }
        }
    }

    /// The values of a condition's operands: `mode = FOLLOWING, speed(World.truth) = 0.31`.
    fn shown(&self, condition: usize) -> String {
        let operands = self.conditions[condition].operands().into_iter();
        let shown = operands.map(|operand| {
            let name = &self.operands[operand].name;
            match &self.values[operand] {
                Some(value) => format!("{name} = {value}"),
                None => format!("{name} has no value"),
            }
        });
        shown.collect::<Vec<_>>().join(", ")
    }
}
