//! Bounded response: what has to follow a cause within a time.

use crate::ctl::Ctl;
use crate::ltl::Ltl;
use crate::past::{Conditions, Letter};
use crate::safety;
use std::collections::BTreeSet;

/// The response parts of a formula, such as `p → F q` in `G(p → F q)`: after a position with the cause, the goal has to hold
/// within a time. Memory is bounded: the goal answers all causes before it, so only the earliest open one is remembered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResponseMonitor {
    conditions: Conditions,
    responses: Vec<DueResponse>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct DueResponse {
    /// The condition that causes it.
    cause: usize,
    goal: usize,
    /// Only the first position can be a cause.
    is_first_only: bool,
}

/// State of a monitor of responses in a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResponseState {
    /// For each response, the time of the earliest cause without a response.
    pub open: Vec<Option<i64>>,
    /// Memory of the past operators.
    pub memory: Vec<bool>,
    /// The current position is the first one.
    pub is_first: bool,
}

impl ResponseMonitor {
    /// Compiles a formula of LTL: a conjunction of `G(p → F q)`, `G(p → (r U q))`, `G(F q)`, `F q`, `r U q` and other formulas,
    /// which are ignored, where `p` and `q` are not about the future. `None` if it has no such part.
    pub fn of_ltl(formula: &Ltl) -> Option<Self> {
        let mut found = Self {
            conditions: Conditions::default(),
            responses: Vec::new(),
        };
        found.add(formula);
        (!found.responses.is_empty()).then_some(found)
    }

    /// Compiles a formula of CTL, such as `AG(p → AF q)`. `None` as for [`Self::of_ltl`].
    pub fn of_ctl(formula: &Ctl) -> Option<Self> {
        Self::of_ltl(&safety::linear(formula, true, &mut BTreeSet::new()))
    }

    /// Returns the state before the first position.
    pub fn begin(&self) -> ResponseState {
        ResponseState {
            open: vec![None; self.responses.len()],
            memory: self.conditions.memory(),
            is_first: true,
        }
    }

    /// Returns `true` if a state can be one of this monitor.
    pub fn fits(&self, state: &ResponseState) -> bool {
        state.open.len() == self.responses.len()
            && state.memory.len() == self.conditions.memory().len()
    }

    /// Notes what is known about the current position at a time. Returns `true` if a response is missing whose time, `within`, has
    /// passed; it is then no longer waited for.
    pub fn note(
        &self,
        state: &mut ResponseState,
        now: i64,
        within: i64,
        letter: Letter<'_>,
    ) -> bool {
        let values = self.conditions.values(&state.memory, letter);
        let mut is_late = false;
        for (response, open) in self.responses.iter().zip(&mut state.open) {
            let holds = |condition| self.conditions.value(condition, &values, letter);
            let goal = holds(response.goal);
            let age = open.map(|since| now.saturating_sub(since));
            if goal == Some(true) {
                is_late |= age.is_some_and(|age| age > within);
                *open = None;
                continue;
            }
            let is_cause =
                holds(response.cause) == Some(true) && (state.is_first || !response.is_first_only);
            if goal == Some(false) && age.is_some_and(|age| age >= within) {
                is_late = true;
                *open = None;
            }
            if open.is_none() && is_cause {
                *open = Some(now);
            }
        }
        is_late
    }

    /// Goes on to the next position.
    pub fn pass(&self, state: &mut ResponseState, letter: Letter<'_>) {
        let values = self.conditions.values(&state.memory, letter);
        self.conditions.remember(&mut state.memory, &values, letter);
        state.is_first = false;
    }

    fn add(&mut self, formula: &Ltl) {
        match formula {
            Ltl::And(parts) => parts.iter().for_each(|part| self.add(part)),
            Ltl::Globally(of) => self.always(of),
            Ltl::Finally(goal) | Ltl::Until(_, goal) => self.response(&Ltl::True, goal, true),
            Ltl::True
            | Ltl::False
            | Ltl::Atom(_)
            | Ltl::Not(_)
            | Ltl::Or(_)
            | Ltl::Implies(..)
            | Ltl::Iff(..)
            | Ltl::Next(_)
            | Ltl::Release(..)
            | Ltl::WeakUntil(..)
            | Ltl::Yesterday(_)
            | Ltl::WeakYesterday(_)
            | Ltl::Once(_)
            | Ltl::Historically(_)
            | Ltl::Since(..)
            | Ltl::Triggered(..) => {}
        }
    }

    /// Adds a response that is always due.
    fn always(&mut self, formula: &Ltl) {
        if let Ltl::And(parts) = formula {
            parts.iter().for_each(|part| self.always(part));
        } else if let Ltl::Implies(cause, effect) = formula
            && let Ltl::Finally(goal) | Ltl::Until(_, goal) = &**effect
        {
            self.response(cause, goal, false);
        } else if let Ltl::Finally(goal) | Ltl::Until(_, goal) = formula {
            self.response(&Ltl::True, goal, false);
        }
    }

    fn response(&mut self, cause: &Ltl, goal: &Ltl, is_first_only: bool) {
        let (Some(cause), Some(goal)) = (self.conditions.add(cause), self.conditions.add(goal))
        else {
            return;
        };
        self.responses.push(DueResponse {
            cause,
            goal,
            is_first_only,
        });
    }
}

impl ResponseState {
    /// Returns the time of the earliest cause without a response.
    pub fn earliest(&self) -> Option<i64> {
        self.open.iter().flatten().min().copied()
    }
}
