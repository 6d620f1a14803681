//! A scenario from its path to its verdict.

use crate::codes::v023::UnreadableScenario;
use crate::codes::v024::UnknownSpecification;
use crate::coverage::Coverage;
use crate::specification::{OpenFailure, Specification, open_in};
use asmotion_diagnostics::{Diagnostic, Finding, Loader, Report, Sources, Span};
use asmotion_machine::{Machine, StepFault};
use asmotion_simulate::scenario::{
    self, ScenarioFailureKind, ScenarioOptions, ScenarioOutcome, ScenarioPlan,
};
use asmotion_syntax::ast::{NameText, Scenario};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A scenario that was run.
#[derive(Debug)]
pub struct ScenarioResult {
    /// The name after `scenario`.
    pub name: String,
    /// What came of it.
    pub outcome: ScenarioOutcome,
    /// Warnings, and what went wrong.
    pub report: Report,
    /// The specification it is about.
    pub specification: Specification,
    /// What of it ran, if that was asked for.
    pub coverage: Option<Coverage>,
}

/// How a scenario is to be run.
#[derive(Clone, Debug, Default)]
pub struct ScenarioSettings {
    /// How the specification is read, and the scenario with it.
    pub reading: asmotion_hir::ReadOptions,
    /// The limits and the seed.
    pub options: ScenarioOptions,
    /// Whether it is counted what runs.
    pub covers: bool,
}

/// A scenario that can be run.
struct OpenedScenario {
    tree: Scenario,
    plan: ScenarioPlan,
    specification: Specification,
    /// Warnings.
    report: Report,
}

/// Runs the scenario at a path.
///
/// # Errors
/// It cannot be read, or it or its specification makes no sense.
pub fn test(
    path: &str,
    loader: &dyn Loader,
    settings: &ScenarioSettings,
) -> Result<ScenarioResult, OpenFailure> {
    open(path, loader, settings).map(|opened| carry_out(opened, settings))
}

/// What is wrong with the scenario at a path, as far as that can be seen before it runs.
pub fn check(
    path: &str,
    loader: &dyn Loader,
    reading: &asmotion_hir::ReadOptions,
) -> (Report, Sources) {
    let settings = ScenarioSettings {
        reading: reading.clone(),
        ..ScenarioSettings::default()
    };
    match open(path, loader, &settings) {
        Ok(opened) => (opened.report, opened.specification.sources),
        Err(OpenFailure { report, sources }) => (report, sources),
    }
}

fn open(
    path: &str,
    loader: &dyn Loader,
    settings: &ScenarioSettings,
) -> Result<OpenedScenario, OpenFailure> {
    let mut sources = Sources::new();
    let (tree, mut report) = match read(path, loader, &mut sources) {
        Ok(read) => read,
        Err(report) => return Err(OpenFailure { sources, report }),
    };
    let Some(specification) = tree.load.as_ref().and_then(|load| find(path, load, loader)) else {
        report.extend(tree.load.as_ref().map(not_found).into_iter().collect());
        return Err(OpenFailure { sources, report });
    };
    if report.has_errors() {
        return Err(OpenFailure { sources, report });
    }
    let mut specification = open_in(&specification, loader, sources, &settings.reading)?;
    match plan(path, &tree, &mut specification, loader, settings) {
        Ok(plan) => Ok(OpenedScenario {
            tree,
            plan,
            specification,
            report,
        }),
        Err(found) => {
            report.extend(found);
            let sources = specification.sources;
            Err(OpenFailure { sources, report })
        }
    }
}

/// The tree of a scenario, and what is wrong with its text.
fn read(
    path: &str,
    loader: &dyn Loader,
    sources: &mut Sources,
) -> Result<(Scenario, Report), Report> {
    match loader.read(path) {
        Ok(text) => {
            let file = sources.add(path, text.clone());
            Ok(asmotion_syntax::parse_scenario(file, &text))
        }
        Err(error) => {
            let finding = UnreadableScenario { error }.diagnostic();
            Err([finding].into_iter().collect())
        }
    }
}

fn find(from: &str, load: &NameText, loader: &dyn Loader) -> Option<String> {
    loader.resolve(from, &load.text)
}

fn not_found(load: &NameText) -> Diagnostic {
    let (path, at) = (load.text.clone(), load.span);
    UnknownSpecification { path, at }.diagnostic()
}

/// The scenario against its specification, which is lowered with its terms.
fn plan(
    path: &str,
    tree: &Scenario,
    specification: &mut Specification,
    loader: &dyn Loader,
    settings: &ScenarioSettings,
) -> Result<ScenarioPlan, Report> {
    let mut others: BTreeMap<String, Option<Arc<Scenario>>> = BTreeMap::new();
    let mut found = Report::new();
    let Specification { model, sources, .. } = specification;
    let mut other = |name: &str| {
        let known = others.entry(name.to_owned()).or_insert_with(|| {
            let other = loader.resolve(path, &format!("{name}.avalla"))?;
            let (tree, report) = read(&other, loader, sources).ok()?;
            found.extend(report);
            Some(Arc::new(tree))
        });
        known.clone()
    };
    let plan = ScenarioPlan::of(tree, model, &mut other);
    if found.has_errors() {
        found.extend(plan.err().unwrap_or_default());
        return Err(found);
    }
    let plan = plan?;
    match settings.covers {
        true => specification.lower_covered()?,
        false => specification.lower()?,
    }
    Ok(plan)
}

fn carry_out(opened: OpenedScenario, settings: &ScenarioSettings) -> ScenarioResult {
    let OpenedScenario {
        tree,
        plan,
        specification,
        mut report,
    } = opened;
    let mut coverage = None;
    let outcome = match specification.machine() {
        Ok(mut machine) => {
            let outcome = scenario::run(
                &plan,
                &mut machine,
                &specification.origins,
                &settings.options,
            );
            report.extend(explained(&outcome, &specification, Some(&machine)));
            coverage = settings
                .covers
                .then(|| Coverage::of(&specification, &machine.counts()));
            outcome
        }
        Err(fault) => {
            let at = tree
                .load
                .as_ref()
                .map_or_else(Span::default, |load| load.span);
            let outcome = ScenarioOutcome::unbegun(fault, at);
            report.extend(explained(&outcome, &specification, None));
            outcome
        }
    };
    let name = tree
        .name
        .as_ref()
        .map_or_else(String::new, |name| name.text.to_string());
    ScenarioResult {
        name,
        outcome,
        report,
        specification,
        coverage,
    }
}

/// What went wrong, in words.
fn explained(
    outcome: &ScenarioOutcome,
    specification: &Specification,
    machine: Option<&Machine>,
) -> Report {
    let explain = |fault: &StepFault| match machine {
        Some(machine) => specification.explain_in(fault, machine),
        None => specification.explain(fault),
    };
    let explained = outcome
        .failures
        .iter()
        .filter_map(|failure| match &failure.kind {
            ScenarioFailureKind::Fault(fault) => {
                Some(explain(fault).label(failure.at, "asked for here"))
            }
            ScenarioFailureKind::Check(_)
            | ScenarioFailureKind::Invariant(..)
            | ScenarioFailureKind::Until(..) => failure.diagnostic(),
        });
    explained.collect()
}
