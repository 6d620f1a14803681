//! Filters duplicates: after a resend or redelivery, each message is passed on once, in its publisher's order.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

use crate::wire::{MessageIdentity, StreamId};
use asmotion_bus::TransitTimes;

/// Limit of remembered gaps per stream.
const GAPS: usize = 1024;
/// Largest jump of a stream whose numbers count as missing. A larger one is no loss but a wrong or forged number.
const LARGEST_JUMP: u64 = 1 << 20;
/// Limit of remembered streams.
const STREAMS: usize = 4096;
/// Limit of remembered message ids of foreign publishers.
const NAMES: usize = 8192;

/// Sequence numbers and message ids seen so far.
///
/// A number that has not arrived is never taken for a duplicate, however far the stream has jumped ahead: a forged number
/// cannot mute its stream. Only streams of one authenticated user are compared at all; see [`MessageIdentity`].
#[derive(Default)]
pub(crate) struct DuplicateFilter {
    streams: HashMap<StreamId, MessageStream>,
    /// Streams by the time of their last message, oldest first.
    last_seen: BTreeMap<u64, StreamId>,
    now: u64,
    names: HashSet<(String, String)>,
    oldest_names: VecDeque<(String, String)>,
    missed: u64,
    jump: Option<SequenceJump>,
}

/// A jump of a stream's numbers that no loss explains.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SequenceJump {
    /// The stream's user; empty if its messages name none.
    pub user: String,
    /// The highest number before.
    pub from: u64,
    pub to: u64,
}

struct MessageStream {
    highest: u64,
    transit: TransitTimes,
    /// Ranges of numbers below the highest that have not arrived, by their first numbers.
    gaps: BTreeMap<u64, Gap>,
    last_seen: u64,
}

/// A range of numbers that have not arrived.
#[derive(Debug, Clone, Copy)]
struct Gap {
    last: u64,
    /// The numbers count as missing.
    counted: bool,
}

impl DuplicateFilter {
    /// Returns whether a message arrives for the first time. A message without identity always counts as new.
    pub(crate) fn is_new(&mut self, identity: &MessageIdentity) -> bool {
        match identity {
            MessageIdentity::Numbered { stream, sequence } => self.is_new_in(stream, *sequence),
            MessageIdentity::Named { user, id } => self.is_new_name((user.clone(), id.clone())),
            MessageIdentity::Unknown => true,
        }
    }

    /// Returns how many messages are missing, inferred from gaps in the numbers.
    pub(crate) fn missed(&self) -> u64 {
        self.missed
    }

    /// The times that the messages of a known stream take.
    pub(crate) fn transit(&mut self, identity: &MessageIdentity) -> Option<&mut TransitTimes> {
        match identity {
            MessageIdentity::Numbered { stream, .. } => {
                let stream = self.streams.get_mut(stream)?;
                Some(&mut stream.transit)
            }
            MessageIdentity::Named { .. } | MessageIdentity::Unknown => None,
        }
    }

    fn is_new_in(&mut self, id: &StreamId, sequence: u64) -> bool {
        let Some(stream) = self.streams.get_mut(id) else {
            self.now += 1;
            let now = self.now;
            self.streams
                .insert(id.clone(), MessageStream::new(sequence, now));
            self.last_seen.insert(now, id.clone());
            self.evict();
            return true;
        };
        // usually the stream is the one that was heard last
        if stream.last_seen != self.now {
            self.now += 1;
            if let Some(id) = self.last_seen.remove(&stream.last_seen) {
                self.last_seen.insert(self.now, id);
            }
            stream.last_seen = self.now;
        }
        if sequence <= stream.highest {
            let gap = stream.fill(sequence);
            let counted = gap.is_some_and(|gap| gap.counted);
            self.missed = self.missed.saturating_sub(counted.into());
            return gap.is_some();
        }
        let from = stream.highest;
        match stream.advance(sequence) {
            Some(missing) => self.missed += missing,
            None => {
                let to = sequence;
                self.jump = Some(SequenceJump {
                    user: id.user.clone(),
                    from,
                    to,
                });
            }
        }
        true
    }

    /// Returns the last jump that no loss explains, once.
    pub(crate) fn take_jump(&mut self) -> Option<SequenceJump> {
        self.jump.take()
    }

    fn evict(&mut self) {
        if self.streams.len() > STREAMS
            && let Some((_, name)) = self.last_seen.pop_first()
        {
            self.streams.remove(&name);
        }
    }

    fn is_new_name(&mut self, name: (String, String)) -> bool {
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

impl MessageStream {
    /// A stream whose first message has this number. Messages before it do not count as missing; one that arrives after all
    /// is new.
    fn new(sequence: u64, last_seen: u64) -> Self {
        let before = sequence.checked_sub(1).map(|last| {
            let counted = false;
            (0, Gap { last, counted })
        });
        Self {
            highest: sequence,
            transit: TransitTimes::default(),
            gaps: before.into_iter().collect(),
            last_seen,
        }
    }

    /// Records a number above the highest. Returns how many numbers are missing in between; `None` if it is too far ahead
    /// for a loss.
    fn advance(&mut self, sequence: u64) -> Option<u64> {
        let missing = sequence - self.highest - 1;
        let counted = missing <= LARGEST_JUMP;
        if missing > 0 {
            let last = sequence - 1;
            self.gaps.insert(self.highest + 1, Gap { last, counted });
        }
        self.highest = sequence;
        self.limit_gaps();
        counted.then_some(missing)
    }

    /// Removes a number from the gaps. Returns the gap to which it belonged.
    fn fill(&mut self, sequence: u64) -> Option<Gap> {
        let (&first, &gap) = self.gaps.range(..=sequence).next_back()?;
        if sequence > gap.last {
            return None;
        }
        self.gaps.remove(&first);
        if first < sequence {
            let last = sequence - 1;
            self.gaps.insert(first, Gap { last, ..gap });
        }
        if sequence < gap.last {
            self.gaps.insert(sequence + 1, gap);
        }
        self.limit_gaps();
        Some(gap)
    }

    /// Merges two neighbouring gaps if there are too many: the oldest two that both count as missing, or both do not. The
    /// numbers between them, which have arrived, would be accepted again: that is better than to reject one that has not.
    fn limit_gaps(&mut self) {
        if self.gaps.len() <= GAPS {
            return;
        }
        let neighbours = || self.gaps.iter().zip(self.gaps.iter().skip(1));
        let alike = neighbours().find(|(one, next)| one.1.counted == next.1.counted);
        if let Some(((&first, _), (&second, _))) = alike.or_else(|| neighbours().next())
            && let Some(next) = self.gaps.remove(&second)
            && let Some(merged) = self.gaps.get_mut(&first)
        {
            merged.last = next.last;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(stream: &str, sequence: u64) -> MessageIdentity {
        of_user("robot", stream, sequence)
    }

    fn of_user(user: &str, stream: &str, sequence: u64) -> MessageIdentity {
        MessageIdentity::Numbered {
            stream: StreamId {
                user: user.to_owned(),
                name: stream.to_owned(),
            },
            sequence,
        }
    }

    fn named(user: &str, id: &str) -> MessageIdentity {
        MessageIdentity::Named {
            user: user.to_owned(),
            id: id.to_owned(),
        }
    }

    fn kept(repeats: &mut DuplicateFilter, sequences: &[u64]) -> Vec<u64> {
        let new = |sequence: &&u64| repeats.is_new(&numbered("s", **sequence));
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
    fn a_forged_number_mutes_nobody() {
        let mut repeats = DuplicateFilter::default();
        assert_eq!(kept(&mut repeats, &[1, 2]), [1, 2]);
        for (user, number) in [("dash", 1 << 62), ("", 1 << 62), ("dash", u64::MAX)] {
            assert!(repeats.is_new(&of_user(user, "s", number)));
        }
        assert_eq!(
            (kept(&mut repeats, &[3, 4, 3]), repeats.missed()),
            (vec![3, 4], 0)
        );
        // even by the same user
        assert_eq!(
            kept(&mut repeats, &[u64::MAX, 1 << 62]),
            [u64::MAX, 1 << 62]
        );
        assert_eq!(kept(&mut repeats, &[5, 6, 5, 4, 8, 7]), [5, 6, 8, 7]);
        assert_eq!(repeats.missed(), 0, "no loss of 2^62 messages is reported");
        let jump = repeats.take_jump().unwrap();
        assert_eq!((jump.from, jump.to), (4, u64::MAX));
        assert_eq!(repeats.take_jump(), None);
        // nor if the forged number is the first that arrives
        let mut late = DuplicateFilter::default();
        assert_eq!(kept(&mut late, &[1 << 62, 1, 2, 1]), [1 << 62, 1, 2]);
    }

    #[test]
    fn any_number_of_gaps_takes_bounded_memory_and_rejects_nothing_new() {
        let mut repeats = DuplicateFilter::default();
        let odd: Vec<u64> = (0..4 * GAPS as u64).map(|n| 2 * n + 1).collect();
        assert_eq!(kept(&mut repeats, &odd), odd);
        assert!(repeats.streams.values().all(|it| it.gaps.len() <= GAPS));
        let even: Vec<u64> = (1..4 * GAPS as u64).map(|n| 2 * n).collect();
        assert_eq!(kept(&mut repeats, &even), even);
        assert_eq!(repeats.missed(), 0);
    }

    #[test]
    fn streams_are_apart_and_the_silent_ones_forgotten() {
        let mut repeats = DuplicateFilter::default();
        for n in 0..2 * STREAMS {
            assert!(repeats.is_new(&numbered(&n.to_string(), 1)));
            assert!(repeats.is_new(&numbered("busy", n as u64 + 1)));
        }
        assert!(!repeats.is_new(&numbered("busy", 1)));
        assert!(repeats.streams.len() <= STREAMS && repeats.last_seen.len() <= STREAMS);
    }

    #[test]
    fn strangers_are_known_by_their_message_ids() {
        let mut repeats = DuplicateFilter::default();
        assert!(repeats.is_new(&named("x", "a")) && repeats.is_new(&named("y", "a")));
        assert!(!repeats.is_new(&named("x", "a")));
        assert!(
            repeats.is_new(&MessageIdentity::Unknown) && repeats.is_new(&MessageIdentity::Unknown)
        );
    }
}
