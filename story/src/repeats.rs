//! Repeated entries: reported the first time, counted afterwards.

use std::collections::BTreeMap;
use std::time::Duration;

use asmotion_component::Time;

use crate::entry::StoryEntry;
use crate::style::FAINT;

/// An entry that repeats sooner than this is only counted.
const SOON: Duration = Duration::from_secs(1);

/// Interval between reports of the counts while nothing else happens.
const EVERY: Duration = Duration::from_secs(5);

/// Limit on the number of names, beyond which those that have not occurred recently are forgotten.
const MOST: usize = 256;

/// Number of names in a report of the counts.
const MOST_LISTED: usize = 12;

/// Counts up to this number are not reported before another entry.
const FEW: u64 = 3;

/// Recent entries by name.
#[derive(Debug, Default)]
pub(super) struct RepeatedEntries {
    last: BTreeMap<String, Time>,
    /// Number of names after those that have not occurred recently were last forgotten.
    kept: usize,
    /// What has been counted, in order of the first repetition.
    counts: Vec<CountedEntry>,
    /// Positions in `counts` by name.
    positions: BTreeMap<String, usize>,
    /// Sum of `counts`.
    total: u64,
    /// Start of counting; `None` if nothing has been counted.
    since: Option<Time>,
}

/// Repetitions of an entry that have only been counted.
#[derive(Debug)]
struct CountedEntry {
    name: String,
    count: u64,
    /// The last one, if it says a value.
    change: Option<(Time, String)>,
}

impl RepeatedEntries {
    /// Returns whether an entry must be reported; otherwise it is counted, and its text kept if it is that of a change.
    pub(super) fn is_new(&mut self, at: Time, name: &str, change: Option<&str>) -> bool {
        let soon = self.happened_soon(at, name);
        if self.last.len() >= MOST.max(2 * self.kept) {
            self.last.retain(|_, last| at.since(*last) < SOON);
            self.kept = self.last.len();
        }
        self.last.insert(name.to_owned(), at);
        if soon {
            self.since.get_or_insert(at);
            let change = change.map(|line| (at, line.to_owned()));
            self.total += 1;
            let known = self.positions.get(name);
            match known.and_then(|position| self.counts.get_mut(*position)) {
                Some(known) => {
                    known.count += 1;
                    known.change = change;
                }
                None => {
                    self.positions.insert(name.to_owned(), self.counts.len());
                    self.counts.push(CountedEntry {
                        name: name.to_owned(),
                        count: 1,
                        change,
                    });
                }
            }
        }
        !soon
    }

    /// The report of the counts, if it is due: before another entry, or after a while.
    pub(super) fn due(&mut self, at: Time, entry: Option<&StoryEntry>) -> Option<String> {
        let since = self.since?;
        let interrupted = entry.is_some_and(|entry| match &entry.again {
            Some(name) => !self.happened_soon(at, name),
            None => true,
        });
        let interrupted = interrupted && self.total >= FEW;
        if !interrupted && at.since(since) < EVERY {
            return None;
        }
        let counts = self.take_counts();
        let others = counts.len().saturating_sub(MOST_LISTED);
        let listed = counts.iter().take(MOST_LISTED);
        let mut counts: Vec<String> = listed
            .map(|it| format!("{} ×{}", it.name, it.count))
            .collect();
        if others > 0 {
            counts.push(format!("and {others} others"));
        }
        Some(format!("{FAINT}again {}{FAINT:#}", counts.join(", ")))
    }

    /// The last changes among what has only been counted, in the order of their times. A run that ends would hide them.
    pub(super) fn last_changes(&mut self) -> Vec<(Time, String)> {
        let counts = self.take_counts().into_iter();
        let mut changes: Vec<(Time, String)> = counts.filter_map(|it| it.change).collect();
        changes.sort_by_key(|(at, _)| *at);
        changes
    }

    /// Ends counting, and returns what has been counted.
    fn take_counts(&mut self) -> Vec<CountedEntry> {
        self.since = None;
        self.total = 0;
        self.positions.clear();
        std::mem::take(&mut self.counts)
    }

    fn happened_soon(&self, at: Time, name: &str) -> bool {
        let last = self.last.get(name);
        last.is_some_and(|last| at.since(*last) < SOON)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: u64) -> Time {
        Time::ZERO + Duration::from_millis(millis)
    }

    #[test]
    fn the_last_change_is_told_at_the_end() {
        let mut repeats = RepeatedEntries::default();
        assert!(repeats.is_new(at(0), "D last", Some("last := 5")));
        assert!(repeats.last_changes().is_empty(), "it has been reported");
        assert!(!repeats.is_new(at(100), "D last", Some("last := 6")));
        assert!(repeats.is_new(at(150), "D steps", None));
        assert!(!repeats.is_new(at(200), "D steps", None));
        assert!(!repeats.is_new(at(300), "D last", Some("last := 0")));
        assert_eq!(repeats.last_changes(), [(at(300), "last := 0".to_owned())]);
        assert!(repeats.last_changes().is_empty());
    }
}
