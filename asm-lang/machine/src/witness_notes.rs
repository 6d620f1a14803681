//! Records of a repeated step: the way to its fault and the values read.

use crate::fault::{FaultKind, StepFault};
use crate::limits::MAX_ITERATIONS;
use crate::updates::Update;
use asmotion_ir::{Origin, Slot};
use asmotion_value::Value;
use std::collections::BTreeMap;

/// The explanation of a fault: the rules and calls that led to it, and the values they read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Witness {
    /// The way to the fault, outermost rule first.
    pub path: Vec<PathEntry>,
    /// For a clash, the way to the rule that wrote first; otherwise empty.
    pub first: Vec<PathEntry>,
}

/// A rule or call on the way to a fault.
#[derive(Clone, Debug, PartialEq)]
pub struct PathEntry {
    /// Place of the rule or call in the sources.
    pub origin: Origin,
    /// `true` for a call, whose callee contains the next entry.
    pub calls: bool,
    /// Values of the variables, locations and defined functions read in it, by place.
    pub reads: BTreeMap<Origin, Value>,
}

impl Witness {
    /// Limit for loop iterations when a step with an endless loop is repeated.
    pub const ROUNDS: u32 = 10_000;
}

/// The reasons for the updates of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepAccount {
    /// The updates, each with the rules and calls that led to it, outermost first.
    pub updates: Vec<(Update, Vec<PathEntry>)>,
}

/// The records while a step is repeated.
#[derive(Debug, Default)]
pub(crate) struct WitnessNotes {
    /// The way to the current position.
    path: Vec<PathEntry>,
    /// The way to the position of the fault.
    failed: Vec<PathEntry>,
    /// The clashing updates, each with the way to it.
    writers: Vec<(Update, Vec<PathEntry>)>,
    /// `true` if the fault is an endless loop.
    endless: bool,
    /// The way to every update, if the step is to be accounted for.
    account: Option<StepAccount>,
}

impl WitnessNotes {
    pub fn for_fault(fault: &StepFault) -> Self {
        let writers = if let FaultKind::Clash {
            slot,
            first,
            first_origin,
            second,
        } = &fault.kind
        {
            vec![
                Self::writer(*slot, first, *first_origin),
                Self::writer(*slot, second, fault.origin),
            ]
        } else {
            Vec::new()
        };
        Self {
            path: vec![PathEntry::new(fault.origin, false)],
            failed: Vec::new(),
            writers,
            endless: matches!(fault.kind, FaultKind::Endless(_)),
            account: None,
        }
    }

    /// Records the way to every update.
    pub fn for_step() -> Self {
        Self {
            account: Some(StepAccount::default()),
            ..Self::default()
        }
    }

    pub fn into_account(self) -> StepAccount {
        self.account.unwrap_or_default()
    }

    /// Returns the limit for loop iterations.
    pub fn max_iterations(&self) -> u32 {
        if self.endless {
            Witness::ROUNDS
        } else {
            MAX_ITERATIONS
        }
    }

    fn writer(slot: Slot, value: &Value, origin: Origin) -> (Update, Vec<PathEntry>) {
        let value = value.clone();
        (
            Update {
                slot,
                value,
                origin,
            },
            Vec::new(),
        )
    }

    pub fn enter(&mut self, origin: Origin, calls: bool) {
        self.path.push(PathEntry::new(origin, calls));
    }

    pub fn leave(&mut self) {
        self.path.pop();
    }

    pub fn read(&mut self, origin: Origin, value: &Value) {
        if let Some(passed) = self.path.last_mut() {
            passed.reads.insert(origin, value.clone());
        }
    }

    /// Records the way to an update that was added to the set or replaced one in it.
    pub fn record_update(&mut self, update: &Update) {
        for (wanted, path) in &mut self.writers {
            if wanted == update {
                path.clone_from(&self.path);
            }
        }
        // rules around the update see it, too
        let is_here = self
            .path
            .last()
            .is_some_and(|it| it.origin == update.origin);
        if let Some(account) = self.account.as_mut().filter(|_| is_here)
            && !account.updates.iter().any(|(known, _)| known == update)
        {
            account.updates.push((update.clone(), self.path.clone()));
        }
    }

    pub fn fail(&mut self) {
        self.failed = std::mem::take(&mut self.path);
    }

    pub fn into_witness(self) -> Witness {
        let mut writers = self.writers.into_iter().map(|(_, path)| path);
        let first = writers.next().unwrap_or_default();
        // a clash between rules of `seq` is found only after they have finished
        let second = writers.next().filter(|path| !path.is_empty());
        Witness {
            path: second.unwrap_or(self.failed),
            first,
        }
    }
}

impl PathEntry {
    fn new(origin: Origin, calls: bool) -> Self {
        Self {
            origin,
            calls,
            reads: BTreeMap::new(),
        }
    }
}
