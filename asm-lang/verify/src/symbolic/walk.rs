//! Runs along sets of nodes: the machine executes steps, and the sets select among them.

use super::Symbolic;
use crate::counterexample::{NodePath, Replay, Run};
use crate::deciding::Deciding;
use crate::decisions::{Decision, Decisions, InputValue};
use crate::explore::{Exploration, ExplorationOptions, Limits};
use crate::explorer::Explorer;
use crate::property::CheckedProperty;
use crate::store::StateStorage;
use crate::transition::{SingleMachine, TransitionSystem};
use crate::verdicts::verdicts;
use asmotion_lang::ir::Slot;
use asmotion_lang::{Diagnostic, Value};
use asmotion_symbolic::{
    FaultClass, NodeSet, Reached, SymbolicError, SymbolicFault, SymbolicInput, SymbolicModel,
};

/// Number of executions of a step between two questions whether to go on.
const INTERVAL: u32 = 1 << 10;

/// A node of a run: the bytes of its state, and its inputs.
type WalkedNode = (Vec<u8>, Vec<InputValue>);

/// A run along sets of nodes.
pub(super) struct Walk {
    nodes: Vec<WalkedNode>,
    /// The decisions of the steps between them.
    decisions: Vec<Vec<Decision>>,
    /// The decisions of a step that fails in the last node.
    failing: Option<Vec<Decision>>,
    /// The last node.
    last: NodeSet,
}

/// The machine that makes the steps of a run. Diagrams give their inputs; its choices are tried.
pub(super) struct Walker<'a> {
    model: &'a SymbolicModel<'a>,
    symbolic: &'a Symbolic<'a>,
    system: SingleMachine<'a>,
    proceed: &'a dyn Fn() -> bool,
    /// Number of executions of steps.
    executions: u32,
}

impl<'a> Walker<'a> {
    pub fn new(
        symbolic: &'a Symbolic<'a>,
        model: &'a SymbolicModel<'a>,
        proceed: &'a dyn Fn() -> bool,
    ) -> Self {
        Self {
            model,
            symbolic,
            system: symbolic.system(),
            proceed,
            executions: 0,
        }
    }

    /// Returns a run whose n-th node is in the n-th set. `None` if there is none.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn walk(&mut self, sets: &[NodeSet]) -> Result<Option<Walk>, SymbolicError> {
        let Some((first, others)) = sets.split_first() else {
            return Ok(None);
        };
        self.system = self.symbolic.system();
        let Some((mut last, node)) = self.arrive(first)? else {
            return Ok(None);
        };
        let (mut nodes, mut decisions) = (vec![node], Vec::new());
        for set in others {
            let Some(from) = nodes.last() else {
                return Ok(None);
            };
            let Some((to, node, taken)) = self.step_into((&last, from), set)? else {
                return Ok(None);
            };
            last = to;
            nodes.push(node);
            decisions.push(taken);
        }
        Ok(Some(Walk {
            nodes,
            decisions,
            failing: None,
            last,
        }))
    }

    /// Returns a successor in a set, with the decisions of the step.
    fn step_into(
        &mut self,
        (from, (state, inputs)): (&NodeSet, &WalkedNode),
        set: &NodeSet,
    ) -> Result<Option<(NodeSet, WalkedNode, Vec<Decision>)>, SymbolicError> {
        let Some(fixed) = self.model.step_inputs(from, set)? else {
            return Ok(None);
        };
        let decisions = Decisions::with(as_inputs(fixed));
        loop {
            self.system.restore(state);
            if self.system.step(&decisions, inputs).is_ok()
                && let Some((to, node)) = self.arrive(set)?
            {
                return Ok(Some((to, node, decisions.taken())));
            }
            self.count()?;
            if !decisions.advance() {
                return Ok(None);
            }
        }
    }

    /// Returns the first node of the current state that is in a set.
    fn arrive(&mut self, set: &NodeSet) -> Result<Option<(NodeSet, WalkedNode)>, SymbolicError> {
        let state = self.system.machine.state();
        let here = self
            .model
            .nodes_of_state(&|slot: Slot| state.get(slot).clone())?;
        let here = self.model.intersection(&here, set)?;
        let Some((node, inputs)) = self.model.first_node(&here)? else {
            return Ok(None);
        };
        let mut bytes = Vec::new();
        self.system.pack(&mut bytes);
        Ok(Some((node, (bytes, as_inputs(inputs)))))
    }

    /// Adds a step that fails in this way, or in another one if none does: of several inconsistent updates of a step, a machine may
    /// report another one than the model.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn fail(&mut self, walk: &mut Walk, fault: &SymbolicFault) -> Result<(), SymbolicError> {
        let Some((state, inputs)) = walk.nodes.last() else {
            return Ok(());
        };
        let Some(fixed) = self.model.failing_inputs(&walk.last, fault)? else {
            return Ok(());
        };
        let decisions = Decisions::with(as_inputs(fixed));
        loop {
            self.system.restore(state);
            if let Err(found) = self.system.step(&decisions, inputs)
                && let Some(found) = found.step()
            {
                walk.failing.get_or_insert_with(|| decisions.taken());
                if found.origin == fault.origin && FaultClass::of(&found.kind) == fault.class {
                    walk.failing = Some(decisions.taken());
                    return Ok(());
                }
            }
            self.count()?;
            if !decisions.advance() {
                return Ok(());
            }
        }
    }

    /// Describes the failure of a condition's evaluation in a state.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn failed_condition(
        &mut self,
        reached: &Reached,
        index: usize,
    ) -> Result<Option<Diagnostic>, SymbolicError> {
        let set = self.model.failing(reached, index)?;
        let Some(sets) = self.model.shortest(reached, &set)? else {
            return Ok(None);
        };
        let walk = self.walk(&sets)?;
        let Some((state, inputs)) = walk.and_then(|walk| walk.nodes.into_iter().last()) else {
            return Ok(None);
        };
        self.system.restore(&state);
        let terms = &self.symbolic.properties.conditions.terms;
        let term = terms.get(index..=index).unwrap_or_default();
        let mut values: Vec<Value> = Vec::new();
        let done = self
            .system
            .evaluate(term, &Decisions::with(inputs), &mut values);
        Ok(match (done, self.symbolic.known.first()) {
            (Err(fault), Some(known)) => Some(fault.diagnostic(&known.specification, None)),
            (Ok(()), _) | (_, None) => None,
        })
    }

    /// Counts an execution, and asks now and then whether to go on.
    fn count(&mut self) -> Result<(), SymbolicError> {
        self.executions = self.executions.wrapping_add(1);
        if self.executions.is_multiple_of(INTERVAL) && !(self.proceed)() {
            return Err(SymbolicError::Stopped);
        }
        Ok(())
    }
}

/// Returns inputs of the only machine.
fn as_inputs(inputs: Vec<SymbolicInput>) -> Vec<InputValue> {
    let inputs = inputs.into_iter().map(|input| InputValue {
        machine: 0,
        function: input.function,
        arguments: input.arguments.into(),
        value: input.value,
    });
    inputs.collect()
}

impl Symbolic<'_> {
    /// Executes the steps of a run.
    pub(super) fn replay(&self, walk: Walk) -> Run {
        let count = walk.nodes.len() as u32;
        let exploration = Exploration::of_path(walk.nodes);
        let system = self.system();
        let replay = self.replay_of(&exploration, &system);
        replay.run(&NodePath {
            nodes: (0..count).collect(),
            decisions: walk.decisions,
            failing: walk.failing,
            ..NodePath::default()
        })
    }

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
            None => {
                let mut goes_on = |_| proceed();
                let deciding = Deciding::new(&exploration, None, &mut goes_on);
                let checked = verdicts(self.properties, &replay, &self.options.only, &deciding);
                checked.ok().filter(|_| deciding.ended().is_none())
            }
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
