//! Locations that take ever new values: the usual reason for which an exploration does not end.

use crate::explore::Exploration;
use crate::inputs::MAX_VALUES;
use crate::system::{VerifiedMachine, declared_at};
use crate::transition::TransitionSystem;
use asmotion_diagnostics::Span;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::simulate::applied;
use asmotion_lang::{Machine, Value};
use std::collections::{BTreeMap, BTreeSet};

/// A location that takes ever new values in the states that were explored.
#[derive(Clone, Debug)]
pub struct GrowingLocation {
    /// Index of the machine.
    pub machine: usize,
    /// The location, as in `total` or `count(ROB1)`.
    pub location: String,
    /// Some of its values, in the order of the exploration.
    pub values: Vec<String>,
    /// Number of different values in the examined states.
    pub count: usize,
    /// Number of examined states.
    pub states: usize,
    /// Place of the declaration of its function.
    pub place: Span,
}

/// Number of states that are examined, at equal distances.
const EXAMINED: usize = 10_000;

/// Number of different values from which a location counts as growing.
const MANY: usize = 32;

/// Number of values that are shown.
const SHOWN: usize = 3;

/// Returns the growing locations, those with the most values first. Call it if an exploration has not ended.
pub(crate) fn growing_locations<S: TransitionSystem>(
    system: &S,
    exploration: &Exploration,
    machines: &[VerifiedMachine],
) -> Vec<GrowingLocation> {
    let mut system = system.clone();
    let nodes = exploration.nodes();
    let distance = (nodes as usize).div_ceil(EXAMINED).max(1);
    let mut seen: BTreeMap<(usize, FunctionId, Vec<Value>), ValueHistory> = BTreeMap::new();
    let mut states = 0;
    for node in (0..nodes).step_by(distance) {
        system.restore(&exploration.state(node));
        states += 1;
        for (index, machine) in system.machines().iter().enumerate() {
            for (function, arguments, slot) in machine.state().locations(machine.program()) {
                if is_unbounded(machine, function) {
                    let history = seen.entry((index, function, arguments)).or_default();
                    history.add(machine.state().get(slot), states);
                }
            }
        }
    }
    let growing = seen.into_iter().filter(|(_, it)| it.grows(states));
    let mut found: Vec<GrowingLocation> = growing
        .filter_map(|((index, function, arguments), history)| {
            let machine = system.machines().get(index)?;
            let naming = machine.naming();
            let first = history.first.iter();
            let known = machines.get(index)?;
            Some(GrowingLocation {
                machine: index,
                location: applied(machine, function, &arguments),
                values: first.map(|it| it.show(&naming).to_string()).collect(),
                count: history.values.len(),
                states,
                place: declared_at(&known.specification, function),
            })
        })
        .collect();
    found.sort_by_key(|it| std::cmp::Reverse(it.count));
    found
}

/// Returns `true` if a function that rules update has infinitely many values.
fn is_unbounded(machine: &Machine, function: FunctionId) -> bool {
    use asmotion_lang::ir::FunctionKind;
    let declared = machine.program().functions.get(function.0 as usize);
    declared.is_some_and(|it| {
        let is_updated = match it.kind {
            FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared => true,
            FunctionKind::Monitored | FunctionKind::Local | FunctionKind::Fixed => false,
        };
        is_updated && machine.elements(&it.codomain, MAX_VALUES).is_none()
    })
}

/// The values of a location, in the order of the exploration.
#[derive(Default)]
struct ValueHistory {
    values: BTreeSet<Value>,
    /// The first new values.
    first: Vec<Value>,
    /// Number of the examined state with the last new value.
    last_new: usize,
}

impl ValueHistory {
    fn add(&mut self, value: &Value, state: usize) {
        if value.is_undef() || !self.values.insert(value.clone()) {
            return;
        }
        self.last_new = state;
        if self.first.len() < SHOWN {
            self.first.push(value.clone());
        }
    }

    /// There are many values, and new ones until the end.
    fn grows(&self, states: usize) -> bool {
        self.values.len() >= MANY && self.last_new * 10 >= states * 9
    }
}
