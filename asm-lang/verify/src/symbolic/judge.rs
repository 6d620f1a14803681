//! Verdicts about sets of states.

use super::Symbolic;
use super::walk::Walker;
use crate::counterexample::Run;
use crate::explore::Incomplete;
use crate::formula::Formula;
use crate::logic::{self, FairnessFormula};
use crate::operator::Operator;
use crate::preparation::Property;
use crate::property::{CheckedProperty, Note, PropertyKind, Verdict};
use crate::verdicts::{NodeProperty, general, rules_run};
use asmotion_lang::Report;
use asmotion_symbolic::{
    NodeSet, Reached, SymbolicError, SymbolicFairness, SymbolicFormula, SymbolicModel,
};
use asmotion_temporal::{FairPaths, vacuity_ctl_by, vacuity_ltl_by};
use std::cell::{Cell, OnceCell};

/// Limit for the states of which a graph is built, to show a run.
const MAX_STATES: u64 = 200_000;

/// Everything that a verdict depends on.
pub(super) struct SymbolicJudge<'a> {
    symbolic: &'a Symbolic<'a>,
    model: &'a SymbolicModel<'a>,
    reached: &'a Reached,
    proceed: &'a dyn Fn() -> bool,
    /// The limit that was reached while properties were decided.
    ended: Cell<Option<Incomplete>>,
    /// The properties checked with single states, for runs that violate temporal formulas.
    explored: OnceCell<Vec<CheckedProperty>>,
}

impl<'a> SymbolicJudge<'a> {
    pub fn new(
        symbolic: &'a Symbolic<'a>,
        model: &'a SymbolicModel<'a>,
        reached: &'a Reached,
        proceed: &'a dyn Fn() -> bool,
    ) -> Self {
        Self {
            symbolic,
            model,
            reached,
            proceed,
            ended: Cell::new(None),
            explored: OnceCell::new(),
        }
    }

    /// Checks the properties that are wanted.
    pub fn verdicts(&self) -> Result<Vec<CheckedProperty>, Report> {
        let mut checked = Vec::new();
        for property in wanted(self.symbolic) {
            let mut notes = Vec::new();
            let verdict = self.known(self.property(property, &mut notes))?;
            if verdict.is_none() {
                notes.extend(self.undecided());
            }
            checked.push(as_checked(
                property,
                verdict.unwrap_or(Verdict::Unknown),
                notes,
            ));
        }
        if self.symbolic.options.only.is_empty() {
            let properties = [self.faults(), self.stuck(), self.rules()];
            for (property, (kind, text)) in properties.into_iter().zip(GENERAL) {
                let known = self.known(property)?;
                let unknown = || general(kind, text, Verdict::Unknown, self.undecided());
                checked.push(known.unwrap_or_else(unknown));
            }
        }
        Ok(checked)
    }

    /// Returns the remark on a property that was not decided although all states are known.
    fn undecided(&self) -> Option<Note> {
        let ended = self.ended.get().filter(|_| self.is_complete());
        ended.map(Note::Undecided)
    }

    /// Returns a result unless the memory or the time was not sufficient for it.
    fn known<T>(&self, result: Result<T, SymbolicError>) -> Result<Option<T>, Report> {
        match result {
            Ok(result) => Ok(Some(result)),
            Err(SymbolicError::Memory) => {
                self.ended.set(Some(Incomplete::Memory));
                Ok(None)
            }
            Err(SymbolicError::Stopped) => {
                self.ended.set(Some(Incomplete::Stopped));
                Ok(None)
            }
            Err(error) => Err(self.symbolic.explain(error)),
        }
    }

    fn is_complete(&self) -> bool {
        self.reached.limit.is_none()
    }

    fn property(
        &self,
        property: &Property,
        notes: &mut Vec<Note>,
    ) -> Result<Verdict, SymbolicError> {
        self.notes(property, notes)?;
        let prepared = self.symbolic.properties;
        let verdict = match prepared.of_nodes(property) {
            Some((which, formula)) => self.of_nodes(which, formula)?,
            None if self.is_complete() => self.of_paths(property, notes)?,
            None => Verdict::Unknown,
        };
        if verdict.holds() {
            notes.extend(self.unmet(property)?);
        }
        Ok(verdict)
    }

    /// Returns the reached nodes in which a formula without temporal operators is true.
    fn nodes_of(&self, formula: &Formula) -> Result<NodeSet, SymbolicError> {
        let (model, reached) = (self.model, self.reached);
        let not = |set: &NodeSet| model.complement(reached, set);
        match formula {
            Formula::Constant(true) => Ok(model.all(reached)),
            Formula::Constant(false) | Formula::Repeat(..) => not(&model.all(reached)),
            Formula::Condition(index) => model.condition(reached, *index),
            Formula::Apply(operator, operands) => {
                let mut sets = Vec::new();
                for operand in operands {
                    sets.push(self.nodes_of(operand)?);
                }
                match (operator, sets.as_slice()) {
                    (Operator::Not, [operand]) => not(operand),
                    (Operator::Implies, [left, right]) => model.union(&not(left)?, right),
                    (Operator::Iff, [left, right]) => {
                        let both = model.intersection(left, right)?;
                        let neither = model.intersection(&not(left)?, &not(right)?)?;
                        model.union(&both, &neither)
                    }
                    (Operator::Or, sets) => {
                        let none = not(&model.all(reached))?;
                        sets.iter()
                            .try_fold(none, |any, set| model.union(&any, set))
                    }
                    (Operator::And, sets) => {
                        let all = model.all(reached);
                        sets.iter()
                            .try_fold(all, |all, set| model.intersection(&all, set))
                    }
                    _ => not(&model.all(reached)),
                }
            }
        }
    }

    fn of_nodes(&self, which: NodeProperty, formula: &Formula) -> Result<Verdict, SymbolicError> {
        let mut set = self.nodes_of(formula)?;
        if which == NodeProperty::All {
            set = self.model.complement(self.reached, &set)?;
        }
        let mut run = self.of_set(&set)?;
        if let (NodeProperty::All, Some(Some(run))) = (which, &mut run) {
            run.violated = self.symbolic.properties.violated_at_end(formula);
        }
        Ok(match (which, run, self.is_complete()) {
            (NodeProperty::All, Some(run), _) => Verdict::Violated(run),
            (NodeProperty::Some, Some(run), _) => Verdict::Holds(run),
            (_, None, false) => Verdict::Unknown,
            (NodeProperty::All, None, true) => Verdict::Holds(None),
            (NodeProperty::Some, None, true) => Verdict::Violated(None),
        })
    }

    fn of_paths(
        &self,
        property: &Property,
        notes: &mut Vec<Note>,
    ) -> Result<Verdict, SymbolicError> {
        let mut fairness = Vec::new();
        for constraint in &self.symbolic.properties.fairness {
            fairness.push(match constraint {
                FairnessFormula::Justice(often) => SymbolicFairness::Justice(self.nodes_of(often)?),
                FairnessFormula::Compassion(cause, effect) => {
                    SymbolicFairness::Compassion(self.nodes_of(cause)?, self.nodes_of(effect)?)
                }
            });
        }
        let ltl = logic::ltl(&property.formula);
        let ctl = logic::ctl(&property.formula);
        let formula = match (property.kind, &ltl, &ctl) {
            (PropertyKind::Ltl, Ok(formula), _) => SymbolicFormula::Ltl(formula),
            (_, _, Ok(formula)) => SymbolicFormula::Ctl(formula),
            (_, _, Err(_)) => return Ok(Verdict::Unknown),
        };
        let checked = self.model.check(self.reached, &formula, &fairness)?;
        match checked.fair {
            FairPaths::FromAll => {}
            FairPaths::FromSome => notes.push(Note::Unfair { all: false }),
            FairPaths::FromNone => notes.push(Note::Unfair { all: true }),
        }
        if !checked.violated.is_empty() {
            if !self.model.faults(self.reached)?.is_empty() {
                notes.push(Note::FailingSteps);
            }
            return Ok(Verdict::Violated(self.run_of_paths(property)?));
        }
        if checked.fair != FairPaths::FromNone {
            notes.extend(self.irrelevant(property, &formula, &fairness));
        }
        Ok(Verdict::Holds(None))
    }

    /// Returns a remark on conditions whose values do not matter for a formula that holds; none if the memory or the time is not
    /// sufficient to find them.
    fn irrelevant(
        &self,
        property: &Property,
        formula: &SymbolicFormula<'_>,
        fairness: &[SymbolicFairness],
    ) -> Option<Note> {
        let holds = |formula: SymbolicFormula<'_>| {
            let checked = self.model.check(self.reached, &formula, fairness)?;
            Ok::<bool, SymbolicError>(checked.violated.is_empty())
        };
        let vacuity = match formula {
            SymbolicFormula::Ctl(formula) => {
                vacuity_ctl_by(formula, |it| holds(SymbolicFormula::Ctl(it)))
            }
            SymbolicFormula::Ltl(formula) => {
                vacuity_ltl_by(formula, |it| holds(SymbolicFormula::Ltl(it)))
            }
        };
        let vacuity = vacuity.ok()?;
        let irrelevant: Vec<usize> = vacuity.irrelevant.iter().map(|it| it.atom).collect();
        let irrelevant = property.formula.with_all_occurrences(&irrelevant);
        let texts = irrelevant.iter();
        let texts = texts.filter_map(|it| self.symbolic.properties.texts.get(*it).cloned());
        let mut texts: Vec<String> = texts.collect();
        // a quantifier repeats its condition
        texts.dedup();
        (!texts.is_empty()).then_some(Note::Irrelevant(texts))
    }

    /// Returns a run that violates a temporal formula, from the graph of single states if there are not too many.
    fn run_of_paths(&self, property: &Property) -> Result<Option<Box<Run>>, SymbolicError> {
        let counts = self.model.counts(self.reached)?;
        let is_small = |count: Option<u64>| count.is_some_and(|count| count <= MAX_STATES);
        if !is_small(counts.states) || !is_small(counts.transitions.map(|it| it / 8)) {
            return Ok(None);
        }
        let explored = self
            .explored
            .get_or_init(|| self.symbolic.explored(self.proceed));
        let mut explored = explored.iter();
        let same = explored.find(|it| it.kind == property.kind && it.text == property.text);
        Ok(same.and_then(|it| it.verdict.run()).cloned().map(Box::new))
    }

    /// Adds remarks on the values of a property's conditions.
    fn notes(&self, property: &Property, notes: &mut Vec<Note>) -> Result<(), SymbolicError> {
        let mut conditions = Vec::new();
        logic::visit_conditions(&property.formula, &mut |index| conditions.push(index));
        let mut undefined = 0_u64;
        for index in conditions {
            let (count, fails) = self.model.undefined(self.reached, index)?;
            if !fails {
                undefined = undefined.saturating_add(count);
            } else if let Some(diagnostic) = self.walker().failed_condition(self.reached, index)? {
                notes.push(Note::Fails(Box::new(diagnostic)));
            }
        }
        if undefined > 0 {
            notes.push(Note::Undefined(undefined));
        }
        Ok(())
    }

    /// Returns a remark on implications whose antecedents are never true.
    fn unmet(&self, property: &Property) -> Result<Option<Note>, SymbolicError> {
        let mut unmet = Vec::new();
        for index in &property.antecedents {
            if self.model.condition(self.reached, *index)?.is_empty() {
                unmet.extend(self.symbolic.properties.texts.get(*index).cloned());
            }
        }
        Ok((!unmet.is_empty()).then_some(Note::Unmet(unmet)))
    }

    fn faults(&self) -> Result<CheckedProperty, SymbolicError> {
        let mut found = Vec::new();
        for fault in self.model.faults(self.reached)? {
            if let Some(sets) = self.model.shortest(self.reached, &fault.nodes)? {
                found.push((sets, fault));
            }
        }
        found.sort_by_key(|(sets, fault)| (sets.len(), fault.origin, fault.class));
        let mut runs = Vec::new();
        for (sets, fault) in &found {
            let mut walker = self.walker();
            let mut walk = self.shown(walker.walk(sets))?.flatten();
            if let Some(walk) = &mut walk {
                self.shown(walker.fail(walk, fault))?;
            }
            runs.push(walk.map(|walk| self.symbolic.replay(walk)));
        }
        let mut runs = runs.into_iter();
        let verdict = match (runs.next(), self.is_complete()) {
            (Some(run), _) => Verdict::Violated(run.map(Box::new)),
            (None, true) => Verdict::Holds(None),
            (None, false) => Verdict::Unknown,
        };
        let others: Vec<String> = runs
            .flatten()
            .filter_map(|run| Some(run.steps.last()?.fault.as_ref()?.message.clone()))
            .collect();
        let note = (!others.is_empty()).then_some(Note::Also(others));
        let (kind, text) = GENERAL[0];
        Ok(general(kind, text, verdict, note))
    }

    fn stuck(&self) -> Result<CheckedProperty, SymbolicError> {
        let mut stuck = self.model.stuck(self.reached)?;
        for end in &self.symbolic.properties.ends {
            let elsewhere = self.model.complement(self.reached, &self.nodes_of(end)?)?;
            stuck = self.model.intersection(&stuck, &elsewhere)?;
        }
        let verdict = match self.of_set(&stuck)? {
            Some(run) => Verdict::Violated(run),
            None if self.is_complete() => Verdict::Holds(None),
            None => Verdict::Unknown,
        };
        let (kind, text) = GENERAL[1];
        Ok(general(kind, text, verdict, None))
    }

    /// Returns a shortest run to a set of nodes, if a reached node is in it.
    fn of_set(&self, set: &NodeSet) -> Result<Option<Option<Box<Run>>>, SymbolicError> {
        let Some(sets) = self.model.shortest(self.reached, set)? else {
            return Ok(None);
        };
        let walk = self.shown(self.walker().walk(&sets))?.flatten();
        Ok(Some(walk.map(|walk| Box::new(self.symbolic.replay(walk)))))
    }

    fn walker(&self) -> Walker<'_> {
        Walker::new(self.symbolic, self.model, self.proceed)
    }

    /// Returns a run, unless the memory or the time was not sufficient to find it: the verdict that it shows is known.
    fn shown<T>(&self, run: Result<T, SymbolicError>) -> Result<Option<T>, SymbolicError> {
        match run {
            Ok(run) => Ok(Some(run)),
            Err(SymbolicError::Memory | SymbolicError::Stopped) => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn rules(&self) -> Result<CheckedProperty, SymbolicError> {
        let program = self.symbolic.machine.program();
        let mut counts = vec![0; program.counted.len()];
        for (counter, is_executed) in self.model.executed(self.reached)? {
            if let Some(count) = counts.get_mut(counter as usize) {
                *count = u64::from(is_executed);
            }
        }
        let incomplete = self.reached.limit.map(Incomplete::from);
        Ok(rules_run(self.symbolic.known, &[counts], incomplete))
    }
}

/// The properties that every specification should have.
const GENERAL: [(PropertyKind, &str); 3] = [
    (PropertyKind::NoFault, "no step fails"),
    (PropertyKind::NotStuck, "no state is stuck"),
    (PropertyKind::RulesRun, "every rule runs"),
];

/// Returns the properties that are wanted.
fn wanted<'a>(symbolic: &'a Symbolic<'_>) -> impl Iterator<Item = &'a Property> {
    let only = &symbolic.options.only;
    let is_wanted = move |property: &&Property| {
        let is_it =
            |wanted: &String| Some(wanted) == property.name.as_ref() || *wanted == property.text;
        only.is_empty() || only.iter().any(is_it)
    };
    symbolic.properties.properties.iter().filter(is_wanted)
}

fn as_checked(property: &Property, verdict: Verdict, notes: Vec<Note>) -> CheckedProperty {
    CheckedProperty {
        kind: property.kind,
        machine: property.machine,
        name: property.name.clone(),
        text: property.text.clone(),
        place: property.place,
        verdict,
        notes,
    }
}

/// Returns the properties without verdicts.
pub(super) fn unknown(symbolic: &Symbolic<'_>) -> Vec<CheckedProperty> {
    let properties = wanted(symbolic);
    let properties = properties.map(|it| as_checked(it, Verdict::Unknown, Vec::new()));
    let mut all: Vec<CheckedProperty> = properties.collect();
    if symbolic.options.only.is_empty() {
        let general = GENERAL.map(|(kind, text)| general(kind, text, Verdict::Unknown, None));
        all.extend(general);
    }
    all
}
