//! Expectations during a run: when each begins and ends, and whether it holds.

use std::time::Duration;

use asmotion_component::Time;

/// Kind of a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RequirementKind {
    Eventually,
    Always,
    Never,
}

/// An expectation; conditions are positions in the list of conditions.
#[derive(Clone, Debug)]
pub(super) struct WatchedExpectation {
    pub kind: RequirementKind,
    pub condition: usize,
    pub after: Option<usize>,
    pub until: Option<usize>,
    pub within: Option<Duration>,
    /// Start of the requirement under way.
    began: Option<Time>,
    /// Whether the `after` condition holds.
    was_after: bool,
    /// Whether it has been decided at least once.
    checked: bool,
    /// The first violation; nothing is checked after it.
    pub failure: Option<BrokenExpectation>,
}

/// The violation of an expectation.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum BrokenExpectation {
    /// The condition did not become true in time.
    TooLate { began: Time, at: Time },
    /// The requirement ended before the condition became true.
    Ended { began: Time, at: Time },
    /// The condition does not hold, or holds and must not.
    Violated { began: Time, at: Time },
    /// It never began.
    NeverBegan,
    /// It began, and nothing was ever decided: its values are unknown, or the time was too short.
    NeverChecked,
}

impl WatchedExpectation {
    pub(super) fn new(
        kind: RequirementKind,
        condition: usize,
        (after, until): (Option<usize>, Option<usize>),
        within: Option<Duration>,
    ) -> Self {
        Self {
            kind,
            condition,
            after,
            until,
            within,
            began: None,
            was_after: false,
            checked: false,
            failure: None,
        }
    }

    /// Begins the requirement at the start of the run, unless a condition begins it.
    pub(super) fn start(&mut self, truths: &[Option<bool>]) {
        if self.after.is_none() {
            self.began = Some(Time::ZERO);
        }
        self.decide(Time::ZERO, truths);
    }

    /// Lets time pass up to an instant, without that instant: the truths are those before it.
    pub(super) fn pass(&mut self, to: Time, truths: &[Option<bool>]) {
        let (Some(began), None) = (self.began, &self.failure) else {
            return;
        };
        let Some(deadline) = self.within.map(|within| began + within) else {
            return;
        };
        if deadline >= to {
            return;
        }
        match self.kind {
            RequirementKind::Eventually => {
                self.fail(BrokenExpectation::TooLate {
                    began,
                    at: deadline,
                });
            }
            RequirementKind::Always | RequirementKind::Never => self.hold(began, deadline, truths),
        }
    }

    /// Takes the truths at an instant.
    pub(super) fn decide(&mut self, at: Time, truths: &[Option<bool>]) {
        if self.failure.is_some() {
            return;
        }
        let is_true =
            |condition: Option<usize>| condition.is_some_and(|it| truths[it] == Some(true));
        let is_after = is_true(self.after);
        if is_after && !self.was_after && self.began.is_none() {
            self.began = Some(at);
        }
        self.was_after = is_after;
        let Some(began) = self.began else {
            return;
        };
        let ends = is_true(self.until);
        match self.kind {
            RequirementKind::Eventually => {
                if is_true(Some(self.condition)) {
                    self.checked = true;
                    self.began = None;
                } else if ends {
                    self.fail(BrokenExpectation::Ended { began, at });
                }
            }
            RequirementKind::Always | RequirementKind::Never => {
                if ends {
                    self.began = None;
                } else if at >= began + self.within.unwrap_or_default() {
                    self.hold(began, at, truths);
                }
            }
        }
    }

    /// Decides what is open at the end of the run.
    pub(super) fn finish(&mut self, at: Time) {
        if self.failure.is_some() {
            return;
        }
        match (self.kind, self.began) {
            (RequirementKind::Eventually, Some(began)) => {
                self.fail(BrokenExpectation::Ended { began, at });
            }
            (_, None) if !self.checked && !self.has_begun() => {
                self.fail(BrokenExpectation::NeverBegan)
            }
            (_, _) if !self.checked => self.fail(BrokenExpectation::NeverChecked),
            (_, _) => {}
        }
    }

    fn has_begun(&self) -> bool {
        self.began.is_some() || self.after.is_none()
    }

    /// Checks that the condition holds, or does not hold if it must not.
    fn hold(&mut self, began: Time, at: Time, truths: &[Option<bool>]) {
        let forbidden = self.kind == RequirementKind::Never;
        // what has not happened at all has not been true
        self.checked |= forbidden || truths[self.condition].is_some();
        if truths[self.condition] == Some(forbidden) {
            self.fail(BrokenExpectation::Violated { began, at });
        }
    }

    fn fail(&mut self, violation: BrokenExpectation) {
        self.failure = Some(violation);
        self.began = None;
    }
}
