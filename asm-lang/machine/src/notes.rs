//! What a failed step saw, as watched code writes it down.

use crate::fault::{FaultKind, StepFault};
use crate::limits::MAX_ITERATIONS;
use crate::updates::Update;
use asmotion_ir::{Origin, Slot};
use asmotion_value::Value;
use std::collections::BTreeMap;

/// The way to a fault.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Witness {
    /// To the place of the fault, from the outside in.
    pub path: Vec<PathEntry>,
    /// Where two rules clash, to the one that wrote first.
    pub first: Vec<PathEntry>,
}

/// A rule or call on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct PathEntry {
    /// Where it stands.
    pub origin: Origin,
    /// Whether it calls what comes next.
    pub calls: bool,
    /// What the terms in it read, by their places: variables, locations, definitions applied.
    pub reads: BTreeMap<Origin, Value>,
}

impl Witness {
    /// Of a loop without end, only so many rounds are done once more.
    pub const ROUNDS: u32 = 10_000;
}

/// What watched code writes down.
#[derive(Debug)]
pub(crate) struct WitnessNotes {
    /// Where the run is now.
    path: Vec<PathEntry>,
    /// Where it was when it failed.
    failed: Vec<PathEntry>,
    /// The updates that clash, and the ways to them.
    writers: Vec<(Update, Vec<PathEntry>)>,
    /// Whether it is about a loop without end.
    endless: bool,
}

impl WitnessNotes {
    pub fn about(fault: &StepFault) -> Self {
        let writers = match &fault.kind {
            FaultKind::Clash {
                slot,
                first,
                first_origin,
                second,
            } => vec![
                Self::writer(*slot, first, *first_origin),
                Self::writer(*slot, second, fault.origin),
            ],
            _ => Vec::new(),
        };
        Self {
            path: vec![PathEntry::new(fault.origin, false)],
            failed: Vec::new(),
            writers,
            endless: matches!(fault.kind, FaultKind::Endless(_)),
        }
    }

    /// How often loops may go round.
    pub fn max_iterations(&self) -> u32 {
        match self.endless {
            true => Witness::ROUNDS,
            false => MAX_ITERATIONS,
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

    /// An update was added to the set, or stands last in it.
    pub fn wrote(&mut self, update: &Update) {
        for (wanted, path) in &mut self.writers {
            if wanted == update {
                path.clone_from(&self.path);
            }
        }
    }

    pub fn fail(&mut self) {
        self.failed = std::mem::take(&mut self.path);
    }

    pub fn into_witness(self) -> Witness {
        let mut writers = self.writers.into_iter().map(|(_, path)| path);
        let first = writers.next().unwrap_or_default();
        // a clash of what rules of `seq` wrote is found when they are long done
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
