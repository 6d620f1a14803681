//! Finds scenario files.

use crate::files::reason;
use std::io;
use std::path::{Path, PathBuf};

/// Returns the scenarios among the paths; folders are searched recursively, in order of names.
pub fn scenarios(paths: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    let mut scenarios = Vec::new();
    for path in paths {
        let failed =
            |error: io::Error| format!("cannot read `{}`: {}", path.display(), reason(&error));
        if std::fs::metadata(path).map_err(failed)?.is_dir() {
            let mut inside = Vec::new();
            folder(path, &mut inside).map_err(failed)?;
            let short = |path: PathBuf| path.strip_prefix(".").map_or(path.clone(), Path::to_owned);
            scenarios.extend(inside.into_iter().map(short));
        } else {
            scenarios.push(path.clone());
        }
    }
    Ok(scenarios)
}

fn folder(path: &Path, scenarios: &mut Vec<PathBuf>) -> io::Result<()> {
    let mut entries: Vec<_> = std::fs::read_dir(path)?.collect::<io::Result<_>>()?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        // links to folders are not followed, because they can be cyclic
        let kind = entry.file_type()?;
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        if kind.is_dir() && !is_hidden {
            folder(&entry.path(), scenarios)?;
        } else if !kind.is_dir() && is_test(&entry.path()) {
            scenarios.push(entry.path());
        }
    }
    Ok(())
}

fn is_test(path: &Path) -> bool {
    let is_scenario = path
        .extension()
        .is_some_and(|extension| extension == "avalla");
    is_scenario || super::snapshot::is_script(path)
}
