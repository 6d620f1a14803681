//! The commands of tabs, until the owner of the run takes them for its recording.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use asmotion_component::Time;
use asmotion_remote::{CommandOutcome, CommandRecord, TabLogin};

/// Limit on the records that are not taken. The newest ones are kept.
const MAX_RECORDS: usize = 1024;
/// Limit on the refusals that are recorded in an [`INTERVAL`]. A program without the token cannot fill the log or the disk.
const MAX_REFUSALS: u32 = 20;
const INTERVAL: Duration = Duration::from_secs(1);
/// Limit on the length of the words of a command, in characters.
const MAX_WORDS: usize = 400;

/// The tab that asks for something.
pub(crate) struct CommandOrigin<'a> {
    /// Address of the client.
    pub client: &'a str,
    /// Number of the tab.
    pub tab: u64,
    /// How it proved that it knows the token.
    pub login: TabLogin,
}

/// The commands of tabs.
pub(crate) struct CommandLog {
    /// Number of commands so far.
    count: u64,
    records: VecDeque<(Time, CommandRecord)>,
    /// Beginning of the interval in which refusals are counted.
    since: Option<Instant>,
    /// Number of refusals since then.
    refused: u32,
    /// Number of refusals that were left out since the last record.
    left_out: u64,
}

impl CommandLog {
    pub(crate) fn new() -> Self {
        Self {
            count: 0,
            records: VecDeque::new(),
            since: None,
            refused: 0,
            left_out: 0,
        }
    }

    /// Makes the record of a command that is asked.
    pub(crate) fn asked(&mut self, origin: &CommandOrigin<'_>, text: &str) -> CommandRecord {
        self.count += 1;
        CommandRecord {
            number: self.count,
            client: origin.client.to_owned(),
            tab: origin.tab,
            login: origin.login,
            text: text.chars().take(MAX_WORDS).collect(),
            outcome: CommandOutcome::Asked,
            reason: String::new(),
            left_out: std::mem::take(&mut self.left_out),
        }
    }

    /// Makes the record of a command that is refused at once; `None` if there are too many of them.
    pub(crate) fn refused(
        &mut self,
        origin: &CommandOrigin<'_>,
        (text, reason): (&str, &str),
        now: Instant,
    ) -> Option<CommandRecord> {
        if self.since.is_none_or(|since| now - since >= INTERVAL) {
            (self.since, self.refused) = (Some(now), 0);
        }
        self.refused += 1;
        if self.refused > MAX_REFUSALS {
            self.left_out += 1;
            return None;
        }
        let asked = self.asked(origin, text);
        Some(CommandRecord {
            outcome: CommandOutcome::Refused,
            reason: reason.to_owned(),
            ..asked
        })
    }

    /// Keeps a record until it is taken.
    pub(crate) fn keep(&mut self, at: Time, record: CommandRecord) {
        if self.records.len() == MAX_RECORDS {
            self.records.pop_front();
        }
        self.records.push_back((at, record));
    }

    /// Takes all records.
    pub(crate) fn take(&mut self) -> Vec<(Time, CommandRecord)> {
        self.records.drain(..).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_of_refusals_is_counted_and_does_not_hide_commands() {
        let mut log = CommandLog::new();
        let origin = CommandOrigin {
            client: "127.0.0.1:4000",
            tab: 1,
            login: TabLogin::None,
        };
        let now = Instant::now();
        let refusals = (0..100).filter_map(|_| log.refused(&origin, ("stop A", "no token"), now));
        assert_eq!(refusals.count(), 20);
        let asked = log.asked(&origin, "start A");
        assert_eq!((asked.number, asked.left_out), (21, 80));
        let later = now + INTERVAL;
        let refused = log.refused(&origin, ("stop A", "no token"), later);
        assert_eq!(refused.map(|it| it.left_out), Some(0));
        for _ in 0..=MAX_RECORDS {
            log.keep(Time::ZERO, asked.clone());
        }
        assert_eq!(log.take().len(), MAX_RECORDS);
        assert!(log.take().is_empty());
    }
}
