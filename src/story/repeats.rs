//! What happens again and again: told the first time, counted afterwards.

use std::collections::BTreeMap;
use std::time::Duration;

use asmotion_component::Time;

use super::StoryEntry;
use crate::terminal::FAINT;

/// What happens again sooner than this is only counted.
const SOON: Duration = Duration::from_secs(1);

/// How often the counts are told while nothing else happens.
const EVERY: Duration = Duration::from_secs(5);

/// With so many names those that did not happen lately are forgotten.
const MOST: usize = 256;

/// So few are not worth a line before something else is told.
const FEW: u64 = 3;

/// What happened lately, by name.
#[derive(Debug, Default)]
pub(super) struct RepeatedEntries {
    last: BTreeMap<String, Time>,
    /// How often it happened again, in the order in which it first did.
    counts: Vec<(String, u64)>,
    /// Since when is counted.
    since: Option<Time>,
}

impl RepeatedEntries {
    /// Whether something is to be told; it is counted otherwise.
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

    /// What has been counted, before something else is told, or after a while.
    pub(super) fn due(&mut self, at: Time, told: Option<&StoryEntry>) -> Option<String> {
        let since = self.since?;
        let interrupted = told.is_some_and(|told| match &told.again {
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
