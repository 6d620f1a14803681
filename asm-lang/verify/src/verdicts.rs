//! Verdicts: the properties, checked in everything that was explored.

use crate::counterexample::{NodePath, Replay};
use crate::formula::{Formula, Operator};
use crate::logic::{self, Checker, LogicError};
use crate::preparation::{Prepared, Property};
use crate::property::{CheckedProperty, Note, PropertyKind, Verdict};
use crate::transition::TransitionSystem;
use asmotion_lang::coverage::Coverage;
use asmotion_temporal::FairPaths;

/// A property that needs no graph, because it is about single nodes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum NodeProperty {
    /// Every node has it.
    All,
    /// Some node has it.
    Some,
}

impl Prepared {
    /// Returns `true` if a property needs the transitions.
    pub fn needs_graph(&self) -> bool {
        let mut properties = self.properties.iter();
        properties.any(|property| self.of_nodes(property).is_none())
    }

    /// Returns the condition that all nodes must have, or some node; `None` if the property is about paths.
    fn of_nodes<'a>(&self, property: &'a Property) -> Option<(NodeProperty, &'a Formula)> {
        if property.kind == PropertyKind::Invariant {
            return Some((NodeProperty::All, &property.formula));
        }
        if property.kind == PropertyKind::Possible {
            return Some((NodeProperty::Some, &property.formula));
        }
        // with fairness, properties are about fair paths
        let Formula::Apply(operator, operands) = &property.formula else {
            return None;
        };
        let [operand] = operands.as_slice() else {
            return None;
        };
        if !self.fairness.is_empty() || !operand.is_condition() {
            return None;
        }
        if matches!(operator, Operator::Ag | Operator::Globally) {
            Some((NodeProperty::All, operand))
        } else if *operator == Operator::Ef {
            Some((NodeProperty::Some, operand))
        } else {
            None
        }
    }
}

/// Checks the properties, of which only those with these names or texts, or all and the general ones if there are none.
pub(crate) fn verdicts<S: TransitionSystem>(
    prepared: &Prepared,
    replay: &Replay<'_, S>,
    only: &[String],
) -> Result<Vec<CheckedProperty>, LogicError> {
    let exploration = replay.exploration;
    let checker = if prepared.needs_graph() && exploration.incomplete.is_none() {
        Some(Checker::new(
            exploration,
            &prepared.fairness,
            &replay.system.fairness(),
        )?)
    } else {
        None
    };
    let is_wanted = |property: &&Property| {
        let is_it =
            |wanted: &String| Some(wanted) == property.name.as_ref() || *wanted == property.text;
        only.is_empty() || only.iter().any(is_it)
    };
    let judge = Judge {
        prepared,
        replay,
        checker,
    };
    let properties = prepared.properties.iter().filter(is_wanted);
    let mut checked = properties
        .map(|property| judge.property(property))
        .collect::<Result<Vec<CheckedProperty>, LogicError>>()?;
    if only.is_empty() {
        checked.extend([judge.faults(), judge.stuck(), judge.rules()]);
    }
    Ok(checked)
}

/// Everything that a verdict depends on.
struct Judge<'a, S> {
    prepared: &'a Prepared,
    replay: &'a Replay<'a, S>,
    /// `None` if no property needs it, or if not all transitions are known.
    checker: Option<Checker>,
}

impl<S: TransitionSystem> Judge<'_, S> {
    fn property(&self, property: &Property) -> Result<CheckedProperty, LogicError> {
        let mut notes = self.notes(property);
        let verdict = match (self.prepared.of_nodes(property), &self.checker) {
            (Some((which, formula)), _) => self.of_nodes(which, formula),
            (None, Some(checker)) => self.of_paths(property, checker, &mut notes)?,
            (None, None) => Verdict::Unknown,
        };
        if verdict.holds() {
            notes.extend(self.unmet(property));
        }
        Ok(CheckedProperty {
            kind: property.kind,
            machine: property.machine,
            name: property.name.clone(),
            text: property.text.clone(),
            place: property.place,
            verdict,
            notes,
        })
    }

    fn of_nodes(&self, which: NodeProperty, formula: &Formula) -> Verdict {
        let exploration = self.replay.exploration;
        let mut nodes = 0..exploration.nodes();
        let found = nodes.find(|node| {
            let holds = logic::is_true(formula, &exploration.truths, *node);
            holds == (which == NodeProperty::Some)
        });
        let run = found.map(|node| Box::new(self.replay.run(&NodePath::to(exploration, node))));
        match (which, run, exploration.incomplete) {
            (NodeProperty::All, Some(run), _) => Verdict::Violated(Some(run)),
            (NodeProperty::Some, Some(run), _) => Verdict::Holds(Some(run)),
            (_, None, Some(_)) => Verdict::Unknown,
            (NodeProperty::All, None, None) => Verdict::Holds(None),
            (NodeProperty::Some, None, None) => Verdict::Violated(None),
        }
    }

    fn of_paths(
        &self,
        property: &Property,
        checker: &Checker,
        notes: &mut Vec<Note>,
    ) -> Result<Verdict, LogicError> {
        let checked = checker.check(property.kind, &property.formula)?;
        match checked.fair {
            FairPaths::FromAll => {}
            FairPaths::FromSome => notes.push(Note::Unfair { all: false }),
            FairPaths::FromNone => notes.push(Note::Unfair { all: true }),
        }
        let run = |path: &NodePath| Box::new(self.replay.run(path));
        if let Some(path) = checked.path {
            return Ok(Verdict::Violated(Some(run(&path))));
        }
        let irrelevant: Vec<String> = checked
            .irrelevant
            .iter()
            .filter_map(|condition| self.prepared.texts.get(*condition).cloned())
            .collect();
        if !irrelevant.is_empty() && checked.fair != FairPaths::FromNone {
            notes.push(Note::Irrelevant(irrelevant));
        }
        Ok(Verdict::Holds(checked.witness.as_ref().map(run)))
    }

    /// Returns remarks on the values of a property's conditions.
    fn notes(&self, property: &Property) -> Vec<Note> {
        let exploration = self.replay.exploration;
        let mut notes = Vec::new();
        let mut undefined = 0;
        logic::visit_conditions(&property.formula, &mut |index| {
            if let Some(fault) = exploration.failed_terms.get(&index) {
                let machine = self.replay.machines.get(fault.machine);
                let diagnostic = machine.map(|it| fault.diagnostic(&it.specification, None));
                notes.extend(diagnostic.map(|it| Note::Fails(Box::new(it))));
            } else {
                undefined += exploration.undefined.get(index).copied().unwrap_or(0);
            }
        });
        if undefined > 0 {
            notes.push(Note::Undefined(undefined));
        }
        notes
    }

    /// Returns a remark on implications whose antecedents are never true.
    fn unmet(&self, property: &Property) -> Option<Note> {
        let truths = &self.replay.exploration.truths;
        let is_unmet = |index: &&usize| truths.get(**index).is_some_and(|it| it.is_empty());
        let unmet = property.antecedents.iter().filter(is_unmet);
        let unmet = unmet.filter_map(|index| self.prepared.texts.get(*index).cloned());
        let unmet: Vec<String> = unmet.collect();
        (!unmet.is_empty()).then_some(Note::Unmet(unmet))
    }

    fn faults(&self) -> CheckedProperty {
        let exploration = self.replay.exploration;
        let faults = exploration.faults.iter();
        let mut runs = faults.map(|found| {
            self.replay.run(&NodePath {
                nodes: exploration.path(found.node),
                labels: Vec::new(),
                cycle: None,
                failing: Some(found.decisions.clone()),
            })
        });
        let verdict = match (runs.next(), exploration.incomplete) {
            (Some(run), _) => Verdict::Violated(Some(Box::new(run))),
            (None, None) => Verdict::Holds(None),
            (None, Some(_)) => Verdict::Unknown,
        };
        let others: Vec<String> = runs
            .filter_map(|run| Some(run.steps.last()?.fault.as_ref()?.message.clone()))
            .collect();
        let notes = (!others.is_empty()).then_some(Note::Also(others));
        general(PropertyKind::NoFault, "no step fails", verdict, notes)
    }

    fn stuck(&self) -> CheckedProperty {
        let exploration = self.replay.exploration;
        let is_end = |node: u32| {
            let mut ends = self.prepared.ends.iter();
            ends.any(|ends| logic::is_true(ends, &exploration.truths, node))
        };
        let stuck = exploration.stuck.iter();
        let mut nodes = stuck.flat_map(|state| exploration.nodes_of(*state));
        let found = nodes.find(|node| !is_end(*node));
        let run = found.map(|node| Box::new(self.replay.run(&NodePath::to(exploration, node))));
        let verdict = match (run, exploration.incomplete) {
            (Some(run), _) => Verdict::Violated(Some(run)),
            (None, None) => Verdict::Holds(None),
            (None, Some(_)) => Verdict::Unknown,
        };
        general(PropertyKind::NotStuck, "no state is stuck", verdict, None)
    }

    fn rules(&self) -> CheckedProperty {
        let exploration = self.replay.exploration;
        let mut rules: Vec<String> = Vec::new();
        for (machine, counts) in self.replay.machines.iter().zip(&exploration.counts) {
            let coverage = Coverage::of(&machine.specification, counts);
            for (path, file) in &coverage.files {
                let never = file.rules.values().filter(|rule| rule.calls == 0);
                rules.extend(never.map(|rule| format!("{} ({path}:{})", rule.name, rule.line)));
            }
        }
        let verdict = match (rules.is_empty(), exploration.incomplete) {
            (true, _) => Verdict::Holds(None),
            (false, None) => Verdict::Violated(None),
            (false, Some(_)) => Verdict::Unknown,
        };
        let notes = (!rules.is_empty()).then_some(Note::Also(rules));
        general(PropertyKind::RulesRun, "every rule runs", verdict, notes)
    }
}

/// Returns a property that every specification should have.
fn general(
    kind: PropertyKind,
    text: &str,
    verdict: Verdict,
    note: Option<Note>,
) -> CheckedProperty {
    CheckedProperty {
        kind,
        machine: 0,
        name: None,
        text: text.to_owned(),
        place: None,
        verdict,
        notes: note.into_iter().collect(),
    }
}
