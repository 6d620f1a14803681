//! Verdicts: the properties, checked in everything that was explored.

use crate::counterexample::{NodePath, Replay, Run};
use crate::deciding::Deciding;
use crate::explore::Incomplete;
use crate::formula::Formula;
use crate::logic::{self, Checker, FairnessOfSteps, LogicError};
use crate::observer::OBSERVER;
use crate::operator::Operator;
use crate::preparation::{Prepared, Property};
use crate::property::{CheckedProperty, Note, PropertyKind, Verdict};
use crate::system::VerifiedMachine;
use crate::transition::TransitionSystem;
use asmotion_lang::coverage::Coverage;
use asmotion_temporal::FairPaths;

/// A property that needs no graph, because it is about single nodes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum NodeProperty {
    /// Every node has it.
    All,
    /// Some node has it.
    Some,
}

impl Prepared {
    /// Returns the text of the condition that is false at the end of a path that shows the violation of a formula.
    pub fn violated_at_end(&self, formula: &Formula) -> Option<String> {
        match formula {
            Formula::Condition(index) => {
                let text = self.texts.get(*index);
                // a variable of a quantifier has no meaning outside of it
                text.filter(|text| !text.contains('$')).cloned()
            }
            Formula::Apply(
                Operator::Ag | Operator::Ax | Operator::Globally | Operator::Next,
                operands,
            ) => self.violated_at_end(operands.first()?),
            Formula::Apply(Operator::Implies, operands) => match operands.as_slice() {
                [cause, effect] if cause.is_condition() && !effect.is_condition() => {
                    self.violated_at_end(effect)
                }
                _ => None,
            },
            Formula::Repeat(Operator::Ax, _, operand) => self.violated_at_end(operand),
            Formula::Constant(_) | Formula::Apply(..) | Formula::Repeat(..) => None,
        }
    }

    /// Returns `true` if a property needs the transitions.
    pub fn needs_graph(&self) -> bool {
        let mut properties = self.properties.iter();
        properties.any(|property| self.of_nodes(property).is_none())
    }

    /// Returns `true` if a property is about one initial state, with none of its inputs. A formula holds if it is true in all
    /// initial states.
    fn has_one_start(&self, property: &Property) -> bool {
        !self.has_several_starts && property.inputs.is_empty()
    }

    /// Returns the condition that all nodes must have, or some node; `None` if the property is about paths.
    pub fn of_nodes<'a>(&self, property: &'a Property) -> Option<(NodeProperty, &'a Formula)> {
        if matches!(
            property.kind,
            PropertyKind::Invariant | PropertyKind::Constraint
        ) {
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
        if self.has_fairness || !operand.is_condition() {
            return None;
        }
        if matches!(operator, Operator::Ag | Operator::Globally) {
            Some((NodeProperty::All, operand))
        } else if *operator == Operator::Ef && self.has_one_start(property) {
            Some((NodeProperty::Some, operand))
        } else {
            None
        }
    }
}

impl Property {
    /// Returns `true` if this is one of the properties with these names or texts, or if there are none.
    pub fn is_wanted(&self, only: &[String]) -> bool {
        let is_it = |wanted: &String| Some(wanted) == self.name.as_ref() || *wanted == self.text;
        only.is_empty() || only.iter().any(is_it)
    }
}

/// Checks the properties, of which only those with these names or texts, or all and the general ones if there are none.
pub(crate) fn verdicts<S: TransitionSystem>(
    prepared: &Prepared,
    replay: &Replay<'_, S>,
    only: &[String],
    deciding: &Deciding<'_>,
) -> Result<Vec<CheckedProperty>, LogicError> {
    let exploration = replay.exploration;
    // without transitions, no property that needs them is wanted
    let checker =
        if exploration.keeps_edges && prepared.needs_graph() && exploration.incomplete.is_none() {
            let fair = FairnessOfSteps {
                scheduled: &replay.system.fairness(),
                due: replay.fair,
            };
            let goes_on = |bytes| deciding.goes_on(bytes);
            match Checker::new(exploration, &prepared.fairness, fair, &goes_on) {
                Ok(checker) => Some(checker),
                Err(LogicError::Interrupted) => None,
                Err(error) => return Err(error),
            }
        } else {
            None
        };
    let judge = Judge {
        prepared,
        replay,
        checker,
        deciding,
    };
    let properties = prepared.properties.iter().filter(|it| it.is_wanted(only));
    let mut checked = properties
        .map(|property| judge.property(property))
        .collect::<Result<Vec<CheckedProperty>, LogicError>>()?;
    if only.is_empty() {
        checked.extend([judge.faults(), judge.stuck(), judge.rules()]);
    }
    Ok(checked)
}

/// Everything that a verdict depends on.
struct Judge<'a, 'd, S> {
    prepared: &'a Prepared,
    replay: &'a Replay<'a, S>,
    /// `None` if no property needs it, if not all transitions are known, or if a limit was reached before it was complete.
    checker: Option<Checker>,
    deciding: &'a Deciding<'d>,
}

impl<S: TransitionSystem> Judge<'_, '_, S> {
    fn property(&self, property: &Property) -> Result<CheckedProperty, LogicError> {
        let mut notes = self.notes(property);
        let verdict = match (self.prepared.of_nodes(property), &self.checker) {
            (Some((which, formula)), _) => self.of_nodes(which, formula),
            (None, Some(checker)) => self.of_paths(property, checker, &mut notes)?,
            (None, None) => {
                notes.extend(self.deciding.ended().map(Note::Undecided));
                Verdict::Unknown
            }
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
        let is_found = |node: &u32| {
            let holds = logic::is_true(formula, &exploration.truths, *node);
            holds == (which == NodeProperty::Some)
        };
        let mut run = self.simplest((0..exploration.nodes()).filter(is_found));
        if let Some(run) = run.as_mut().filter(|_| which == NodeProperty::All) {
            run.violated = self.prepared.violated_at_end(formula);
        }
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
        let goes_on = |bytes| self.deciding.goes_on(bytes);
        let checked = match checker.check(property.kind, &property.formula, &goes_on) {
            Ok(checked) => checked,
            Err(LogicError::Interrupted) => {
                notes.extend(self.deciding.ended().map(Note::Undecided));
                return Ok(Verdict::Unknown);
            }
            Err(error) => return Err(error),
        };
        match checked.fair {
            FairPaths::FromAll => {}
            FairPaths::FromSome => notes.push(Note::Unfair { all: false }),
            FairPaths::FromNone => notes.push(Note::Unfair { all: true }),
        }
        let run = |path: &NodePath| Box::new(self.replay.run(path));
        if let Some(path) = checked.path {
            if !self.replay.exploration.faults.is_empty() {
                notes.push(Note::FailingSteps);
            }
            let path = self.simplest_violation(property, path);
            let mut run = run(&path);
            if path.cycle.is_none() {
                run.violated = self.prepared.violated_at_end(&property.formula);
            }
            return Ok(Verdict::Violated(Some(run)));
        }
        if checked.irrelevant.is_none() {
            notes.extend(self.deciding.ended().map(Note::Unexamined));
        }
        let irrelevant = checked.irrelevant.iter().flatten();
        let irrelevant = irrelevant.filter_map(|it| self.prepared.texts.get(*it).cloned());
        let mut irrelevant: Vec<String> = irrelevant.collect();
        // a quantifier repeats its condition
        irrelevant.dedup();
        if !irrelevant.is_empty() && checked.fair != FairPaths::FromNone {
            notes.push(Note::Irrelevant(irrelevant));
        }
        Ok(Verdict::Holds(checked.witness.as_ref().map(run)))
    }

    /// Returns the simplest of the shortest runs to nodes, which are given in the order of their depth.
    fn simplest(&self, mut nodes: impl Iterator<Item = u32>) -> Option<Box<Run>> {
        let exploration = self.replay.exploration;
        let first = nodes.next()?;
        let depth = exploration.path(first).len() - 1;
        let level = exploration.level(depth);
        let goals: Vec<u32> = std::iter::once(first)
            .chain(nodes.take_while(|node| level.contains(node)))
            .collect();
        Some(Box::new(self.replay.run(&self.replay.simplest_to(&goals))))
    }

    /// Returns the simplest path with the lengths of a path that violates a property, and that violates it, too.
    fn simplest_violation(&self, property: &Property, path: NodePath) -> NodePath {
        let formula = &property.formula;
        let (exploration, fairness) = (self.replay.exploration, &self.prepared.fairness);
        let is_universal = property.kind == PropertyKind::Ltl || logic::is_universal(formula, true);
        if path.cycle.is_some() {
            let scheduled = self.replay.system.fairness();
            let fair = FairnessOfSteps {
                scheduled: &scheduled,
                due: self.replay.fair,
            };
            return self.replay.simplest_lasso(path, &|other| {
                let checker = Checker::of_path(exploration, fairness, fair, other);
                let violated = checker.and_then(|it| it.violates(property.kind, formula));
                is_universal && violated.unwrap_or_default()
            });
        }
        // the last node is what violates the operand of `ag`, whatever the way to it
        let is_about_end = matches!(formula, Formula::Apply(Operator::Ag, _));
        self.replay.simplest_end(path, &|_| is_about_end)
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
            let path = NodePath {
                nodes: exploration.path(found.node),
                failing: Some(found.decisions.clone()),
                ..NodePath::default()
            };
            self.replay.run(&self.replay.simplest_failing(path))
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
        let nodes = stuck.flat_map(|state| exploration.nodes_of(*state));
        let run = self.simplest(nodes.filter(|node| !is_end(*node)));
        let verdict = match (run, exploration.incomplete) {
            (Some(run), _) => Verdict::Violated(Some(run)),
            (None, None) => Verdict::Holds(None),
            (None, Some(_)) => Verdict::Unknown,
        };
        general(PropertyKind::NotStuck, "no state is stuck", verdict, None)
    }

    fn rules(&self) -> CheckedProperty {
        let exploration = self.replay.exploration;
        rules_run(
            self.replay.machines,
            &exploration.counts,
            exploration.incomplete,
        )
    }
}

/// Judges whether every rule runs, by the coverage counts of each machine.
pub(crate) fn rules_run(
    machines: &[VerifiedMachine],
    counts: &[Vec<u64>],
    incomplete: Option<Incomplete>,
) -> CheckedProperty {
    let mut rules: Vec<String> = Vec::new();
    let moving = machines.iter().zip(counts);
    for (machine, counts) in moving.filter(|(machine, _)| machine.name != OBSERVER) {
        let coverage = Coverage::of(&machine.specification, counts);
        for (path, file) in &coverage.files {
            let never = file.rules.values().filter(|rule| rule.calls == 0);
            rules.extend(never.map(|rule| format!("{} ({path}:{})", rule.name, rule.line)));
        }
    }
    let verdict = match (rules.is_empty(), incomplete) {
        (true, _) => Verdict::Holds(None),
        (false, None) => Verdict::Violated(None),
        (false, Some(_)) => Verdict::Unknown,
    };
    let notes = (!rules.is_empty()).then_some(Note::Also(rules));
    general(PropertyKind::RulesRun, "every rule runs", verdict, notes)
}

/// Returns a property that every specification should have.
pub(crate) fn general(
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
