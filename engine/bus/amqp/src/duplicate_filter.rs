//! Filters duplicates: after a resend or redelivery, each message is passed on once, in its publisher's order.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet, VecDeque};

use crate::wire::MessageIdentity;

/// Limit of remembered gaps per stream. An older message that fills a forgotten gap counts as a duplicate.
const GAPS: usize = 1024;
/// Limit of remembered streams.
const STREAMS: usize = 4096;
/// Limit of remembered message ids of foreign publishers.
const NAMES: usize = 8192;

/// Sequence numbers and message ids seen so far.
#[derive(Default)]
pub(crate) struct DuplicateFilter {
    streams: HashMap<String, MessageStream>,
    /// Streams by the time of their last message, oldest first.
    last_seen: BTreeMap<u64, String>,
    now: u64,
    names: HashSet<String>,
    oldest_names: VecDeque<String>,
    missed: u64,
}

struct MessageStream {
    highest: u64,
    /// Numbers below the highest that have not arrived.
    gaps: BTreeSet<u64>,
    last_seen: u64,
}

impl DuplicateFilter {
    /// Returns whether a message arrives for the first time. A message without identity always counts as new.
    pub(crate) fn is_new(&mut self, identity: MessageIdentity) -> bool {
        match identity {
            MessageIdentity::Numbered { stream, sequence } => self.is_new_in(stream, sequence),
            MessageIdentity::Named(name) => self.is_new_name(name),
            MessageIdentity::Unknown => true,
        }
    }

    /// Returns how many messages are missing, inferred from gaps in the numbers.
    pub(crate) fn missed(&self) -> u64 {
        self.missed
    }

    fn is_new_in(&mut self, name: String, sequence: u64) -> bool {
        let Some(stream) = self.streams.get_mut(&name) else {
            self.now += 1;
            let now = self.now;
            // messages published before the first one received do not count as missing
            let stream = MessageStream {
                highest: sequence,
                gaps: BTreeSet::new(),
                last_seen: now,
            };
            self.streams.insert(name.clone(), stream);
            self.last_seen.insert(now, name);
            self.evict();
            return true;
        };
        // usually the stream is the one that was heard last
        if stream.last_seen != self.now {
            self.now += 1;
            if let Some(name) = self.last_seen.remove(&stream.last_seen) {
                self.last_seen.insert(self.now, name);
            }
            stream.last_seen = self.now;
        }
        if sequence <= stream.highest {
            let late = stream.gaps.remove(&sequence);
            self.missed -= u64::from(late);
            return late;
        }
        self.missed += sequence - stream.highest - 1;
        let first = sequence.saturating_sub(GAPS as u64).max(stream.highest + 1);
        stream.gaps.extend(first..sequence);
        while stream.gaps.len() > GAPS {
            stream.gaps.pop_first();
        }
        stream.highest = sequence;
        true
    }

    fn evict(&mut self) {
        if self.streams.len() > STREAMS
            && let Some((_, name)) = self.last_seen.pop_first()
        {
            self.streams.remove(&name);
        }
    }

    fn is_new_name(&mut self, name: String) -> bool {
        if !self.names.insert(name.clone()) {
            return false;
        }
        self.oldest_names.push_back(name);
        if self.oldest_names.len() > NAMES
            && let Some(oldest) = self.oldest_names.pop_front()
        {
            self.names.remove(&oldest);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(stream: &str, sequence: u64) -> MessageIdentity {
        MessageIdentity::Numbered {
            stream: stream.to_owned(),
            sequence,
        }
    }

    fn kept(repeats: &mut DuplicateFilter, sequences: &[u64]) -> Vec<u64> {
        let new = |sequence: &&u64| repeats.is_new(numbered("s", **sequence));
        sequences.iter().filter(new).copied().collect()
    }

    #[test]
    fn what_is_sent_again_is_taken_out() {
        let mut repeats = DuplicateFilter::default();
        let came = [5, 6, 7, 5, 6, 7, 8, 8, 9];
        assert_eq!(kept(&mut repeats, &came), [5, 6, 7, 8, 9]);
        assert_eq!(repeats.missed(), 0);
    }

    #[test]
    fn a_gap_is_counted_and_a_latecomer_let_in_once() {
        let mut repeats = DuplicateFilter::default();
        assert_eq!(kept(&mut repeats, &[1, 2, 5]), [1, 2, 5]);
        assert_eq!(repeats.missed(), 2);
        assert_eq!(kept(&mut repeats, &[4, 4, 2, 6]), [4, 6]);
        assert_eq!(repeats.missed(), 1);
    }

    #[test]
    fn a_huge_gap_takes_no_more_memory_than_a_small_one() {
        let mut repeats = DuplicateFilter::default();
        kept(&mut repeats, &[1, u64::MAX]);
        assert_eq!(repeats.missed(), u64::MAX - 2);
        assert!(repeats.streams["s"].gaps.len() <= GAPS);
    }

    #[test]
    fn streams_are_apart_and_the_silent_ones_forgotten() {
        let mut repeats = DuplicateFilter::default();
        for n in 0..2 * STREAMS {
            assert!(repeats.is_new(numbered(&n.to_string(), 1)));
            assert!(repeats.is_new(numbered("busy", n as u64 + 1)));
        }
        assert!(!repeats.is_new(numbered("busy", 1)));
        assert!(repeats.streams.len() <= STREAMS && repeats.last_seen.len() <= STREAMS);
    }

    #[test]
    fn strangers_are_known_by_their_message_ids() {
        let mut repeats = DuplicateFilter::default();
        assert!(repeats.is_new(MessageIdentity::Named("a".into())));
        assert!(!repeats.is_new(MessageIdentity::Named("a".into())));
        assert!(
            repeats.is_new(MessageIdentity::Unknown) && repeats.is_new(MessageIdentity::Unknown)
        );
    }
}
