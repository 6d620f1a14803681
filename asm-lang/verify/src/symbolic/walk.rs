//! Runs along sets of nodes: the machine executes steps, and the sets select among them.

use super::Symbolic;
use crate::counterexample::{NodePath, Replay, Run};
use crate::decisions::{Decision, Decisions, InputValue};
use crate::explore::{Exploration, ExplorationOptions, Limits};
use crate::explorer::Explorer;
use crate::property::CheckedProperty;
use crate::store::StateStorage;
use crate::transition::{SingleMachine, TransitionSystem};
use crate::verdicts::verdicts;
use asmotion_lang::ir::{Origin, Slot};
use asmotion_lang::{Diagnostic, Value};
use asmotion_symbolic::{FaultClass, NodeSet, Reached, SymbolicError, SymbolicModel};

/// A node of a run: the bytes of its state, and its inputs.
pub(super) type WalkedNode = (Vec<u8>, Vec<InputValue>);

impl Symbolic<'_> {
    /// Returns the nodes of a run whose n-th node is in the n-th set. `None` if there is none.
    pub(super) fn walk(&self, model: &SymbolicModel, sets: &[NodeSet]) -> Option<Vec<WalkedNode>> {
        let mut system = self.system();
        let (first, others) = sets.split_first()?;
        let mut nodes = vec![self.arrive(model, &mut system, first)?];
        for set in others {
            let next = self.step_into(model, &mut system, nodes.last()?, set)?;
            nodes.push(next);
        }
        Some(nodes)
    }

    /// Returns a successor in a set.
    fn step_into(
        &self,
        model: &SymbolicModel,
        system: &mut SingleMachine<'_>,
        (state, inputs): &WalkedNode,
        set: &NodeSet,
    ) -> Option<WalkedNode> {
        let decisions = Decisions::default();
        loop {
            system.restore(state);
            if system.step(&decisions, inputs).is_ok()
                && let Some(node) = self.arrive(model, system, set)
            {
                return Some(node);
            }
            if !decisions.advance() {
                return None;
            }
        }
    }

    /// Returns the node of the current state that is in a set.
    fn arrive(
        &self,
        model: &SymbolicModel,
        system: &mut SingleMachine<'_>,
        set: &NodeSet,
    ) -> Option<WalkedNode> {
        let terms = &self.properties.conditions.terms;
        let decisions = Decisions::default();
        let mut values: Vec<Value> = Vec::new();
        loop {
            values.clear();
            while values.len() < terms.len() {
                let rest = terms.get(values.len()..).unwrap_or_default();
                if system.evaluate(rest, &decisions, &mut values).is_err() {
                    values.push(Value::Undef);
                }
            }
            let inputs = decisions.read();
            let state = system.machine.state();
            let value = |slot: Slot| state.get(slot).clone();
            let known = inputs
                .iter()
                .map(|it| (it.function, &*it.arguments, &it.value));
            if model.contains(set, &value, known) {
                let mut bytes = Vec::new();
                system.pack(&mut bytes);
                return Some((bytes, inputs));
            }
            if !decisions.advance() {
                return None;
            }
        }
    }

    /// Returns the decisions of a step that fails in this way, or in another one if none does: of several inconsistent updates of a step,
    /// a machine may report another one than the model.
    pub(super) fn failing(
        &self,
        (state, inputs): &WalkedNode,
        origin: Origin,
        class: FaultClass,
    ) -> Option<Vec<Decision>> {
        let mut system = self.system();
        let decisions = Decisions::default();
        let mut other = None;
        loop {
            system.restore(state);
            if let Err(fault) = system.step(&decisions, inputs)
                && let Some(fault) = fault.step()
            {
                if fault.origin == origin && FaultClass::of(&fault.kind) == class {
                    return Some(decisions.taken());
                }
                other.get_or_insert_with(|| decisions.taken());
            }
            if !decisions.advance() {
                return other;
            }
        }
    }

    /// Describes the failure of a condition's evaluation in a state.
    pub(super) fn failed_condition(
        &self,
        model: &SymbolicModel,
        reached: &Reached,
        index: usize,
    ) -> Result<Option<Diagnostic>, SymbolicError> {
        let set = model.failing(reached, index)?;
        let Some(sets) = model.shortest(reached, &set)? else {
            return Ok(None);
        };
        let Some((state, _)) = self
            .walk(model, &sets)
            .and_then(|nodes| nodes.into_iter().last())
        else {
            return Ok(None);
        };
        let mut system = self.system();
        system.restore(&state);
        let term = self.properties.conditions.terms.get(index..=index);
        let decisions = Decisions::default();
        loop {
            let mut values = Vec::new();
            let done = system.evaluate(term.unwrap_or_default(), &decisions, &mut values);
            if let (Err(fault), Some(known)) = (done, self.known.first()) {
                return Ok(Some(fault.diagnostic(&known.specification, None)));
            }
            if !decisions.advance() {
                return Ok(None);
            }
        }
    }

    /// Executes the steps between nodes.
    pub(super) fn replay(&self, nodes: Vec<WalkedNode>, failing: Option<Vec<Decision>>) -> Run {
        let count = nodes.len() as u32;
        let exploration = Exploration::of_path(nodes);
        let system = self.system();
        let replay = self.replay_of(&exploration, &system);
        replay.run(&NodePath {
            nodes: (0..count).collect(),
            failing,
            ..NodePath::default()
        })
    }
}

impl Symbolic<'_> {
    /// Checks the properties by exploring single states, for the runs; nothing if this does not finish.
    pub(super) fn explored(&self, proceed: &dyn Fn() -> bool) -> Vec<CheckedProperty> {
        let system = self.system();
        let conditions = &self.properties.conditions;
        let options = ExplorationOptions {
            limits: Limits::default(),
            keeps_edges: true,
            threads: self.options.threads,
            storage: StateStorage::Memory,
            symmetry: false,
            independent: false,
            cone: None,
        };
        let explorer = Explorer::new(system.clone(), conditions, &options, self.fair);
        let Ok(exploration) = explorer.run(&mut |_| proceed()) else {
            return Vec::new();
        };
        let replay = self.replay_of(&exploration, &system);
        let checked = match exploration.incomplete {
            None => verdicts(self.properties, &replay, &self.options.only).ok(),
            Some(_) => None,
        };
        checked.unwrap_or_default()
    }

    fn replay_of<'r>(
        &'r self,
        exploration: &'r Exploration,
        system: &'r SingleMachine<'r>,
    ) -> Replay<'r, SingleMachine<'r>> {
        Replay {
            machines: self.known,
            exploration,
            system,
            fair: self.fair,
            keeps_states: self.options.keeps_states,
        }
    }
}
