//! Translates a scenario to actions: expands blocks, and resolves terms against the specification.

use crate::codes::v011::UnknownBlock;
use crate::codes::v012::UnknownScenario;
use crate::codes::v013::CircularBlock;
use crate::codes::v014::UnknownChoice;
use crate::codes::v015::UnknownChooseRule;
use crate::codes::v016::PicksUndef;
use crate::codes::v017::ScenarioTooLong;
use crate::codes::v018::ScenarioWithoutMain;
use crate::codes::v019::BlockCallsTooDeep;
use asmotion_diagnostics::{Finding, Report, Span, similar};
use asmotion_hir::{AddedRule, AddedTerm, Assignment, Model, RuleKind, TermKind};
use asmotion_syntax::ast::{
    NameText, Pick, PickedRule, Scenario, ScenarioCommand, ScenarioCommandKind,
};
use asmotion_value::Value;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Limit for the number of commands, with blocks expanded.
const MAX_ACTIONS: usize = 100_000;

/// Limit for the nesting of block calls.
const MAX_DEPTH: usize = 64;

/// The actions of a scenario, in order.
#[derive(Clone, Debug, Default)]
pub struct ScenarioPlan {
    pub(super) invariants: Vec<PlannedInvariant>,
    pub(super) actions: Vec<ScenarioAction>,
}

#[derive(Clone, Debug)]
pub(super) struct PlannedInvariant {
    pub name: Arc<str>,
    pub condition: PlannedCondition,
}

/// A condition, with the locations it reads: their values explain a failure.
#[derive(Clone, Debug)]
pub(super) struct PlannedCondition {
    pub term: AddedTerm,
    pub span: Span,
    pub parts: Vec<(AddedTerm, Span)>,
}

#[derive(Clone, Debug)]
pub(super) struct ScenarioAction {
    pub kind: ScenarioActionKind,
    pub span: Span,
}

#[derive(Clone, Debug)]
pub(super) enum ScenarioActionKind {
    Set(Assignment),
    Check(PlannedCondition),
    Step,
    StepUntil(PlannedCondition),
    Exec(AddedRule),
    Pick {
        /// Spans of the picked variables' ranges.
        ranges: Vec<Span>,
        value: AddedTerm,
    },
}

impl ScenarioPlan {
    /// Translates a scenario. Its terms and rules are added to the model of its specification.
    /// `other` returns the scenario with a name, for blocks run from another file. In a model read
    /// as by AsmetaV, all `set`s between two steps precede the checks and `exec`s.
    ///
    /// # Errors
    /// A term does not fit the specification, or a block or choice is unknown. All errors are
    /// reported.
    pub fn of(
        scenario: &Scenario,
        model: &mut Model,
        other: &mut dyn FnMut(&str) -> Option<Arc<Scenario>>,
    ) -> Result<Self, Report> {
        let mut planning = ScenarioPlanner {
            model,
            other,
            plan: Self::default(),
            report: Report::new(),
            open: Vec::new(),
            written: 0,
        };
        if let (None, Some(load)) = (planning.model.main, &scenario.load) {
            let name = planning.model.name.to_string();
            planning.error(ScenarioWithoutMain {
                name,
                at: load.span,
            });
        }
        for invariant in &scenario.invariants {
            if let Some(condition) = planning.condition(&invariant.condition, "an invariant") {
                let name = invariant.name.text.clone();
                planning
                    .plan
                    .invariants
                    .push(PlannedInvariant { name, condition });
            }
        }
        planning.commands(scenario, &scenario.commands);
        if planning.report.has_errors() {
            return Err(planning.report.finish());
        }
        let mut plan = planning.plan;
        if model.compatible {
            plan.settings_first();
        }
        Ok(plan)
    }

    /// Returns the number of checks.
    pub fn checks(&self) -> usize {
        let is_check =
            |action: &&ScenarioAction| matches!(action.kind, ScenarioActionKind::Check(_));
        self.actions.iter().filter(is_check).count()
    }

    /// Moves the `set`s between two steps before the other commands.
    fn settings_first(&mut self) {
        for between in self.actions.split_inclusive_mut(|action| {
            matches!(
                action.kind,
                ScenarioActionKind::Step | ScenarioActionKind::StepUntil(_)
            )
        }) {
            between.sort_by_key(|action| match action.kind {
                ScenarioActionKind::Set(_) | ScenarioActionKind::Pick { .. } => 0,
                ScenarioActionKind::Check(_) | ScenarioActionKind::Exec(_) => 1,
                ScenarioActionKind::Step | ScenarioActionKind::StepUntil(_) => 2,
            });
        }
    }
}

struct ScenarioPlanner<'a> {
    model: &'a mut Model,
    other: &'a mut dyn FnMut(&str) -> Option<Arc<Scenario>>,
    plan: ScenarioPlan,
    report: Report,
    /// Names of the blocks that are being expanded.
    open: Vec<Arc<str>>,
    /// Number of commands so far, counting those of a block each time it is run.
    written: usize,
}

impl ScenarioPlanner<'_> {
    fn error(&mut self, error: impl Finding) {
        let finding = error.diagnostic();
        let is_limit = finding.is_any(&[ScenarioTooLong::CODE, BlockCallsTooDeep::CODE]);
        // each error is reported once, even if the block runs several times
        let is_known = self
            .report
            .diagnostics
            .iter()
            .any(|known| *known == finding || is_limit && known.code == finding.code);
        if !is_known {
            self.report.push(finding);
        }
    }

    fn collect_errors<T>(&mut self, added: Result<T, Report>) -> Option<T> {
        match added {
            Ok(added) => Some(added),
            Err(report) => {
                self.report.extend(report);
                None
            }
        }
    }

    fn commands(&mut self, scenario: &Scenario, commands: &[ScenarioCommand]) {
        for command in commands {
            if self.written >= MAX_ACTIONS {
                return;
            }
            self.written += 1;
            self.command(scenario, command);
            if self.written == MAX_ACTIONS {
                self.error(ScenarioTooLong {
                    at: command.span,
                    limit: MAX_ACTIONS,
                });
            }
        }
    }

    fn command(&mut self, scenario: &Scenario, command: &ScenarioCommand) {
        let kind = match &command.kind {
            ScenarioCommandKind::Set(target, value) => {
                let added = self.model.add_assignment(target, value);
                self.collect_errors(added).map(ScenarioActionKind::Set)
            }
            ScenarioCommandKind::Check(term) => self
                .condition(term, "a check")
                .map(ScenarioActionKind::Check),
            ScenarioCommandKind::Step => Some(ScenarioActionKind::Step),
            ScenarioCommandKind::StepUntil(term) => self
                .condition(term, "the end of `step until`")
                .map(ScenarioActionKind::StepUntil),
            ScenarioCommandKind::Exec(rule) => {
                let added = self.model.add_rule(rule);
                self.collect_errors(added).map(ScenarioActionKind::Exec)
            }
            ScenarioCommandKind::Pick(pick) => self.pick(pick),
            ScenarioCommandKind::Block(block) => {
                self.commands(scenario, &block.commands);
                None
            }
            ScenarioCommandKind::ExecBlock {
                scenario: from,
                block,
            } => {
                match from {
                    None => self.block(scenario, block, None),
                    Some(from) => match (self.other)(&from.text) {
                        Some(other) => self.block(&other, block, Some(&from.text)),
                        None => self.error(UnknownScenario {
                            name: from.text.to_string(),
                            at: from.span,
                        }),
                    },
                }
                None
            }
        };
        let span = command.span;
        self.plan
            .actions
            .extend(kind.map(|kind| ScenarioAction { kind, span }));
    }

    fn block(&mut self, scenario: &Scenario, name: &NameText, from: Option<&str>) {
        let Some(block) = scenario.block(&name.text) else {
            let blocks = scenario.blocks();
            let known = blocks.iter().map(|block| &block.name.text);
            return self.error(UnknownBlock {
                name: name.text.to_string(),
                at: name.span,
                scenario: from.map(str::to_owned),
                similar: similar(&name.text, known).cloned(),
            });
        };
        let place: Arc<str> = format!("{:?} {}", block.name.span, name.text).into();
        if self.open.contains(&place) {
            return self.error(CircularBlock {
                name: name.text.to_string(),
                at: name.span,
            });
        }
        if self.open.len() >= MAX_DEPTH {
            let (at, limit) = (name.span, MAX_DEPTH);
            return self.error(BlockCallsTooDeep { at, limit });
        }
        self.open.push(place);
        self.commands(scenario, &block.commands);
        self.open.pop();
    }

    fn condition(
        &mut self,
        term: &asmotion_syntax::ast::Term,
        what: &str,
    ) -> Option<PlannedCondition> {
        let added = self.model.add_condition(term, what);
        let added = self.collect_errors(added)?;
        Some(PlannedCondition {
            term: added,
            span: term.span,
            parts: self.parts(added),
        })
    }

    /// Returns the subterms that apply functions of the specification and contain no bound
    /// variable.
    fn parts(&mut self, term: AddedTerm) -> Vec<(AddedTerm, Span)> {
        let model = &*self.model;
        let root = &model.added.terms[term.0 as usize].root;
        let mut found = Vec::new();
        asmotion_ir::visit_terms(root, &mut |part| {
            if let TermKind::Apply(function, _) | TermKind::Spread(function, _) = &*part.kind {
                let function = model.function(*function);
                let is_own = !function.library
                    && matches!(
                        function.meaning,
                        asmotion_hir::Meaning::State | asmotion_hir::Meaning::Defined(_)
                    );
                if is_own && part.span != root.span && is_closed(part) {
                    found.push(part.clone());
                }
            }
        });
        let added = found.into_iter().map(|part| {
            let span = part.span;
            (self.model.add_part(term, part), span)
        });
        added.collect()
    }

    fn pick(&mut self, pick: &Pick) -> Option<ScenarioActionKind> {
        let ranges = self.ranges(pick)?;
        let added = self.model.add_term(&pick.value);
        let value = self.collect_errors(added)?;
        let root = &self.model.added.terms[value.0 as usize].root;
        if matches!(*root.kind, TermKind::Value(Value::Undef)) {
            self.error(PicksUndef {
                at: pick.value.span,
            });
            return None;
        }
        Some(ScenarioActionKind::Pick { ranges, value })
    }

    /// Returns the spans of the picked variable's ranges in all `choose` rules that the pick refers
    /// to.
    fn ranges(&mut self, pick: &Pick) -> Option<Vec<Span>> {
        let model = &*self.model;
        let rules: Vec<&asmotion_hir::Rule> = match &pick.rule {
            None => model.rules.iter().collect(),
            Some(wanted) => picked_rules(model, wanted),
        };
        let (mut found, mut known) = (Vec::new(), Vec::new());
        for body in rules.iter().filter_map(|rule| rule.body.as_ref()) {
            asmotion_ir::visit_rules(&body.root, &mut |rule| {
                let RuleKind::Choose(binders, ..) = &*rule.kind else {
                    return;
                };
                for binder in binders {
                    let variable = &body.variables[binder.variable.0 as usize];
                    if variable.name == pick.variable.text {
                        found.push(binder.range.span)
                    } else {
                        known.push(variable.name.clone())
                    }
                }
            });
        }
        if let (Some(wanted), true) = (&pick.rule, rules.is_empty()) {
            let known = model.rules.iter().filter(|rule| !rule.library);
            let similar = similar(&wanted.name.text, known.map(|rule| &rule.name)).cloned();
            self.error(UnknownChooseRule {
                name: wanted.name.text.to_string(),
                at: wanted.name.span,
                similar,
            });
            return None;
        }
        if found.is_empty() {
            self.error(UnknownChoice {
                variable: pick.variable.text.to_string(),
                rule: pick.rule.as_ref().map(|rule| rule.name.text.to_string()),
                at: pick.variable.span,
                similar: similar(&pick.variable.text, &known).cloned(),
            });
            return None;
        }
        Some(found)
    }
}

/// Returns the rules that a pick refers to. A name without domains refers to the rule without
/// parameters, if there is one.
fn picked_rules<'a>(model: &'a Model, picked: &PickedRule) -> Vec<&'a asmotion_hir::Rule> {
    let named = model
        .rules
        .iter()
        .filter(|rule| rule.name == picked.name.text);
    let takes = |rule: &&asmotion_hir::Rule, domains: &[NameText]| {
        let shown = rule.parameters.iter().map(|&ty| model.show_type(ty));
        shown.eq(domains.iter().map(|name| name.text.replace(' ', "")))
    };
    match &picked.parameters {
        Some(domains) => named.filter(|rule| takes(rule, domains)).collect(),
        None => {
            let alone: Vec<_> = named.clone().filter(|rule| takes(rule, &[])).collect();
            if alone.is_empty() {
                named.collect()
            } else {
                alone
            }
        }
    }
}

/// Returns `true` if a term contains no free variables.
fn is_closed(term: &asmotion_hir::Term) -> bool {
    let (mut used, mut bound) = (BTreeSet::new(), BTreeSet::new());
    asmotion_ir::visit_terms(term, &mut |term| match &*term.kind {
        TermKind::Variable(variable) => {
            used.insert(*variable);
        }
        TermKind::Let(bindings, _) => bound.extend(bindings.iter().map(|(variable, _)| *variable)),
        TermKind::Quantified(_, binders, _)
        | TermKind::Comprehension(_, binders, ..)
        | TermKind::MapComprehension(binders, ..) => {
            bound.extend(binders.iter().map(|binder| binder.variable));
        }
        TermKind::Value(_)
        | TermKind::Apply(..)
        | TermKind::Spread(..)
        | TermKind::Tuple(_)
        | TermKind::If(..)
        | TermKind::Switch(..)
        | TermKind::Listed(..)
        | TermKind::Interval(..)
        | TermKind::Map(_)
        | TermKind::Rule(_)
        | TermKind::Extent(_)
        | TermKind::Element(..)
        | TermKind::Unbound
        | TermKind::Invalid => {}
    });
    used.is_subset(&bound)
}
