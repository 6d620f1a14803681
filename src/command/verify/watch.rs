//! `--watch`: verifies again after each change of a file.

use super::words::{heading, verdict};
use super::{Verify, interrupt};
use crate::exit::Exit;
use crate::terminal::{BAD, GOOD, NOTE, TerminalOutput};
use asmotion_verify::{KeptExploration, Verdict, Verification};
use std::collections::BTreeMap;
use std::time::Duration;

/// Time between two looks at the files.
const INTERVAL: Duration = Duration::from_millis(200);

/// Number of looks at files that are being written or missing, each after half of the interval.
const LOOKS: usize = 20;

/// The verdict of each property, by its text.
type Verdicts = BTreeMap<String, Verdict>;

impl Verify {
    /// Verifies the specification at a path again and again until Ctrl-C; returns the exit code of the last verification.
    pub(super) fn watch_file(&self, path: &str, terminal: &mut TerminalOutput) -> Exit {
        let mut before: Option<Verdicts> = None;
        let mut kept = KeptExploration::default();
        loop {
            self.files.forget();
            let exit = match self.file_system(path, terminal) {
                Ok(Some(system)) => match self.verification(system, Some(&mut kept), terminal) {
                    Ok((verification, time)) => {
                        let exit = self.present(path, &verification, time, terminal);
                        if verification.is_reused {
                            terminal.result(
                                "  only properties have changed: the states are those explored before",
                            );
                        }
                        let verdicts = verdicts(&verification);
                        if let Some(before) = &before {
                            show_changes(before, &verdicts, terminal);
                        }
                        before = Some(verdicts);
                        exit
                    }
                    Err(exit) => exit,
                },
                Ok(None) => Exit::Ok,
                Err(exit) => exit,
            };
            terminal.status("Watching", format_args!("{path} (Ctrl-C ends)"));
            if self.wait_for_change() {
                return exit;
            }
        }
    }

    /// Waits until a file has changed; returns `true` after Ctrl-C.
    fn wait_for_change(&self) -> bool {
        loop {
            if interrupt::has_occurred() {
                return true;
            }
            if self.files.have_changed() {
                self.wait_until_written();
                // a file may be back as it was
                if self.files.have_changed() {
                    return interrupt::has_occurred();
                }
            }
            std::thread::sleep(INTERVAL);
        }
    }

    /// Waits until an editor has written its files: until all of them are there and no longer change, but not for long.
    fn wait_until_written(&self) {
        let mut before = self.files.look();
        for _ in 0..LOOKS {
            std::thread::sleep(INTERVAL / 2);
            let now = self.files.look();
            if interrupt::has_occurred() || now == before && !self.files.are_missing(&now) {
                return;
            }
            before = now;
        }
    }
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
