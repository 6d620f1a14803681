//! The findings in one file of any kind.

use crate::build::Build;
use crate::command::test::{mission, snapshot};
use crate::paths::FileKind;
use asmotion_lang::{Loader, ReadOptions, Report, Sources, scenario};
use std::path::Path;

/// Returns the findings in one file and in the files it names.
pub fn findings(
    build: &Build,
    path: &str,
    options: &ReadOptions,
    loader: &dyn Loader,
) -> (Report, Sources) {
    if snapshot::is_script(Path::new(path)) {
        return match snapshot::open(path, loader) {
            Ok((specification, _)) => (Report::new(), specification.sources),
            Err(failure) => (failure.report, failure.sources),
        };
    }
    if mission::is_mission(Path::new(path)) {
        return mission::check(build, Path::new(path), loader);
    }
    if FileKind::of(Path::new(path)) == Some(FileKind::Scenario) {
        return scenario::check(path, loader, options);
    }
    let extension = Path::new(path).extension();
    let is_composite = FileKind::of(Path::new(path)) == Some(FileKind::Composite);
    if is_composite || extension.is_some_and(|it| it == "toml") {
        composite(build, path, loader)
    } else {
        // any other file named on the command line is read as a specification, with or without `.asm`
        specification(path, options, loader)
    }
}

/// Checks a composite or a file of message types.
fn composite(build: &Build, path: &str, loader: &dyn Loader) -> (Report, Sources) {
    if let Some(types) = asmotion_composite::open_types(path, loader, build.catalogue()) {
        return types;
    }
    let opened = build.open(path, &[], loader);
    (opened.report, opened.sources)
}

/// Checks a specification, including its initial state.
fn specification(path: &str, options: &ReadOptions, loader: &dyn Loader) -> (Report, Sources) {
    match asmotion_lang::open_with(path, loader, options) {
        Ok(mut specification) => {
            if let Ok(machine) = specification.machine() {
                let doubts = specification.doubts(&machine);
                specification.report.extend(doubts);
            }
            (specification.report.finish(), specification.sources)
        }
        Err(failure) => (failure.report, failure.sources),
    }
}
