//! Repeated entries: reported the first time, counted afterwards.

use std::collections::BTreeMap;
use std::time::Duration;

use asmotion_component::Time;

use super::StoryEntry;
use crate::terminal::FAINT;

/// An entry that repeats sooner than this is only counted.
const SOON: Duration = Duration::from_secs(1);

/// Interval between reports of the counts while nothing else happens.
const EVERY: Duration = Duration::from_secs(5);

/// Limit on the number of names, beyond which those that have not occurred recently are forgotten.
const MOST: usize = 256;

/// Counts up to this number are not reported before another entry.
const FEW: u64 = 3;

/// Recent entries by name.
#[derive(Debug, Default)]
pub(super) struct RepeatedEntries {
    last: BTreeMap<String, Time>,
    /// Number of repetitions, in order of the first one.
    counts: Vec<(String, u64)>,
    /// Start of counting; `None` if nothing has been counted.
    since: Option<Time>,
}

impl RepeatedEntries {
    /// Returns whether an entry must be reported; otherwise it is counted.
    pub(super) fn is_new(&mut self, at: Time, name: &str) -> bool {
        let soon = self.happened_soon(at, name);
        if self.last.len() >= MOST {
            self.last.retain(|_, last| at.since(*last) < SOON);
        }
        self.last.insert(name.to_owned(), at);
        if soon {
            self.since.get_or_insert(at);
            match self.counts.iter_mut().find(|(known, _)| known == name) {
                Some((_, count)) => *count += 1,
                None => self.counts.push((name.to_owned(), 1)),
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
        let count: u64 = self.counts.iter().map(|(_, count)| count).sum();
        let interrupted = interrupted && count >= FEW;
        if !interrupted && at.since(since) < EVERY {
            return None;
        }
        self.since = None;
        let counts = self.counts.drain(..);
        let counts: Vec<String> = counts
            .map(|(name, count)| format!("{name} ×{count}"))
            .collect();
        Some(format!("{FAINT}again {}{FAINT:#}", counts.join(", ")))
    }

    fn happened_soon(&self, at: Time, name: &str) -> bool {
        let last = self.last.get(name);
        last.is_some_and(|last| at.since(*last) < SOON)
    }
}
