//! Formats a step of a specification.

use std::fmt;

use asmotion_coordinator::{StepRecord, UpdateRecord};

use crate::entry::StoryEntry;
use crate::style::{FAINT, GOOD};
use crate::summary::control;

/// The entry for a step: with all updates if the control state changes, otherwise on one line.
pub(super) fn entry(component: &str, record: &StepRecord) -> StoryEntry {
    let number = record.number;
    let Some(control) = control(record) else {
        let (changed, locations) = changed(record);
        let line = format!("{FAINT}step {number}  {changed}{FAINT:#}");
        let name = format!("{component} {locations}");
        let has_changes = record.updates.iter().any(|it| it.before != it.after);
        return if has_changes {
            StoryEntry::change(line, name)
        } else {
            StoryEntry::repeatable(line, name)
        };
    };
    let UpdateRecord { before, after, .. } = control;
    let head = format!(
        "{GOOD}step {number}{GOOD:#}  {before} → {GOOD}{after}{GOOD:#}   {FAINT}{component}{FAINT:#}"
    );
    let updates = record.updates.iter();
    let updates = updates.map(|update| format!("\n{:>12}{}", "", DisplayUpdate(update)));
    StoryEntry::single(head + &updates.collect::<String>())
}

/// The effective updates of a step as text, and their locations.
fn changed(record: &StepRecord) -> (String, String) {
    let updates = record.updates.iter();
    let changed = updates.filter(|update| update.before != update.after);
    let (updates, locations): (Vec<String>, Vec<&str>) = changed
        .map(|it| (format!("{} := {}", it.location, it.after), &*it.location))
        .unzip();
    if updates.is_empty() {
        ("changed nothing".to_owned(), "steps".to_owned())
    } else {
        (updates.join(", "), locations.join(", "))
    }
}

/// Displays an update in the syntax of the language, with the previous value.
struct DisplayUpdate<'a>(&'a UpdateRecord);

impl fmt::Display for DisplayUpdate<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let UpdateRecord {
            location,
            before,
            after,
            place: _,
        } = self.0;
        write!(to, "{location} := {after}")?;
        if before != after {
            write!(to, "  {FAINT}(was {before}){FAINT:#}")?;
        }
        Ok(())
    }
}
