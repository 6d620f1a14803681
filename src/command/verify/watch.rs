//! `--watch`: verifies again after each change of a file.

use super::words::{heading, verdict};
use super::{Verify, interrupt};
use crate::exit::Exit;
use crate::terminal::{BAD, GOOD, NOTE, TerminalOutput};
use asmotion_verify::{KeptExploration, Verdict, Verification};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Time between two looks at the files.
const INTERVAL: Duration = Duration::from_millis(200);

/// The verdict of each property, by its text.
type Verdicts = BTreeMap<String, Verdict>;

impl Verify {
    /// Verifies the specification at a path again and again until Ctrl-C; returns the exit code of the last verification.
    pub(super) fn watch_file(&self, path: &str, terminal: &mut TerminalOutput) -> Exit {
        let mut before: Option<Verdicts> = None;
        let mut kept = KeptExploration::default();
        let mut files = WatchedFiles::default();
        loop {
            files.note(Path::new(path));
            let exit = match self.file_system(path, terminal) {
                Ok(Some(system)) => {
                    for path in paths(&system) {
                        files.note(&path);
                    }
                    match self.verification(system, Some(&mut kept), terminal) {
                        Ok((verification, time)) => {
                            let exit = self.present(path, &verification, time, terminal);
                            if verification.is_reused {
                                terminal.result("  only properties have changed: the states are those explored before");
                            }
                            let verdicts = verdicts(&verification);
                            if let Some(before) = &before {
                                show_changes(before, &verdicts, terminal);
                            }
                            before = Some(verdicts);
                            exit
                        }
                        Err(exit) => exit,
                    }
                }
                Ok(None) => Exit::Ok,
                Err(exit) => exit,
            };
            terminal.status("Watching", format_args!("{path} (Ctrl-C ends)"));
            while !files.have_changed() {
                if interrupt::has_occurred() {
                    return exit;
                }
                std::thread::sleep(INTERVAL);
            }
            files = WatchedFiles::default();
        }
    }
}

/// The files of a system, without the standard libraries, which are in no file.
fn paths(system: &asmotion_verify::SystemSpecification) -> Vec<PathBuf> {
    let machines = system.machines.iter();
    let paths = machines.flat_map(|machine| machine.specification.sources.paths());
    paths
        .map(PathBuf::from)
        .filter(|path| path.is_file())
        .collect()
}

fn verdicts(verification: &Verification) -> Verdicts {
    let properties = verification.properties.iter();
    let pairs = properties.map(|property| (heading(property), property.verdict.clone()));
    pairs.collect()
}

/// Shows the verdicts that differ from those before.
fn show_changes(before: &Verdicts, after: &Verdicts, terminal: &mut TerminalOutput) {
    let mut changes = 0;
    for (property, now) in after {
        let colour = match now {
            Verdict::Holds(_) => GOOD,
            Verdict::Violated(_) => BAD,
            Verdict::Unknown => NOTE,
        };
        let word = verdict(now);
        let text = match before.get(property) {
            None => format!("{colour}new{colour:#}: {word}, {property}"),
            Some(then) if verdict(then) != word => {
                format!(
                    "{colour}now {word}{colour:#} (was {}): {property}",
                    verdict(then)
                )
            }
            Some(_) => continue,
        };
        terminal.result(format_args!("  changed   {text}"));
        changes += 1;
    }
    for property in before.keys().filter(|it| !after.contains_key(*it)) {
        terminal.result(format_args!("  changed   {NOTE}gone{NOTE:#}: {property}"));
        changes += 1;
    }
    if changes == 0 {
        terminal.result("  no verdict has changed");
    }
}

/// Files with the times of their last changes.
#[derive(Default)]
struct WatchedFiles(BTreeMap<PathBuf, Option<SystemTime>>);

impl WatchedFiles {
    /// Adds a file as it is now, unless it is known.
    fn note(&mut self, path: &Path) {
        self.0
            .entry(path.to_owned())
            .or_insert_with(|| changed_at(path));
    }

    fn have_changed(&self) -> bool {
        self.0.iter().any(|(path, at)| changed_at(path) != *at)
    }
}

/// Returns the time of the last change; `None` while a file is missing, as while an editor replaces it.
fn changed_at(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|it| it.modified()).ok()
}
