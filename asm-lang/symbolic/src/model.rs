//! A program as a transition system over Boolean variables.

use crate::bdd::{Bdd, BddStore, BitIndex, NODE_BYTES};
use crate::encoding::{InputCode, Inputs, SlotCode, Slots};
use crate::error::SymbolicError;
use crate::evaluator::{Evaluator, GuardedFault, InputValues};
use crate::moves::Moves;
use asmotion_lang::hir::AddedTerm;
use asmotion_lang::ir::{CoveragePoint, FunctionId, Origin, Slot};
use asmotion_lang::{Machine, Value};
use std::collections::BTreeMap;

/// Limit for the values of a location, and for the elements of a domain.
pub(crate) const MAX_VALUES: usize = 4096;

/// Limit for the rounds in which the values of locations are found.
const MAX_ROUNDS: usize = 300;

/// A condition that is considered in each state.
pub(crate) struct Condition {
    pub yes: Bdd,
    pub undef: Bdd,
    /// States in which its evaluation fails.
    pub fails: Bdd,
}

/// A set of nodes. A node is a state with the inputs that conditions read.
#[derive(Clone, PartialEq, Eq)]
pub struct NodeSet(pub(crate) Bdd);

impl NodeSet {
    /// Returns `true` if there is no node in the set.
    pub fn is_empty(&self) -> bool {
        self.0.is_never()
    }
}

/// A program as a transition system.
pub struct SymbolicModel<'a> {
    pub(crate) store: BddStore<'a>,
    pub(crate) slots: Slots,
    pub(crate) inputs: Inputs,
    pub(crate) moves: Vec<Moves>,
    pub(crate) conditions: Vec<Condition>,
    /// The combinations of a state and the inputs that its conditions read.
    pub(crate) consistent: Bdd,
    /// Those that the assumptions permit.
    pub(crate) valid: Bdd,
    pub(crate) initial: Bdd,
    pub(crate) faults: Vec<GuardedFault>,
    /// The condition under which each counted rule runs.
    pub(crate) counted: BTreeMap<u32, Bdd>,
    /// Variables of the current state, in ascending order.
    pub(crate) now: Vec<BitIndex>,
    /// Variables of the inputs that conditions read.
    pub(crate) known: Vec<BitIndex>,
    pub(crate) known_cube: Bdd,
}

/// The parts of a model.
pub struct ModelSource<'a> {
    /// The machine in its initial state.
    pub machine: &'a Machine,
    /// The possible values of an input; `None` if they cannot be enumerated.
    pub ranges: &'a dyn Fn(FunctionId) -> Option<Vec<Value>>,
    /// The conditions.
    pub conditions: &'a [AddedTerm],
    /// Indices of the conditions without which a state with its inputs is not considered.
    pub assumed: &'a [usize],
    /// Memory that the diagrams may take, in bytes.
    pub memory: u64,
    /// Called now and then, also while a set is computed, with the number of nodes of all diagrams; ends the computation by returning
    /// `false`.
    pub proceed: &'a dyn Fn(usize) -> bool,
}

impl<'a> SymbolicModel<'a> {
    /// Memory for a node of a diagram, in bytes.
    pub const NODE_BYTES: u64 = NODE_BYTES;

    /// Builds the transition system of a program.
    ///
    /// # Errors
    /// A construct has no representation, the values of an input cannot be enumerated, the memory is full, or the caller ends it.
    pub fn of(source: &ModelSource<'a>) -> Result<Self, SymbolicError> {
        let program = source.machine.program();
        if program.compatible {
            let construct = "a program compatible with the reference";
            return Err(SymbolicError::unsupported(Origin::default(), construct));
        }
        if program.needs_inputs() {
            let construct = "an initial state that depends on inputs";
            return Err(SymbolicError::unsupported(Origin::default(), construct));
        }
        let mut ranges: BTreeMap<Slot, Vec<Value>> = BTreeMap::new();
        let mut inputs = Inputs::default();
        let mut store = BddStore::new(source.memory, source.proceed);
        for round in 0..MAX_ROUNDS {
            store.check()?;
            if round.is_multiple_of(16) || store.is_wide() {
                store = BddStore::new(source.memory, source.proceed);
            }
            let (slots, coded) = coded(&store, source.machine, &ranges, &inputs)?;
            match Attempt::of(&store, source, &slots, coded)? {
                Ok(attempt) => return attempt.model(store, slots, source),
                Err((escaped, read)) => {
                    grow(source.machine, &mut ranges, escaped)?;
                    inputs = read;
                }
            }
        }
        let construct = "a location with this many values";
        Err(SymbolicError::unsupported(Origin::default(), construct))
    }

    /// Returns the number of states in a set of nodes.
    pub(crate) fn state_count(&self, states: &Bdd) -> Option<u128> {
        self.store.count(states, &self.now)
    }

    /// Returns the number of nodes.
    pub(crate) fn node_count(&self, nodes: &Bdd) -> Option<u128> {
        self.store.count(nodes, &self.node_bits())
    }

    pub(crate) fn node_bits(&self) -> Vec<BitIndex> {
        let mut bits: Vec<BitIndex> = self.now.iter().chain(&self.known).copied().collect();
        bits.sort_unstable();
        bits
    }

    /// Returns the states of nodes.
    pub(crate) fn states_of(&self, nodes: &Bdd) -> Result<Bdd, SymbolicError> {
        self.store.exists(nodes, &self.known_cube)
    }
}

/// Values that the variables of a location cannot represent, with the place of an update.
type Escaped = BTreeMap<(Slot, Value), Origin>;

/// Adds values to the ranges of locations.
fn grow(
    machine: &Machine,
    ranges: &mut BTreeMap<Slot, Vec<Value>>,
    escaped: Escaped,
) -> Result<(), SymbolicError> {
    let program = machine.program();
    for ((slot, value), origin) in escaped {
        let range = ranges.entry(slot).or_insert_with(|| {
            let initial = machine.state().get(slot).clone();
            let function = machine.state().function(program, slot);
            let function = function.and_then(|id| program.functions.get(id.0 as usize));
            let values = function.and_then(|it| machine.elements(&it.codomain, MAX_VALUES));
            let mut values = values.filter(|it| it.len() <= 256).unwrap_or_default();
            if !values.contains(&initial) {
                values.insert(0, initial);
            }
            values
        });
        if !range.contains(&value) {
            range.push(value);
        }
        if range.len() > MAX_VALUES {
            let construct = "a location with this many values";
            return Err(SymbolicError::unsupported(origin, construct));
        }
    }
    Ok(())
}

/// A location or an input that gets variables.
enum Coded<'r> {
    Slot(Slot, &'r [Value]),
    Input(FunctionId, &'r [Value], &'r InputCode),
}

/// Adds variables for locations, and for the inputs with arguments that the last attempt has read. Those with the same arguments, as for
/// one agent, are next to each other.
fn coded(
    store: &BddStore,
    machine: &Machine,
    ranges: &BTreeMap<Slot, Vec<Value>>,
    read: &Inputs,
) -> Result<(Slots, Inputs), SymbolicError> {
    let program = machine.program();
    let group = |function: FunctionId| {
        let shape = |id: usize| {
            let function = program.functions.get(id);
            function.and_then(|it| it.parameters.first())
        };
        let own = shape(function.0 as usize);
        (0..program.functions.len()).find(|id| shape(*id) == own)
    };
    let mut order = Vec::new();
    for (slot, values) in ranges {
        let location = machine.state().location(program, *slot);
        let (function, arguments) = location.unwrap_or((FunctionId(0), Vec::new()));
        let first = arguments.first().cloned();
        let key = (
            first.is_some(),
            group(function),
            first,
            function,
            Some(*slot),
        );
        order.push((key, Coded::Slot(*slot, values)));
    }
    for ((function, arguments), input) in read.named() {
        // others get variables after those of all locations when they are read
        if let Some(first) = arguments.first() {
            let key = (true, group(*function), Some(first.clone()), *function, None);
            order.push((key, Coded::Input(*function, arguments, input)));
        }
    }
    order.sort_by(|left, right| left.0.cmp(&right.0));
    let (mut slots, mut inputs) = (Slots::new(), Inputs::default());
    for (_, coded) in order {
        match coded {
            Coded::Slot(slot, values) => {
                slots.insert(slot, SlotCode::add(store, values.to_vec())?);
            }
            Coded::Input(function, arguments, input) => {
                inputs.add(function, arguments.to_vec(), input.coded_again(store)?);
            }
        }
    }
    Ok((slots, inputs))
}

/// An evaluation of a program with variables for some values.
struct Attempt {
    inputs: Inputs,
    moves: Vec<Moves>,
    conditions: Vec<Condition>,
    consistent: Bdd,
    faults: Vec<GuardedFault>,
    counted: BTreeMap<u32, Bdd>,
}

impl Attempt {
    /// Evaluates conditions and steps. If there are values without a representation, or inputs that do not have their place yet, it
    /// returns the values and the inputs that were read.
    fn of(
        store: &BddStore,
        source: &ModelSource<'_>,
        slots: &Slots,
        mut inputs: Inputs,
    ) -> Result<Result<Self, (Escaped, Inputs)>, SymbolicError> {
        let program = source.machine.program();
        let ranges: InputValues<'_> = source.ranges;
        let mut evaluator = Evaluator::new(store, source.machine, slots, &mut inputs, ranges);
        evaluator.is_condition = true;
        let conditions = evaluated(&mut evaluator, source)?;
        let read = std::mem::take(&mut evaluator.reads);
        if inputs.is_late {
            // diagrams of rules that read them could be large
            return Ok(Err((Escaped::new(), inputs)));
        }
        let consistent = consistent(store, &inputs, &read)?;
        let mut evaluator = Evaluator::new(store, source.machine, slots, &mut inputs, ranges);
        let mut alternatives = Vec::new();
        let main = program
            .main
            .and_then(|main| program.routines.get(main.0 as usize));
        if let Some(main) = main {
            evaluator.enter(Vec::new(), main.locals, main.origin)?;
            evaluator.alternatives(&main.code, &store.always(), &mut alternatives)?;
            evaluator.leave();
        }
        let (faults, counted, escaped) = (evaluator.faults, evaluator.counted, evaluator.escaped);
        if !escaped.is_empty() || inputs.is_late {
            return Ok(Err((escaped, inputs)));
        }
        let mut moves = Vec::new();
        for alternative in &alternatives {
            moves.push(Moves::of(store, slots, &inputs, alternative)?);
        }
        let is_rule = |counter: u32| {
            let counted = program.counted.get(counter as usize);
            counted.is_some_and(|it| it.part == CoveragePoint::Rule)
        };
        Ok(Ok(Self {
            inputs,
            moves,
            conditions,
            consistent,
            faults,
            counted: counted.into_iter().filter(|(it, _)| is_rule(*it)).collect(),
        }))
    }

    fn model<'a>(
        self,
        store: BddStore<'a>,
        slots: Slots,
        source: &ModelSource<'_>,
    ) -> Result<SymbolicModel<'a>, SymbolicError> {
        let mut valid = self.consistent.clone();
        for index in source.assumed {
            if let Some(condition) = self.conditions.get(*index) {
                valid = store.and(&valid, &condition.yes)?;
            }
        }
        let mut initial = store.always();
        for (slot, code) in &slots {
            if let Some(is) = code.is(source.machine.state().get(*slot)) {
                initial = store.and(&initial, is)?;
            }
        }
        let now = slots
            .values()
            .flat_map(|code| code.now.bits.iter().copied());
        let mut now: Vec<BitIndex> = now.collect();
        now.sort_unstable();
        let known = self.inputs.all.iter().filter_map(|it| it.known.as_ref());
        let known: Vec<BitIndex> = known.flat_map(|it| it.bits.iter().copied()).collect();
        Ok(SymbolicModel {
            known_cube: store.bits(&known)?,
            store,
            slots,
            inputs: self.inputs,
            moves: self.moves,
            conditions: self.conditions,
            consistent: self.consistent,
            valid,
            initial,
            faults: self.faults,
            counted: self.counted,
            now,
            known,
        })
    }
}

/// Evaluates the conditions.
fn evaluated(
    evaluator: &mut Evaluator<'_>,
    source: &ModelSource<'_>,
) -> Result<Vec<Condition>, SymbolicError> {
    let store = evaluator.store;
    let mut conditions = Vec::new();
    for term in source.conditions {
        evaluator.stopped = store.never();
        let program = source.machine.program();
        let Some(body) = program.added_terms.get(term.0 as usize) else {
            continue;
        };
        let value = evaluator.call_body(*body, Vec::new(), Origin::default(), &store.always())?;
        let never = || store.never();
        conditions.push(Condition {
            yes: value.get(&Value::Bool(true)).cloned().unwrap_or_else(never),
            undef: value.get(&Value::Undef).cloned().unwrap_or_else(never),
            fails: evaluator.stopped.clone(),
        });
    }
    Ok(conditions)
}

/// Returns the combinations of a state and inputs in which exactly the inputs that conditions read are known.
fn consistent(
    store: &BddStore,
    inputs: &Inputs,
    read: &BTreeMap<usize, Bdd>,
) -> Result<Bdd, SymbolicError> {
    let mut all = store.always();
    for (number, input) in inputs.all.iter().enumerate() {
        let Some(known) = &input.known else { continue };
        let read = read.get(&number).cloned().unwrap_or_else(|| store.never());
        let (unread, values) = match known.values.split_last() {
            Some((unread, values)) => (unread.clone(), store.any(values)?),
            None => continue,
        };
        let is_known = store.and(&read, &values)?;
        let is_unknown = store.without(&unread, &read)?;
        all = store.and(&all, &store.or(&is_known, &is_unknown)?)?;
    }
    Ok(all)
}
