//! Fairness that is due to agents and rules: from comments `//@Fair NAME…` and `//@StronglyFair NAME…`, and from outside.

use crate::codes::m020::UnknownFairName;
use crate::codes::main_rule;
use crate::fair_moves::{FairMove, FairMoves, MAX_FAIR_MOVES, MovedBy};
use crate::inputs::MAX_VALUES;
use crate::options::FairName;
use crate::preparation::report_of;
use crate::system::VerifiedMachine;
use asmotion_diagnostics::{Finding, Report, Span, similar};
use asmotion_lang::hir::{Domain, RuleKind, RuleTerm, Variable};
use asmotion_lang::ir::{CoveragePoint, DomainId, Origin, ValueShape};
use asmotion_lang::{Machine, Specification, Value};
use std::collections::BTreeMap;

/// Fairness that is due to agents and rules.
#[derive(Default)]
pub(crate) struct DueFairness {
    pub moves: FairMoves,
    /// The fairness in words.
    pub texts: Vec<String>,
}

impl DueFairness {
    /// Finds what the comments of the main files and the options name. The programs count coverage.
    ///
    /// # Errors
    /// Fairness cannot be due to a name: the index of a machine, and a report.
    pub fn of(
        known: &[VerifiedMachine],
        machines: &[Machine],
        given: &[FairName],
    ) -> Result<Self, (usize, Report)> {
        let mut due = Self::default();
        for (index, (verified, machine)) in known.iter().zip(machines).enumerate() {
            let specification = &verified.specification;
            for fair in annotated(specification) {
                let found = moved_by(specification, machine, &fair.name);
                let found = found.map_err(|reason| refused(specification, index, &fair, reason))?;
                due.add(index, &fair, found);
            }
        }
        for fair in given {
            due.add_given(known, machines, fair)?;
        }
        if let (Some(last), Some(first)) = (given.last(), known.first())
            && due.moves.moves.len() > MAX_FAIR_MOVES
        {
            let reason = "there are more than 96 agents and rules";
            return Err(refused(&first.specification, 0, last, reason));
        }
        due.moves.moves.truncate(MAX_FAIR_MOVES);
        Ok(due)
    }

    /// Adds a name from outside, which belongs to the first machine that has it.
    fn add_given(
        &mut self,
        known: &[VerifiedMachine],
        machines: &[Machine],
        fair: &FairName,
    ) -> Result<(), (usize, Report)> {
        let mut refusal = None;
        for (index, (verified, machine)) in known.iter().zip(machines).enumerate() {
            let specification = &verified.specification;
            match moved_by(specification, machine, &fair.name) {
                Ok(found) => {
                    self.add(index, fair, found);
                    return Ok(());
                }
                Err(reason) if reason == NO_SUCH_NAME && refusal.is_some() => {}
                Err(reason) => refusal = Some(refused(specification, index, fair, reason)),
            }
        }
        refusal.map_or(Ok(()), Err)
    }

    fn add(&mut self, machine: usize, fair: &FairName, found: Vec<MovedBy>) {
        let is_strong = fair.is_strong;
        self.moves
            .moves
            .extend(found.into_iter().map(|moved_by| FairMove {
                machine,
                moved_by,
                is_strong,
            }));
        let strength = if is_strong { "strong" } else { "weak" };
        let text = format!("{strength} fairness of {}", fair.name);
        if !self.texts.contains(&text) {
            self.texts.push(text);
        }
    }
}

/// Returns the names in the comments of the main file.
fn annotated(specification: &Specification) -> Vec<FairName> {
    let mut names = Vec::new();
    let main = specification.model.main;
    let main = main.and_then(|id| specification.model.rules.get(id.0 as usize));
    let Some(main) = main else { return names };
    let file = main.span.file;
    let parsed = asmotion_lang::syntax::parse(file, specification.sources.text(file));
    for annotation in &parsed.file.annotations {
        let is_strong = match &*annotation.name.text {
            "Fair" => false,
            "StronglyFair" => true,
            _ => continue,
        };
        let words = annotation
            .rest
            .split(|sign: char| !sign.is_alphanumeric() && sign != '_');
        let words = words.filter(|word| !word.is_empty());
        names.extend(words.map(|word| FairName {
            name: word.to_owned(),
            is_strong,
        }));
    }
    names
}

fn refused(
    specification: &Specification,
    machine: usize,
    fair: &FairName,
    reason: &'static str,
) -> (usize, Report) {
    let finding = unknown(specification, &fair.name, reason);
    (machine, report_of(finding.diagnostic()))
}

fn unknown(specification: &Specification, name: &str, reason: &'static str) -> UnknownFairName {
    let model = &specification.model;
    let rules = model.rules.iter().filter(|rule| !rule.library);
    let rules = rules.map(|rule| rule.name.to_string());
    let domains = model.domains.iter().map(|domain| domain.name.to_string());
    let known: Vec<String> = rules.chain(domains).filter(|known| known != name).collect();
    let is_unknown = reason == NO_SUCH_NAME;
    UnknownFairName {
        name: name.to_owned(),
        reason,
        similar: similar(name, &known).filter(|_| is_unknown).cloned(),
        at: main_rule(specification),
    }
}

const NO_SUCH_NAME: &str = "no rule and no domain has this name";

fn moved_by(
    specification: &Specification,
    machine: &Machine,
    name: &str,
) -> Result<Vec<MovedBy>, &'static str> {
    let model = &specification.model;
    let mut rules = model.rules.iter();
    if let Some(rule) = rules.find(|rule| &*rule.name == name && !rule.library) {
        let counters = counters(specification, rule.span);
        return if counters.is_empty() {
            Err("the main rule never calls it")
        } else {
            Ok(vec![MovedBy::Rule(counters)])
        };
    }
    let mut domains = model.domains.iter().enumerate();
    let Some((index, domain)) = domains.find(|(_, domain)| &*domain.name == name) else {
        return Err(NO_SUCH_NAME);
    };
    let shape = ValueShape::Domain(DomainId(index as u32));
    let Some(agents) = machine.elements(&shape, MAX_VALUES) else {
        return Err("the elements of the domain cannot be enumerated");
    };
    let places = places(specification, domain);
    if places.is_empty() {
        return Err("no variable of a `choose` rule ranges over the domain");
    }
    let agent = |value: Value| MovedBy::Agent(value, places.clone());
    Ok(agents.into_iter().map(agent).collect())
}

/// Returns the counters of the calls of a rule.
fn counters(specification: &Specification, rule: Span) -> Vec<u32> {
    let counted = specification.program.counted.iter().enumerate();
    let calls = counted.filter(|(_, counted)| {
        counted.part == CoveragePoint::Rule && specification.span(counted.origin) == rule
    });
    calls.map(|(index, _)| index as u32).collect()
}

/// Returns the places of `choose` rules with a variable that ranges over a domain, and the position of that variable.
fn places(specification: &Specification, domain: &Domain) -> BTreeMap<Origin, usize> {
    let mut spans: BTreeMap<Span, usize> = BTreeMap::new();
    for rule in &specification.model.rules {
        let Some(body) = &rule.body else { continue };
        asmotion_lang::ir::visit_rules(&body.root, &mut |part| {
            let at = ranging_over(specification, part, &body.variables, domain);
            spans.extend(at.map(|at| (part.span, at)));
        });
    }
    let origins = specification.origins.iter().enumerate();
    let places = origins.filter_map(|(index, span)| {
        let at = spans.get(span)?;
        Some((Origin(index as u32), *at))
    });
    places.collect()
}

/// Returns the position of the first variable of a `choose` rule that ranges over a domain.
fn ranging_over(
    specification: &Specification,
    rule: &RuleTerm,
    variables: &[Variable],
    domain: &Domain,
) -> Option<usize> {
    let RuleKind::Choose(binders, ..) = &*rule.kind else {
        return None;
    };
    let model = &specification.model;
    binders.iter().position(|binder| {
        let variable = variables.get(binder.variable.0 as usize);
        let has_type = variable.is_some_and(|it| model.show_type(it.ty) == *domain.name);
        has_type || specification.sources.snippet(binder.range.span) == &*domain.name
    })
}
