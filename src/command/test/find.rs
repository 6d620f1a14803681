//! Finds scenario files.

use std::path::{Path, PathBuf};

use asmotion_diagnostics::FileId;
use asmotion_lang::{Loader, syntax};

use super::{mission, snapshot};
use crate::files::DiskLoader;
use crate::paths::{FileKind, named_files};

/// Kinds of scenarios.
const KINDS: &[FileKind] = &[FileKind::Scenario, FileKind::Script, FileKind::Mission];

/// Returns the scenarios among the paths: those of a folder, in order of names, and those of a specification.
///
/// # Errors
/// Fails for a path without scenarios.
pub fn scenarios(paths: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    let mut scenarios = Vec::new();
    for file in named_files(paths, KINDS).map_err(|error| error.to_string())? {
        match FileKind::of(&file.path) {
            Some(kind) if file.is_standard_input() && kind != FileKind::Scenario => {
                return Err(without_name(kind));
            }
            Some(FileKind::Specification) => scenarios.extend(of_specification(&file.path)?),
            Some(FileKind::Composite) => scenarios.extend(of_composite(&file.path)?),
            Some(FileKind::Scenario | FileKind::Script | FileKind::Mission) | None => {
                scenarios.push(file.path)
            }
        }
    }
    Ok(scenarios)
}

/// Returns the error for a text on standard input that is no scenario.
fn without_name(kind: FileKind) -> String {
    let (what, way_out) = match kind {
        FileKind::Mission => ("a mission", "`asmotion test FILE` runs it"),
        FileKind::Composite => (
            "a composite",
            "`asmotion test FILE` runs the missions beside it",
        ),
        FileKind::Specification | FileKind::Scenario | FileKind::Script => (
            "a specification",
            "`asmotion test FILE` runs the scenarios beside it, `asmotion sim -` simulates it",
        ),
    };
    format!("the text on standard input is {what} and no scenario (`.avalla`): {way_out}")
}

/// Returns the scenarios beside a specification that run it.
fn of_specification(path: &Path) -> Result<Vec<PathBuf>, String> {
    let found = beside(path, |scenario| loaded(scenario).map(PathBuf::from))?;
    if found.is_empty() {
        return Err(format!("no scenario beside `{}` runs it", path.display()));
    }
    Ok(found)
}

/// Returns the missions beside a composite that run it.
fn of_composite(path: &Path) -> Result<Vec<PathBuf>, String> {
    let found = beside(path, |scenario| {
        let is_mission = mission::is_mission(scenario);
        is_mission.then(|| mission::composite(scenario)).flatten()
    })?;
    if found.is_empty() {
        let path = path.display();
        return Err(format!(
            "no mission (`.mission.toml`) beside `{path}` runs it; `asmotion run {path}` runs it without checks"
        ));
    }
    Ok(found)
}

/// Returns the scenarios beside a file that run it, according to `runs`.
fn beside(path: &Path, runs: impl Fn(&Path) -> Option<PathBuf>) -> Result<Vec<PathBuf>, String> {
    let named = path.canonicalize().map_err(|error| {
        let (path, reason) = (path.display(), crate::files::reason(&error));
        format!("cannot read `{path}`: {reason}")
    })?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        Some(_) | None => PathBuf::from("."),
    };
    let beside = named_files(&[folder], KINDS).unwrap_or_default();
    let runs_it = |scenario: &PathBuf| {
        runs(scenario).is_some_and(|path| path.canonicalize().ok().as_ref() == Some(&named))
    };
    let paths = beside.into_iter().map(|file| file.path);
    Ok(paths.filter(runs_it).collect())
}

/// The specification that a scenario runs; `None` if it cannot be read.
fn loaded(scenario: &Path) -> Option<String> {
    if mission::is_mission(scenario) {
        return None;
    }
    if snapshot::is_script(scenario) {
        return Some(snapshot::specification(scenario));
    }
    let path = scenario.to_string_lossy();
    let text = DiskLoader.read(&path).ok()?;
    let (tree, _) = syntax::parse_scenario(FileId(0), &text);
    DiskLoader.resolve(&path, &tree.load?.text)
}
