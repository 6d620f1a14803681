//! Advice about a specification, from everything that an exploration has reached: parts that never run, values that never occur,
//! updates without effect, and inputs that nothing reads.

use crate::decisions::Decisions;
use crate::explore::{Exploration, Truths};
use crate::inputs::MAX_VALUES;
use crate::observer::OBSERVER;
use crate::preparation::Prepared;
use crate::system::VerifiedMachine;
use crate::transition::TransitionSystem;
use asmotion_diagnostics::Span;
use asmotion_lang::guards::{on_one_line, rule_with};
use asmotion_lang::hir::{FunctionKind, Meaning, RuleKind};
use asmotion_lang::ir::{CoveragePoint, FunctionId, Origin};
use asmotion_lang::{Machine, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Limit for the executions of steps that are examined for updates and inputs.
const MAX_EXAMINED: u64 = 1 << 20;

/// Limit for the values of a codomain that are compared with those that occur.
const MAX_DOMAIN: usize = 64;

/// A remark on a part of a specification.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SpecificationAdvice {
    /// Index of the machine.
    pub machine: usize,
    /// Place of the part.
    pub place: Span,
    /// Kind of the remark.
    pub kind: AdviceKind,
    /// The remark in words.
    pub text: String,
}

/// The kind of a remark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AdviceKind {
    /// A branch that no step takes.
    UnreachedBranch,
    /// Values of a codomain that no location of the function ever has.
    UnusedValue,
    /// An update that never changes a location.
    TrivialUpdate,
    /// An input that no step and no property reads.
    UnreadInput,
    /// A property about states of which none can be reached.
    UnreachedCondition,
}

/// Returns the advice for a complete exploration, sorted by machine and place. The second value is `false` if there were too many
/// steps to examine updates and inputs.
pub(crate) fn advice<S: TransitionSystem>(
    system: &S,
    exploration: &Exploration,
    machines: &[VerifiedMachine],
    properties: &Prepared,
) -> (Vec<SpecificationAdvice>, bool) {
    let mut all = properties_about_nothing(properties, exploration);
    let moving = machines.iter().zip(system.machines()).enumerate();
    for (index, (known, machine)) in moving.filter(|(_, (known, _))| known.name != OBSERVER) {
        let adviser = MachineAdviser {
            index,
            known,
            machine,
        };
        let counts = exploration.counts.get(index).map(Vec::as_slice);
        all.extend(adviser.branches(counts.unwrap_or_default()));
    }
    let values = OccurringValues::of(system, exploration);
    let steps = ExaminedSteps::of(system, exploration);
    let moving = machines.iter().zip(system.machines()).enumerate();
    for (index, (known, machine)) in moving.filter(|(_, (known, _))| known.name != OBSERVER) {
        let adviser = MachineAdviser {
            index,
            known,
            machine,
        };
        all.extend(adviser.values(&values));
        if let Some(steps) = &steps {
            all.extend(adviser.updates(steps));
            all.extend(adviser.inputs(steps));
        }
    }
    all.sort();
    all.dedup();
    (all, steps.is_some())
}

/// Properties of a file that are implications whose condition is true in no reachable state, whether they hold or not.
fn properties_about_nothing(
    prepared: &Prepared,
    exploration: &Exploration,
) -> Vec<SpecificationAdvice> {
    let mut all = Vec::new();
    for property in &prepared.properties {
        for condition in &property.antecedents {
            let truths = exploration.truths.get(*condition);
            let is_unreached = truths.is_some_and(Truths::is_empty);
            if let (true, Some(place), Some(text)) =
                (is_unreached, property.place, prepared.texts.get(*condition))
            {
                all.push(SpecificationAdvice {
                    machine: property.machine,
                    place,
                    kind: AdviceKind::UnreachedCondition,
                    text: format!(
                        "`{}` is about no reachable state: `{text}` is never true",
                        property.name.as_ref().unwrap_or(&property.text)
                    ),
                });
            }
        }
    }
    all
}

/// The values that the locations of functions have, with the machine.
struct OccurringValues(BTreeMap<(usize, FunctionId), BTreeSet<Value>>);

impl OccurringValues {
    fn of<S: TransitionSystem>(system: &S, exploration: &Exploration) -> Self {
        let mut system = system.clone();
        let mut found: BTreeMap<(usize, FunctionId), BTreeSet<Value>> = BTreeMap::new();
        let mut last = None;
        for node in 0..exploration.nodes() {
            let state = exploration.state_number(node);
            if state == last {
                continue;
            }
            last = state;
            system.restore(&exploration.state(node));
            for (index, machine) in system.machines().iter().enumerate() {
                for (function, _, slot) in machine.state().locations(machine.program()) {
                    let values = found.entry((index, function)).or_default();
                    let value = machine.state().get(slot);
                    if values.len() <= MAX_DOMAIN && !values.contains(value) {
                        values.insert(value.clone());
                    }
                }
            }
        }
        Self(found)
    }
}

/// The effects of all steps.
#[derive(Default)]
struct ExaminedSteps {
    /// Updates that were executed, and whether one of them changed a location.
    updates: BTreeMap<(usize, Origin), bool>,
    /// Inputs that were read.
    read: BTreeSet<(usize, FunctionId)>,
}

impl ExaminedSteps {
    /// Executes all steps again; `None` if there are too many.
    fn of<S: TransitionSystem>(system: &S, exploration: &Exploration) -> Option<Self> {
        let mut system = system.clone();
        let mut steps = Self::default();
        let decisions = Decisions::default();
        let mut executions = 0;
        for node in 0..exploration.nodes() {
            for input in exploration.inputs(node) {
                steps.read.insert((input.machine, input.function));
            }
            system.restore(&exploration.state(node));
            if system.has_ended() {
                continue;
            }
            decisions.restart();
            loop {
                executions += 1;
                if executions > MAX_EXAMINED {
                    return None;
                }
                system.restore(&exploration.state(node));
                // a step that fails has read its inputs, too
                let done = system.step(&decisions, exploration.inputs(node));
                for input in decisions.read() {
                    steps.read.insert((input.machine, input.function));
                }
                for &index in system.moved() {
                    let Some(machine) = system.machines().get(index).filter(|_| done.is_ok())
                    else {
                        continue;
                    };
                    let step = machine.last_step();
                    for (update, before) in step.updates().iter().zip(step.before()) {
                        let changes = steps.updates.entry((index, update.origin)).or_default();
                        *changes |= update.value != *before;
                    }
                }
                if !decisions.advance() {
                    break;
                }
            }
        }
        Some(steps)
    }
}

/// Gives advice about one machine.
struct MachineAdviser<'a> {
    index: usize,
    known: &'a VerifiedMachine,
    machine: &'a Machine,
}

impl MachineAdviser<'_> {
    fn advise(&self, kind: AdviceKind, place: Span, text: String) -> SpecificationAdvice {
        SpecificationAdvice {
            machine: self.index,
            place,
            kind,
            text,
        }
    }

    /// Branches that are never taken, of rules that are executed.
    fn branches(&self, counts: &[u64]) -> Vec<SpecificationAdvice> {
        let specification = &self.known.specification;
        let mut ran: BTreeMap<(Span, CoveragePoint), u64> = BTreeMap::new();
        for (counted, count) in specification.program.counted.iter().zip(counts) {
            let key = (specification.span(counted.origin), counted.part);
            *ran.entry(key).or_default() += count;
        }
        let mut all = Vec::new();
        for (&(span, part), &count) in &ran {
            let others = ran.range((span, CoveragePoint::Rule)..);
            let mut others = others.take_while(|((other, _), _)| *other == span);
            let is_reached = others.any(|(_, count)| *count > 0);
            if count == 0 && is_reached {
                all.extend(self.branch(span, part));
            }
        }
        all
    }

    fn branch(&self, span: Span, part: CoveragePoint) -> Option<SpecificationAdvice> {
        let specification = &self.known.specification;
        let text = |span| on_one_line(specification, span);
        let (rule, _) = rule_with(specification, span, &|kind| {
            matches!(
                kind,
                RuleKind::If(..) | RuleKind::Switch(..) | RuleKind::Choose(..)
            )
        })?;
        let words = match (&*rule.kind, part) {
            (RuleKind::If(guard, ..), CoveragePoint::Then) => {
                format!("`{}` is never true", text(guard.span))
            }
            (RuleKind::If(guard, ..), CoveragePoint::Else) => {
                format!("`{}` is always true", text(guard.span))
            }
            (RuleKind::Switch(subject, cases, _), CoveragePoint::Case(case)) => {
                let (case, _) = cases.get(case as usize)?;
                format!("`{}` is never {}", text(subject.span), text(case.span))
            }
            (RuleKind::Switch(subject, _, Some(_)), CoveragePoint::Otherwise) => {
                format!(
                    "`{}` never has another value than those of the cases",
                    text(subject.span)
                )
            }
            (RuleKind::Choose(..), CoveragePoint::Found) => {
                "this `choose` never has a candidate".to_owned()
            }
            (RuleKind::Choose(_, _, _, Some(_)), CoveragePoint::NotFound) => {
                "this `choose` always has a candidate: its `ifnone` never runs".to_owned()
            }
            _ => return None,
        };
        Some(self.advise(AdviceKind::UnreachedBranch, span, words))
    }

    /// Values that no location of an updated function has.
    fn values(&self, values: &OccurringValues) -> Vec<SpecificationAdvice> {
        let specification = &self.known.specification;
        let program = self.machine.program();
        let naming = self.machine.naming();
        let functions = specification.model.own_functions();
        let advice = functions.filter_map(|(id, function)| {
            let is_updated = matches!(function.kind, FunctionKind::Controlled | FunctionKind::Out)
                && matches!(function.meaning, Meaning::State);
            let compiled = program
                .functions
                .get(id.0 as usize)
                .filter(|_| is_updated)?;
            let all = self.machine.elements(&compiled.codomain, MAX_VALUES)?;
            let found = values.0.get(&(self.index, FunctionId(id.0)))?;
            if all.len() > MAX_DOMAIN {
                return None;
            }
            let missing = all.iter().filter(|value| !found.contains(value));
            let missing = missing.map(|value| value.show(&naming).to_string());
            let missing: Vec<String> = missing.collect();
            let text = format!("`{}` is never {}", function.name, missing.join(", "));
            (!missing.is_empty()).then(|| self.advise(AdviceKind::UnusedValue, function.span, text))
        });
        advice.collect()
    }

    /// Updates that never change anything.
    fn updates(&self, steps: &ExaminedSteps) -> Vec<SpecificationAdvice> {
        let specification = &self.known.specification;
        let updates = steps.updates.iter();
        let mut places: BTreeMap<Span, bool> = BTreeMap::new();
        for ((index, origin), changes) in updates {
            if *index == self.index {
                // the copies of a macro have the same place
                *places.entry(specification.span(*origin)).or_default() |= changes;
            }
        }
        let trivial = places.into_iter().filter(|(_, changes)| !changes);
        let advice = trivial.map(|(place, _)| {
            let text = format!(
                "`{}` never changes anything",
                on_one_line(specification, place)
            );
            self.advise(AdviceKind::TrivialUpdate, place, text)
        });
        advice.collect()
    }

    /// Inputs that nothing reads.
    fn inputs(&self, steps: &ExaminedSteps) -> Vec<SpecificationAdvice> {
        let functions = self.known.specification.model.own_functions();
        let unread = functions.filter(|(id, function)| {
            function.kind == FunctionKind::Monitored
                && !steps.read.contains(&(self.index, FunctionId(id.0)))
        });
        let advice = unread.map(|(_, function)| {
            let text = format!("no step reads `{}`", function.name);
            self.advise(AdviceKind::UnreadInput, function.span, text)
        });
        advice.collect()
    }
}
