//! What a failed step saw.
//!
//! A step keeps no notes, so that it is fast. Where one fails, it is done once more: on the state it
//! began in, with the inputs and choices it had, by code in which every read and every rule is
//! watched.

use crate::choose::Chooser;
use crate::compile::{Code, MAX_ITERATIONS};
use crate::environment::Environment;
use crate::fault::{Fault, FaultKind};
use crate::machine::{Choice, Machine};
use crate::updates::Update;
use asmotion_ir::{FunctionId, Node, Origin, Program, Rule, RuleNode, Slot, Term};
use asmotion_value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The way to a fault.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Witness {
    /// To the place of the fault, from the outside in.
    pub path: Vec<Passed>,
    /// Where two rules clash, to the one that wrote first.
    pub first: Vec<Passed>,
}

/// A rule or call on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Passed {
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

    /// What a machine saw that could not be built.
    pub fn initially(program: &Arc<Program>, fault: &Fault) -> Option<Self> {
        let mut again = Machine::blank(program.clone(), Code::watched(program));
        again.watch(fault);
        let failed = again.initialise().err();
        again.told(fault, failed)
    }
}

impl Machine {
    /// What the step saw that failed just now.
    pub fn witness(&self, fault: &Fault) -> Option<Witness> {
        if matches!(fault.kind, FaultKind::ManyCalls(_)) {
            // it would take that long once more, and longer
            return None;
        }
        let last = self.last_step();
        let inputs = last.inputs().iter().filter_map(|input| {
            let location = self.state().location(self.program(), input.slot)?;
            Some((location, input.value.clone()))
        });
        let mut inputs = Inputs {
            known: inputs.collect(),
            refused: String::new(),
            source: String::new(),
        };
        if let FaultKind::Input { reason, .. } = &fault.kind {
            inputs.refused.clone_from(reason);
        }
        if let FaultKind::OutsideInput {
            slot,
            misfit,
            source,
        } = &fault.kind
        {
            let location = self.state().location(self.program(), *slot);
            let value = misfit.value.clone();
            inputs.known.extend(location.map(|at| (at, value)));
            inputs.source.clone_from(source);
        }
        let mut choices = Choices {
            made: last.choices(),
            picked: self.picked(),
            next: 0,
        };
        let mut again = self.recompiled(Code::watched(self.program()));
        again.watch(fault);
        let done = fault.step > 0 && fault.step == last.number();
        let failed = match done {
            // the step was done, and its new state violates an invariant
            true => again
                .check_again(&mut inputs, &mut choices, last.now_ns())
                .err(),
            false => again.step(&mut inputs, &mut choices, last.now_ns()).err(),
        };
        again.told(fault, failed)
    }

    /// The witness, if it was the same fault; of a loop without end, the same loop.
    fn told(&mut self, fault: &Fault, again: Option<Box<Fault>>) -> Option<Witness> {
        let (notes, again) = (self.notes()?, again?);
        let is_it = match (&again.kind, &fault.kind) {
            (FaultKind::Endless(_), FaultKind::Endless(_)) => again.origin == fault.origin,
            _ => *again == *fault,
        };
        is_it.then(|| notes.witness())
    }
}

/// Answers as the environment did.
struct Inputs {
    known: BTreeMap<(FunctionId, Vec<Value>), Value>,
    /// Why there was no answer, if there was none.
    refused: String,
    /// Who gave a value that is none of its location's.
    source: String,
}

impl Environment for Inputs {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        match self.known.get(&(function, arguments.to_vec())) {
            Some(value) => Ok(Some(value.clone())),
            None if self.refused.is_empty() => Ok(None),
            None => Err(self.refused.clone()),
        }
    }

    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        self.source.clone()
    }
}

/// Chooses as it was chosen.
struct Choices<'a> {
    made: &'a [Choice],
    picked: &'a [(Origin, Value)],
    next: usize,
}

impl Chooser for Choices<'_> {
    fn choose(&mut self, _count: usize) -> usize {
        let choice = self.made.get(self.next);
        self.next += 1;
        choice.map_or(0, |choice| choice.index)
    }

    fn takes_first(&self) -> bool {
        self.made.is_empty()
    }

    fn picked(&self, range: Origin) -> Option<Value> {
        let picked = self.picked.iter().find(|(known, _)| *known == range);
        picked.map(|(_, value)| value.clone())
    }
}

/// What watched code writes down.
#[derive(Debug)]
pub(crate) struct Notes {
    /// Where the run is now.
    path: Vec<Passed>,
    /// Where it was when it failed.
    failed: Vec<Passed>,
    /// The updates that clash, and the ways to them.
    writers: Vec<(Update, Vec<Passed>)>,
    /// Whether it is about a loop without end.
    endless: bool,
}

impl Notes {
    pub fn about(fault: &Fault) -> Self {
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
            path: vec![Passed::new(fault.origin, false)],
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

    fn writer(slot: Slot, value: &Value, origin: Origin) -> (Update, Vec<Passed>) {
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
        self.path.push(Passed::new(origin, calls));
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

    fn witness(self) -> Witness {
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

impl Passed {
    fn new(origin: Origin, calls: bool) -> Self {
        Self {
            origin,
            calls,
            reads: BTreeMap::new(),
        }
    }
}

/// A term in which every read is watched.
pub(crate) fn watched_term(mut term: Term) -> Term {
    watch_term(&mut term);
    term
}

/// A rule in which every read and every rule is watched.
pub(crate) fn watched_rule(mut rule: Rule) -> Rule {
    watch_rule(&mut rule);
    rule
}

fn watch_term(term: &mut Term) {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
        for part in term.node.terms_mut() {
            watch_term(part);
        }
    });
    if is_read(&term.node) {
        let (kind, origin) = (term.kind, term.origin);
        let inner = term.clone();
        *term = Term {
            node: Box::new(Node::Watched(inner)),
            kind,
            origin,
        };
    }
}

fn watch_rule(rule: &mut Rule) {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
        for part in rule.node.terms_mut() {
            watch_term(part);
        }
        for part in rule.node.rules_mut() {
            watch_rule(part);
        }
    });
    let origin = rule.origin;
    let inner = rule.clone();
    *rule = Rule {
        node: Box::new(RuleNode::Watched(inner)),
        origin,
    };
}

/// Whether the value of a term is worth a note: its parts alone do not tell it.
fn is_read(node: &Node) -> bool {
    match node {
        Node::Local(_)
        | Node::Agent
        | Node::Slot(..)
        | Node::Location(..)
        | Node::Call(..)
        | Node::Pre(_)
        | Node::Program(_) => true,
        Node::Constant(_)
        | Node::Unbound
        | Node::Name(_)
        | Node::Named(..)
        | Node::Cached(..)
        | Node::Builtin(..)
        | Node::Logic(..)
        | Node::Not(_)
        | Node::Equal(..)
        | Node::Compare(..)
        | Node::Arithmetic(..)
        | Node::Tuple(_)
        | Node::Component(..)
        | Node::If(..)
        | Node::Switch(..)
        | Node::Let(..)
        | Node::Quantified(..)
        | Node::Listed(..)
        | Node::Interval(..)
        | Node::Collect(..)
        | Node::Map(_)
        | Node::CollectMap(..)
        | Node::Extent(_)
        | Node::Watched(_) => false,
    }
}
