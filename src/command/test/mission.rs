//! Mission tests: run a composite in virtual time with actions and faults, and check what must hold.

mod condition;
mod director;
mod expectation;
mod monitor;
mod operand;
mod parse;
mod resolve;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_component::Time;
use asmotion_composite::SettingValue;
use asmotion_composite::mission::{
    MissionAct, MissionExpectation, MissionFile, MissionRequirement,
};
use asmotion_coordinator::{STEP_REPORT, VIOLATION_REPORT};
use asmotion_diagnostics::{Finding, Sources};
use asmotion_lang::simulate::scenario::Verdict;
use asmotion_lang::{Diagnostic, Loader, Report};
use asmotion_runtime::Event;

use super::result::{TestEnd, TestResult};
use super::snapshot;
use crate::build::Build;
use crate::codes::v033::ExpectationFailed;
use crate::codes::v034::ActionFailed;
use crate::codes::v035::MissionEndedEarly;
use crate::codes::v036::MissionNotStarted;
use crate::files::DiskLoader;
use crate::mission::{Director, Mission, MissionEnd, MissionError, MissionOutcome};
use crate::own_program::cargo_run;
use crate::paths::FileKind;
use crate::trace::MissionTrace;
use director::{MissionDirector, data, lock, seconds};
use expectation::{BrokenExpectation, RequirementKind, WatchedExpectation};
use monitor::RunMonitor;

/// Time limit of a mission without one.
const LIMIT: Duration = Duration::from_secs(60);

/// Suffix of mission files.
const SUFFIX: &str = ".toml";

/// Returns `true` if the file is a mission.
pub(in crate::command) fn is_mission(path: &Path) -> bool {
    FileKind::of(path) == Some(FileKind::Mission)
}

/// The composite that a mission runs; `None` if the mission cannot be read.
pub(super) fn composite(path: &Path) -> Option<PathBuf> {
    let (file, _, _) = read(path, &DiskLoader).ok()?;
    Some(path.with_file_name(file?.composite.value))
}

/// Reads a mission file.
fn read(
    path: &Path,
    loader: &dyn Loader,
) -> Result<(Option<MissionFile>, Report, Sources), String> {
    let name = path.to_string_lossy();
    let text = loader.read(&name).map_err(|error| error.to_string())?;
    let mut sources = Sources::new();
    let file = sources.add(&name, text.clone());
    let (mission, report) = asmotion_composite::mission::read(file, &name, &text);
    Ok((mission, report, sources))
}

/// Checks a mission and the composite it runs, without running it.
pub(in crate::command) fn check(
    build: &Build,
    path: &Path,
    loader: &dyn Loader,
) -> (Report, Sources) {
    let (file, report, sources) = match read(path, loader) {
        Ok(read) => read,
        Err(reason) => {
            return (one(unreadable(reason)), Sources::new());
        }
    };
    let Some(file) = file.filter(|_| !report.has_errors()) else {
        return (report, sources);
    };
    let mission = mission(build, &file, path, 1);
    let opened = build.open(&mission.composite, &mission.settings, loader);
    if opened.report.has_errors() {
        return (opened.report, opened.sources);
    }
    let refused = match opened.plan(mission.profile.as_deref()) {
        Some(plan) => MissionDirector::new(file.clone())
            .prepare(plan)
            .and_then(|()| {
                let refused = mission.check_outside(plan);
                refused.map_err(|error| one(not_started(&error, &file, path)))
            })
            .err(),
        None => {
            let unknown = MissionError::Profile {
                requested: mission.profile,
                available: opened.profiles,
            };
            Some(one(not_started(&unknown, &file, path)))
        }
    };
    (refused.unwrap_or(report), sources)
}

/// The finding about a mission file that cannot be read.
fn unreadable(reason: String) -> MissionNotStarted {
    MissionNotStarted {
        reason,
        help: None,
        at: None,
    }
}

/// A report of one finding.
fn one(finding: MissionNotStarted) -> Report {
    [finding.diagnostic()].into_iter().collect()
}

/// Runs a mission; `seed` is that of the command line.
pub(super) fn run(build: &Build, path: PathBuf, seed: u64) -> TestResult {
    let started = Instant::now();
    let mut result = TestResult::unusable(path.clone());
    match read(&path, &DiskLoader) {
        Err(reason) => result.report.push(unreadable(reason).diagnostic()),
        Ok((file, report, sources)) => {
            (result.report, result.sources) = (report, sources);
            if let Some(file) = file.filter(|_| !result.report.has_errors()) {
                execute(build, &file, seed, &mut result);
            }
        }
    }
    result.duration = started.elapsed();
    result
}

/// The run of a mission file.
fn execute(build: &Build, file: &MissionFile, seed: u64, result: &mut TestResult) {
    let mission = mission(build, file, &result.path, seed);
    result.name = file
        .doc
        .as_ref()
        .map(|doc| doc.value.clone())
        .unwrap_or_default();
    result.checks = file.expectations.len() as u64;
    let mut director = MissionDirector::new(file.clone());
    let monitor = director.monitor();
    let trace = Arc::new(Mutex::new(MissionTrace::new()));
    let (observer, recorder) = (monitor.clone(), trace.clone());
    let observe = move |at: Time, event: &Event<'_>, _: Option<&str>| {
        let mut monitor = lock(&observer);
        if monitor.ended.is_none() && is_in_snapshot(event) {
            lock(&recorder).note(at, event);
        }
        monitor.observe(at, event);
    };
    let stop = AtomicBool::new(false);
    match mission.run_directed(&mut director, |_, _| (), observe, &stop) {
        Err(error) => refuse(error, file, result),
        Ok(end) => {
            result.steps = end.summary.steps;
            let monitor = lock(&monitor);
            result.report.extend(judge(file, &end, &monitor, &director));
            let failed = result.report.has_errors();
            result.end = TestEnd::Ran(verdict(&end, failed));
            if file.snapshot.as_ref().is_some_and(|it| it.value) {
                snapshot::compare_into(result, SUFFIX, lock(&trace).text().to_owned());
            }
        }
    }
}

fn verdict(end: &MissionEnd, failed: bool) -> Verdict {
    if !end.failed.is_empty() {
        Verdict::Fault
    } else if failed {
        Verdict::Fail
    } else {
        Verdict::Pass
    }
}

/// The run that a mission file describes.
fn mission(build: &Build, file: &MissionFile, path: &Path, seed: u64) -> Mission {
    let composite = path.with_file_name(&file.composite.value);
    let mut mission = Mission::with_build(build, composite.to_string_lossy());
    mission.profile = file.profile.as_ref().map(|it| it.value.clone());
    mission.seed = file.seed.as_ref().map_or(seed, |it| it.value);
    mission.seeds_composite = true;
    let settings = file.properties.iter();
    mission.settings = settings
        .map(|it| (it.name.value.clone(), setting(&it.value.0)))
        .collect();
    for component in &file.components {
        let values = data(&component.properties).into_iter();
        let values = values.map(|(name, value)| (component.name.value.clone(), name, value));
        mission.properties.extend(values);
    }
    // the mission ends by its own condition
    (mission.until, mission.unless) = (Some(Vec::new()), Some(Vec::new()));
    mission.limit = Some(seconds(file.limit_s.as_ref()).unwrap_or(LIMIT));
    let failing = file.actions.iter().filter_map(|action| match &action.act {
        MissionAct::Fail(component) => Some(component),
        MissionAct::Write { .. }
        | MissionAct::Set { .. }
        | MissionAct::Stop(_)
        | MissionAct::Start(_) => None,
    });
    let may_fail = failing.chain(&file.may_fail);
    mission.may_fail = may_fail.map(|it| it.value.clone()).collect();
    mission
}

/// A value as on the command line.
fn setting(value: &SettingValue) -> String {
    match value {
        SettingValue::Text(text) => text.clone(),
        SettingValue::Boolean(_)
        | SettingValue::Integer(_)
        | SettingValue::Real(_)
        | SettingValue::Secret(_)
        | SettingValue::List(_)
        | SettingValue::Record(_) => asmotion_composite::table::toml(value).to_string(),
    }
}

/// Whether an event belongs to the snapshot: steps, violations, life cycles and faults, but no streams of messages.
fn is_in_snapshot(event: &Event<'_>) -> bool {
    match event {
        Event::Report { kind, .. } => [STEP_REPORT, VIOLATION_REPORT].contains(kind),
        Event::LifeCycle { .. } | Event::Fault { .. } => true,
        Event::Cycle { .. }
        | Event::Published { .. }
        | Event::Injected { .. }
        | Event::Called { .. }
        | Event::Answered { .. }
        | Event::Replied { .. }
        | Event::Overrun { .. }
        | Event::Late { .. }
        | Event::Denied { .. }
        | Event::Dropped { .. }
        | Event::Property { .. }
        | Event::Lost { .. } => false,
    }
}

/// Reports why the run cannot start.
fn refuse(error: MissionError, file: &MissionFile, result: &mut TestResult) {
    match error {
        MissionError::Composite {
            sources, report, ..
        } => (result.sources, result.report) = (sources, report),
        MissionError::Director(report) => result.report.extend(report),
        error @ (MissionError::Profile { .. }
        | MissionError::Component { .. }
        | MissionError::NeverEnds { .. }
        | MissionError::Process { .. }
        | MissionError::NeedsBroker { .. }
        | MissionError::Broker { .. }
        | MissionError::Gateway { .. }
        | MissionError::WithoutGateway { .. }
        | MissionError::NotInBuild { .. }
        | MissionError::Outside(_)
        | MissionError::UnsetVariables(_)
        | MissionError::NotVerified(_)
        | MissionError::Launch(_)) => {
            let finding = not_started(&error, file, &result.path).diagnostic();
            result.report.push(finding);
        }
    }
}

/// The finding about a mission that cannot start, with ways out that a mission file has: it has none of the options of `run`.
fn not_started(error: &MissionError, file: &MissionFile, path: &Path) -> MissionNotStarted {
    let (reason, help) = if let MissionError::Outside(system) = error {
        (
            format!("{system}; a mission runs in virtual time and without brokers"),
            Some(
                "give the part of the composite that leads outside a `profile`, and select another one with `profile` in the \
                 mission"
                    .to_owned(),
            ),
        )
    } else if let MissionError::UnsetVariables(_) = error {
        (
            error.to_string(),
            Some(
                "a mission connects to no broker: if only the address or password of one uses a variable, any value will do"
                    .to_owned(),
            ),
        )
    } else if let MissionError::NotInBuild { reason, .. } = error {
        let help = cargo_run(path).map(|program| {
            let path = path.display();
            format!(
                "the program of this project contains its own components: `{program} test {path}`"
            )
        });
        (reason.clone(), help)
    } else {
        (error.to_string(), None)
    };
    let profile = file.profile.as_ref().map(|it| it.span);
    let profile = profile.filter(|_| matches!(error, MissionError::Profile { .. }));
    let at = profile.unwrap_or(file.composite.span);
    MissionNotStarted {
        reason,
        help,
        at: Some(at),
    }
}

/// The findings about a run that has ended.
fn judge(
    file: &MissionFile,
    end: &MissionEnd,
    monitor: &RunMonitor,
    director: &MissionDirector,
) -> Report {
    let expectations = file.expectations.iter().zip(&monitor.expectations);
    let failed = expectations.zip(&monitor.evidence);
    let failed = failed.filter_map(|((written, watched), values)| {
        let values = values.clone().unwrap_or_default();
        Some(failure(written, watched, values)?.diagnostic())
    });
    let at_s = end.time.as_secs_f64();
    let open = director.open().map(|(index, at)| {
        let reason = match monitor.due.get(index) {
            Some(Some(due)) => format!("the mission ended at {at_s} s, before {} s", due.seconds()),
            Some(None) | None => format!("its condition did not become true in {at_s} s"),
        };
        ActionFailed { reason, at }.diagnostic()
    });
    let actions = director.report.diagnostics.iter().cloned();
    failed
        .chain(open)
        .chain(actions)
        .chain(ends(file, end))
        .collect()
}

/// The findings about the end of a run.
fn ends(file: &MissionFile, end: &MissionEnd) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    if let (MissionOutcome::TimeUp, Some(condition)) = (end.outcome, &file.end) {
        let stalled = end.stalled.iter().map(ToString::to_string);
        let stalled: Vec<String> = stalled.collect();
        let finding = MissionEndedEarly {
            problem: format!("the mission did not end in {} s", end.time.as_secs_f64()),
            at: Some(condition.span),
            help: (!stalled.is_empty()).then(|| stalled.join("\n")),
        };
        findings.push(finding.diagnostic());
    }
    for component in &end.failed {
        let of = format!("{component}: ");
        let mut faults = end.summary.faults.iter();
        let fault = faults.find_map(|fault| fault.strip_prefix(&of));
        let fault = fault.unwrap_or("unknown fault");
        let finding = MissionEndedEarly {
            problem: format!("`{component}` failed: {fault}"),
            at: None,
            help: Some(format!(
                "if this is intended, list it: `may_fail = [\"{component}\"]`"
            )),
        };
        findings.push(finding.diagnostic());
    }
    findings
}

/// The finding about an expectation, if it failed.
fn failure(
    written: &MissionExpectation,
    watched: &WatchedExpectation,
    values: String,
) -> Option<ExpectationFailed> {
    let violation = watched.failure.as_ref()?;
    let condition = match &written.requirement {
        MissionRequirement::Eventually(it)
        | MissionRequirement::Always(it)
        | MissionRequirement::Never(it) => it,
    };
    let name = written.doc.as_ref().unwrap_or(condition);
    let problem = problem(violation, watched.kind, written.after.is_some());
    let unbegun = written.after.as_ref().map(|after| after.span);
    Some(ExpectationFailed {
        name: name.value.clone(),
        problem,
        values,
        at: condition.span,
        after: unbegun.filter(|_| *violation == BrokenExpectation::NeverBegan),
    })
}

/// Words for a violation, with its time.
fn problem(violation: &BrokenExpectation, kind: RequirementKind, has_begin: bool) -> String {
    let after = |began: &Time| {
        let began = format!(", after it began at {} s", began.seconds());
        Some(began).filter(|_| has_begin).unwrap_or_default()
    };
    match violation {
        BrokenExpectation::TooLate { began, at } => {
            format!("not true by {} s{}", at.seconds(), after(began))
        }
        BrokenExpectation::Ended { began, at } => {
            format!(
                "not true before the end at {} s{}",
                at.seconds(),
                after(began)
            )
        }
        BrokenExpectation::Violated { began, at } => {
            let is = if kind == RequirementKind::Never {
                "true"
            } else {
                "false"
            };
            format!("{is} at {} s{}", at.seconds(), after(began))
        }
        BrokenExpectation::NeverBegan => "never checked, because it never began".to_owned(),
        BrokenExpectation::NeverChecked => "never checked".to_owned(),
    }
}
