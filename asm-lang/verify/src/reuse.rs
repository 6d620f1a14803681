//! The reuse of an exploration: if only properties have changed since the last verification, their conditions are evaluated in
//! the states that are known.

use crate::decisions::{Decisions, MAX_EXECUTIONS};
use crate::explore::{Conditions, Exploration, Truths};
use crate::options::Options;
use crate::system_plan::SystemPlan;
use crate::transition::{MachineFault, TransitionSystem};
use asmotion_lang::ir::{BodyId, Program};
use asmotion_lang::{Machine, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The exploration that one verification leaves for the next one of the same system.
#[derive(Debug, Default)]
pub struct KeptExploration {
    kept: Option<Kept>,
    /// That of the properties that mention no inputs, if they are verified alone.
    without_inputs: Option<Box<Self>>,
    explorations: u64,
}

#[derive(Debug)]
struct Kept {
    /// Everything that the states and transitions depend on.
    basis: String,
    exploration: Exploration,
}

impl KeptExploration {
    /// Returns the number of explorations so far; a verification that reuses one adds none.
    pub fn explorations(&self) -> u64 {
        let without_inputs = self.without_inputs.as_ref();
        self.explorations + without_inputs.map_or(0, |it| it.explorations())
    }

    /// One that has kept an exploration already.
    pub(crate) fn of(basis: &str, exploration: Exploration) -> Self {
        let mut kept = Self::default();
        kept.keep(basis.to_owned(), exploration);
        kept
    }

    /// Returns that of the properties that mention no inputs.
    pub(crate) fn without_inputs(&mut self) -> &mut Self {
        self.without_inputs.get_or_insert_default()
    }

    /// Returns the last exploration with the values of these conditions, if it has the same basis and the conditions can be
    /// evaluated in it.
    pub(crate) fn reused<S: TransitionSystem>(
        &mut self,
        basis: &str,
        system: &S,
        conditions: &Conditions,
        needs_edges: bool,
    ) -> Option<Exploration> {
        let kept = self.kept.take().filter(|it| it.basis == basis)?;
        let mut exploration = kept.exploration;
        if needs_edges && !exploration.keeps_edges {
            return None;
        }
        let observed = Observed::of(system, &exploration, conditions)?;
        exploration.truths = observed.truths;
        exploration.undefined = observed.undefined;
        exploration.failed_terms = observed.failed_terms;
        Some(exploration)
    }

    /// Notes that a system was explored.
    pub(crate) fn explored(&mut self) {
        self.explorations += 1;
    }

    /// Keeps an exploration for the next verification. One that has ended early is not kept, because the next one may come further,
    /// nor is one whose states cannot be restored.
    pub(crate) fn keep(&mut self, basis: String, exploration: Exploration) {
        let is_usable = exploration.incomplete.is_none()
            && !exploration.stands_for_others()
            && exploration.left_out.is_empty();
        self.kept = is_usable.then_some(Kept { basis, exploration });
    }
}

/// Returns a text that is equal for two verifications if their states and transitions are: it contains the programs without
/// the conditions of properties, the values of inputs, and the options.
pub(crate) fn basis(
    machines: &[Machine],
    plan: &SystemPlan,
    options: &Options,
    assumptions: &[String],
) -> String {
    let mut text = String::new();
    for machine in machines {
        program(machine.program(), &mut text);
    }
    // writing to a string never fails
    let _ = write!(
        text,
        "{plan:?}{assumptions:?}{:?}{:?}",
        options.limits, options.advice
    );
    text
}

fn program(program: &Program, to: &mut String) {
    let conditions: BTreeSet<BodyId> = program.added_terms.iter().copied().collect();
    let bodies = program.bodies.iter().enumerate();
    let bodies = bodies.filter(|(index, _)| !conditions.contains(&BodyId(*index as u32)));
    let _ = write!(
        to,
        "{:?}{:?}{:?}",
        program.symbols,
        (&program.domains, &program.functions, &program.dense),
        (program.eager, program.slots, program.main, program.result),
    );
    let _ = write!(
        to,
        "{:?}{:?}{:?}{:?}",
        (&program.routines, &program.rules, &program.programs),
        (&program.initial_order, &program.initial_inputs),
        (&program.counted, &program.messages, program.compatible),
        bodies.collect::<Vec<_>>(),
    );
}

/// The values of conditions at the nodes of an exploration.
struct Observed {
    truths: Vec<Truths>,
    undefined: Vec<u64>,
    failed_terms: BTreeMap<usize, MachineFault>,
}

impl Observed {
    /// Evaluates conditions in all states; `None` if the nodes of a state differ from those of the exploration, because the
    /// conditions read other inputs.
    fn of<S: TransitionSystem>(
        system: &S,
        exploration: &Exploration,
        conditions: &Conditions,
    ) -> Option<Self> {
        let count = conditions.terms.len();
        let mut observed = Self {
            truths: vec![Truths::default(); count],
            undefined: vec![0; count],
            failed_terms: BTreeMap::new(),
        };
        let mut system = system.clone();
        let mut node = 0;
        while node < exploration.nodes() {
            let nodes = exploration.nodes_beside(node);
            system.restore(&exploration.state(node));
            let decisions = Decisions::default();
            let mut combinations = 0;
            loop {
                combinations += 1;
                if combinations > MAX_EXECUTIONS {
                    return None;
                }
                let values = observed.values(&mut system, conditions, &decisions)?;
                let is_true = |index: &usize| values.get(*index) == Some(&Value::Bool(true));
                // the assumptions are those of the exploration, so what they exclude has no node
                if conditions.assumed.iter().all(is_true) {
                    if !nodes.contains(&node) || exploration.inputs(node) != decisions.read() {
                        return None;
                    }
                    observed.add(&values);
                    node += 1;
                }
                if !decisions.advance() {
                    break;
                }
            }
            if node != nodes.end {
                return None;
            }
        }
        Some(observed)
    }

    /// Evaluates conditions in a state; one whose evaluation fails is undef.
    fn values<S: TransitionSystem>(
        &mut self,
        system: &mut S,
        conditions: &Conditions,
        decisions: &Decisions,
    ) -> Option<Vec<Value>> {
        let terms = &conditions.terms;
        let mut values = Vec::with_capacity(terms.len());
        while values.len() < terms.len() {
            let rest = terms.get(values.len()..).unwrap_or_default();
            if let Err(fault) = system.evaluate(rest, decisions, &mut values) {
                if fault.is_of_input() {
                    return None;
                }
                self.failed_terms.entry(values.len()).or_insert(fault);
                values.push(Value::Undef);
            }
        }
        Some(values)
    }

    fn add(&mut self, values: &[Value]) {
        for ((value, truths), undefined) in
            values.iter().zip(&mut self.truths).zip(&mut self.undefined)
        {
            truths.push(*value == Value::Bool(true));
            *undefined += u64::from(value.is_undef());
        }
    }
}
