//! Opens, checks and runs scenarios.

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

/// The result of running a scenario.
#[derive(Debug)]
pub struct ScenarioResult {
    /// Name after the keyword `scenario`.
    pub name: String,
    /// Verdict, with the observed failures.
    pub outcome: ScenarioOutcome,
    /// Warnings, and the failures as diagnostics.
    pub report: Report,
    /// The specification that the scenario loads.
    pub specification: Specification,
    /// Coverage of the specification, if requested.
    pub coverage: Option<Coverage>,
}

/// Settings for running a scenario.
#[derive(Clone, Debug, Default)]
pub struct ScenarioSettings {
    /// Options for reading the specification and the scenario.
    pub reading: asmotion_hir::ReadOptions,
    /// Seed of the choices, step limit and clock period.
    pub options: ScenarioOptions,
    /// `true` to compute the coverage. Default: `false`.
    pub covers: bool,
}

/// A scenario that is ready to run.
struct OpenedScenario {
    tree: Scenario,
    plan: ScenarioPlan,
    specification: Specification,
    /// Warnings found while opening it.
    report: Report,
}

/// Runs the scenario at a path.
///
/// # Errors
/// The scenario or its specification cannot be read or contains errors.
pub fn test(
    path: &str,
    loader: &dyn Loader,
    settings: &ScenarioSettings,
) -> Result<ScenarioResult, OpenFailure> {
    open(path, loader, settings).map(|opened| run(opened, settings))
}

/// Checks the scenario at a path without running it.
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

/// Parses a scenario; returns it with the report on its text.
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

/// Resolves the scenario against its specification, which is lowered together with the scenario's
/// terms.
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
    if settings.covers {
        specification.lower_covered()?
    } else {
        specification.lower()?
    }
    Ok(plan)
}

fn run(opened: OpenedScenario, settings: &ScenarioSettings) -> ScenarioResult {
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
            let outcome = ScenarioOutcome::initial_fault(fault, at);
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

/// Converts the failures of a run to diagnostics.
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
                Some(explain(fault).label(failure.at, "tested here"))
            }
            ScenarioFailureKind::Check(_)
            | ScenarioFailureKind::Invariant(..)
            | ScenarioFailureKind::Until(..) => failure.diagnostic(),
        });
    explained.collect()
}
