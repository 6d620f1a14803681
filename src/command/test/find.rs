//! Finds scenario files.

use std::path::{Path, PathBuf};

use asmotion_diagnostics::FileId;
use asmotion_lang::{Loader, syntax};

use super::snapshot;
use crate::files::DiskLoader;
use crate::paths::{FileKind, named_files};

/// Kinds of scenarios.
const KINDS: &[FileKind] = &[FileKind::Scenario, FileKind::Script];

/// Returns the scenarios among the paths: those of a folder, in order of names, and those of a specification.
///
/// # Errors
/// Fails for a path without scenarios.
pub fn scenarios(paths: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    let mut scenarios = Vec::new();
    for file in named_files(paths, KINDS).map_err(|error| error.to_string())? {
        match FileKind::of(&file.path) {
            Some(FileKind::Specification) => scenarios.extend(of_specification(&file.path)?),
            Some(FileKind::Composite) => {
                let path = file.text();
                return Err(format!(
                    "`{path}` is a composite: `asmotion run {path}` runs it"
                ));
            }
            Some(FileKind::Scenario | FileKind::Script) | None => scenarios.push(file.path),
        }
    }
    Ok(scenarios)
}

/// Returns the scenarios beside a specification that run it.
fn of_specification(path: &Path) -> Result<Vec<PathBuf>, String> {
    let specification = path.canonicalize().map_err(|error| {
        let (path, reason) = (path.display(), crate::files::reason(&error));
        format!("cannot read `{path}`: {reason}")
    })?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        Some(_) | None => PathBuf::from("."),
    };
    let beside = named_files(&[folder], KINDS).unwrap_or_default();
    let runs_it = |scenario: &PathBuf| {
        loaded(scenario).is_some_and(|path| {
            Path::new(&path).canonicalize().ok().as_ref() == Some(&specification)
        })
    };
    let found: Vec<PathBuf> = beside
        .into_iter()
        .map(|file| file.path)
        .filter(runs_it)
        .collect();
    if found.is_empty() {
        return Err(format!("no scenario beside `{}` runs it", path.display()));
    }
    Ok(found)
}

/// The specification that a scenario runs; `None` if it cannot be read.
fn loaded(scenario: &Path) -> Option<String> {
    if snapshot::is_script(scenario) {
        return Some(snapshot::specification(scenario));
    }
    let path = scenario.to_string_lossy();
    let text = DiskLoader.read(&path).ok()?;
    let (tree, _) = syntax::parse_scenario(FileId(0), &text);
    DiskLoader.resolve(&path, &tree.load?.text)
}
