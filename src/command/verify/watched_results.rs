//! What `--watch` keeps from one verification for the next one.

use super::words::{heading, verdict};
use crate::terminal::{BAD, GOOD, NOTE, TerminalOutput};
use asmotion_verify::{KeptExploration, Verdict, Verification};
use std::collections::BTreeMap;

/// The verdict of each property, by its text.
type Verdicts = BTreeMap<String, Verdict>;

/// The explorations and verdicts of repeated verifications, by path or component; `None` without `--watch`.
pub(super) struct WatchedResults(Option<BTreeMap<String, WatchedResult>>);

#[derive(Default)]
struct WatchedResult {
    explored: KeptExploration,
    /// Those of the last verification that ended.
    verdicts: Option<Verdicts>,
}

impl WatchedResults {
    /// Of verifications that are not repeated.
    pub(super) fn none() -> Self {
        Self(None)
    }

    /// Of verifications that are repeated, before the first.
    pub(super) fn of_repeated() -> Self {
        Self(Some(BTreeMap::new()))
    }

    /// The exploration for the verification with this name; `None` if it is not repeated.
    pub(super) fn exploration(&mut self, name: &str) -> Option<&mut KeptExploration> {
        let results = self.0.as_mut()?;
        Some(&mut results.entry(name.to_owned()).or_default().explored)
    }

    /// Shows what has changed since the verification with this name before, and keeps the verdicts for the next one.
    pub(super) fn show_changes(
        &mut self,
        name: &str,
        verification: &Verification,
        terminal: &mut TerminalOutput,
    ) {
        let Some(results) = &mut self.0 else { return };
        if verification.is_reused {
            terminal.result("  only properties have changed: the states are those explored before");
        }
        let result = results.entry(name.to_owned()).or_default();
        let verdicts = verdicts(verification);
        if let Some(before) = &result.verdicts {
            show_changes(before, &verdicts, terminal);
        }
        result.verdicts = Some(verdicts);
    }

    /// Keeps the verdicts for a component that is alike: it may be verified by itself the next time.
    pub(super) fn keep(&mut self, name: &str, verification: &Verification) {
        if let Some(results) = &mut self.0 {
            let result = results.entry(name.to_owned()).or_default();
            result.verdicts = Some(verdicts(verification));
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
