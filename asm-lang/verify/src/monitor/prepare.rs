//! From the properties of a specification to monitors.

use super::condition::WatchedCondition;
use super::within::{self, WithinComment};
use super::{
    GivenProperty, Monitors, PropertyWatch, ResponseWatch, UnwatchedProperty, WatchedProperty,
};
use crate::codes::m003::NoTemporalFormula;
use crate::formula::{Formula, Formulas};
use crate::logic::{self, LogicError, visit_conditions};
use crate::operator::{Logic, TemporalFunctions};
use crate::preparation::{self, report_of, text_of};
use crate::property::PropertyKind;
use asmotion_diagnostics::{Finding, Sources, Span};
use asmotion_lang::hir::{Expression, PropertyLogic, TemporalProperty};
use asmotion_lang::ir::AddedTerm;
use asmotion_lang::{Report, Specification};
use asmotion_temporal::{Ltl, Monitor, NotMonitorable, ResponseMonitor};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A property that may be watched, before its formula is examined.
struct MonitorCandidate {
    kind: PropertyKind,
    name: Option<String>,
    text: String,
    place: String,
    at: Option<Span>,
    within_ns: Option<i64>,
    /// The formula, or the reason for which it is none.
    formula: Result<Formula, String>,
}

impl Monitors {
    /// Creates the monitors of a specification: of its temporal properties, and of those that are given in addition. Their conditions
    /// are added to its program, for machines that are created afterwards. Invariants, and constraints that read inputs, are checked
    /// by the machine itself.
    ///
    /// # Errors
    /// A given property is no term of the specification, or a formula cannot be lowered.
    pub fn of(specification: &mut Specification, given: &[GivenProperty]) -> Result<Self, Report> {
        let mut terms = Vec::new();
        for property in given {
            let term = preparation::add(specification, &property.text)?;
            terms.push((property, term));
        }
        let has_properties = !specification.model.properties.is_empty();
        if terms.is_empty() && !has_properties {
            return Ok(Self::default());
        }
        // without a machine there is no run to watch; the same fault is reported when it starts
        let Ok(machine) = specification.machine() else {
            return Ok(Self::default());
        };
        let mut monitors = Self::default();
        let mut within = annotations(specification);
        let declared = std::mem::take(&mut specification.model.properties);
        let checked = checked_by_machine(specification, &declared);
        let mut preparation = MonitorPreparation {
            formulas: Formulas {
                temporal: TemporalFunctions::of(&specification.model),
                model: &mut specification.model,
                machine: &machine,
                first_condition: 0,
                conditions: Vec::new(),
                places: Vec::new(),
            },
            sources: &specification.sources,
            candidates: Vec::new(),
        };
        for (index, property) in declared.iter().enumerate() {
            if checked.contains(&index) {
                continue;
            }
            if let Some(kind) = kind(property.logic)
                && let Some(term) = property.formulas.first()
            {
                let name = property.name.as_ref().map(ToString::to_string);
                let time = take_within(&mut within, &declared, property.span);
                preparation.add(kind, name, term, property.span, time);
            }
        }
        for (property, term) in &terms {
            preparation.add_given(property, term);
        }
        let MonitorPreparation {
            formulas,
            candidates,
            ..
        } = preparation;
        let added: Vec<_> = formulas
            .conditions
            .into_iter()
            .zip(formulas.places)
            .collect();
        specification.model.properties = declared;
        let conditions = added.into_iter();
        let conditions =
            conditions.filter_map(|(term, place)| condition(specification, term, place));
        monitors.conditions = conditions.collect();
        candidates.into_iter().for_each(|it| monitors.add(it));
        monitors.add_unused(specification, within);
        specification.lower()?;
        Ok(monitors)
    }

    /// Watches a property, or notes why it is not watched.
    fn add(&mut self, candidate: MonitorCandidate) {
        let watch = candidate
            .formula
            .as_ref()
            .map_err(Clone::clone)
            .and_then(|formula| watch(candidate.kind, formula, candidate.within_ns));
        match watch {
            Ok((watch, unwatched)) => {
                self.watches.push(watch);
                Arc::make_mut(&mut self.watched).push(WatchedProperty {
                    kind: candidate.kind,
                    name: candidate.name,
                    text: candidate.text,
                    place: candidate.place,
                    at: candidate.at,
                    within_ns: candidate.within_ns,
                    unwatched,
                });
            }
            Err(reason) => Arc::make_mut(&mut self.unwatched).push(UnwatchedProperty {
                kind: candidate.kind,
                text: candidate.text,
                place: candidate.place,
                at: candidate.at,
                reason,
            }),
        }
    }

    /// Notes comments `//@Within` that have no effect.
    fn add_unused(&mut self, specification: &Specification, within: Vec<WithinComment>) {
        for comment in within {
            let reason = match comment.time_ns {
                Some(_) => "no property follows the comment",
                None => "its time is no positive number with the unit ms, s or min",
            };
            Arc::make_mut(&mut self.unwatched).push(UnwatchedProperty {
                kind: PropertyKind::Ctl,
                text: format!("//@Within {}", comment.text),
                place: place(&specification.sources, comment.at),
                at: Some(comment.at),
                reason: reason.to_owned(),
            });
        }
    }
}

/// The condition that was added to a specification as a term, from this place.
fn condition(
    specification: &Specification,
    term: AddedTerm,
    place: Span,
) -> Option<WatchedCondition> {
    let model = &specification.model;
    let body = model.added.terms.get(term.0 as usize)?;
    let text = text_of(&specification.sources, place);
    Some(WatchedCondition::new(model, term, &body.root, text))
}

/// The comments `//@Within` of the files with properties.
fn annotations(specification: &Specification) -> Vec<WithinComment> {
    let properties = specification.model.properties.iter();
    let main = specification.model.main;
    let main = main.map(|it| specification.model.rule(it).span.file);
    let files = properties.map(|it| it.span.file).chain(main);
    within::annotations(specification, files)
}

/// Returns the time of the last comment between the property before and this one, which is taken away.
fn take_within(
    within: &mut Vec<WithinComment>,
    declared: &[TemporalProperty],
    at: Span,
) -> Option<i64> {
    let is_before = |span: Span| span.file == at.file && span.start < at.start;
    let spans = declared.iter().map(|it| it.span);
    let previous = spans
        .filter(|span| is_before(*span))
        .map(|it| it.start)
        .max();
    let position = within.iter().rposition(|comment| {
        is_before(comment.at)
            && previous.is_none_or(|previous| comment.at.start > previous)
            && comment.time_ns.is_some()
    })?;
    within.remove(position).time_ns
}

/// Constraints that the machine checks.
fn checked_by_machine(
    specification: &Specification,
    declared: &[TemporalProperty],
) -> BTreeSet<usize> {
    let properties = declared.iter().enumerate();
    let checked = properties
        .filter(|(_, property)| asmotion_lang::ir::is_watched(&specification.model, property));
    checked.map(|(index, _)| index).collect()
}

fn kind(logic: PropertyLogic) -> Option<PropertyKind> {
    match logic {
        PropertyLogic::Ctl => Some(PropertyKind::Ctl),
        PropertyLogic::Ltl => Some(PropertyKind::Ltl),
        PropertyLogic::Constraint => Some(PropertyKind::Constraint),
        // they restrict the paths that a verification considers
        PropertyLogic::Justice | PropertyLogic::Compassion => None,
    }
}

/// Returns the file name and the line of a span.
fn place(sources: &Sources, span: Span) -> String {
    let path = sources.path(span.file);
    let name = path.rsplit('/').next().unwrap_or(path);
    let (line, _) = sources.position(span.file, span.start);
    format!("{name}:{line}")
}

/// Compiles a formula. Returns also the reasons for which parts of it are not watched.
fn watch(
    kind: PropertyKind,
    formula: &Formula,
    within_ns: Option<i64>,
) -> Result<(PropertyWatch, Vec<String>), String> {
    let (safety, response) = compiled(kind, formula)?;
    let response = within_ns.map(|within_ns| response.map(|it| (it, within_ns)));
    let response = match response {
        Some(None) => {
            return Err(
                "a time limits what follows a cause, as in `ag(p implies af(q))`, `g(p implies f(q))` or `af(q)`".to_owned(),
            );
        }
        Some(Some((monitor, within_ns))) => Some(ResponseWatch {
            state: monitor.begin(),
            monitor: Arc::new(monitor),
            after_step: None,
            within_ns,
        }),
        None => None,
    };
    let (safety, mut unwatched) = match (safety, &response) {
        (Ok(safety), _) => {
            let unwatched: Vec<NotMonitorable> = safety.unwatched().collect();
            (Some(safety), unwatched)
        }
        (Err(_), Some(_)) => (None, Vec::new()),
        (Err(reason), None) => return Err(reason.to_string()),
    };
    if response.is_some() {
        unwatched.retain(|it| *it != NotMonitorable::Liveness);
    }
    let mut conditions = BTreeSet::new();
    visit_conditions(formula, &mut |index| {
        conditions.insert(index);
    });
    let watch = PropertyWatch {
        safety: safety.map(|monitor| {
            let state = monitor.begin();
            (Arc::new(monitor), state)
        }),
        response,
        conditions: conditions.into_iter().collect(),
        is_stable: false,
        seen: 0,
        was_violated: false,
        is_violated: false,
        is_found: false,
        violated_steps: 0,
    };
    Ok((watch, unwatched.iter().map(ToString::to_string).collect()))
}

/// The safety part of a formula, and its responses.
type CompiledFormula = (Result<Monitor, NotMonitorable>, Option<ResponseMonitor>);

fn compiled(kind: PropertyKind, formula: &Formula) -> Result<CompiledFormula, String> {
    if kind == PropertyKind::Ctl {
        let formula = logic::ctl(formula).map_err(LogicError::reason)?;
        return Ok((Monitor::of_ctl(&formula), ResponseMonitor::of_ctl(&formula)));
    }
    let formula = logic::ltl(formula).map_err(LogicError::reason)?;
    if kind == PropertyKind::Ltl {
        return Ok((Monitor::of_ltl(&formula), ResponseMonitor::of_ltl(&formula)));
    }
    // a condition of every state
    Ok((Monitor::of_ltl(&Ltl::globally(formula)), None))
}

struct MonitorPreparation<'a> {
    formulas: Formulas<'a>,
    sources: &'a Sources,
    candidates: Vec<MonitorCandidate>,
}

impl MonitorPreparation<'_> {
    fn add(
        &mut self,
        kind: PropertyKind,
        name: Option<String>,
        term: &Expression,
        span: Span,
        within_ns: Option<i64>,
    ) {
        let formula = self.formula(kind, term);
        self.candidates.push(MonitorCandidate {
            kind,
            name,
            text: text_of(self.sources, term.root.span),
            place: place(self.sources, span),
            at: Some(span),
            within_ns,
            formula,
        });
    }

    fn add_given(&mut self, property: &GivenProperty, term: &Expression) {
        let kind = match self.formulas.logic(&term.root) {
            Some(Logic::Ctl) => PropertyKind::Ctl,
            Some(Logic::Ltl) => PropertyKind::Ltl,
            None => PropertyKind::Invariant,
        };
        let formula = self.formula(kind, term);
        self.candidates.push(MonitorCandidate {
            kind,
            name: None,
            text: property.text.clone(),
            place: String::new(),
            at: None,
            within_ns: property.within_ns,
            formula,
        });
    }

    fn formula(&mut self, kind: PropertyKind, term: &Expression) -> Result<Formula, String> {
        let logic = match kind {
            PropertyKind::Ctl => Logic::Ctl,
            PropertyKind::Invariant
            | PropertyKind::Constraint
            | PropertyKind::Ltl
            | PropertyKind::Possible
            | PropertyKind::NoFault
            | PropertyKind::NotStuck
            | PropertyKind::RulesRun => Logic::Ltl,
        };
        let formula = self.formulas.formula(&term.root, &term.variables, logic);
        formula.map_err(|problem| {
            let report = report_of(NoTemporalFormula { problem }.diagnostic());
            let first = report.diagnostics.into_iter().next();
            first.map(|it| it.message).unwrap_or_default()
        })
    }
}
