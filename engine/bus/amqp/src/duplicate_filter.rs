//! Filters duplicates: after a resend or redelivery, each message is passed on once, in its publisher's order.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet, VecDeque};

use crate::wire::{MessageIdentity, OwnedName};

/// Limit of remembered gaps per run of numbers. An older message that fills a forgotten gap counts as a duplicate. A
/// number further ahead begins another run.
const GAPS: usize = 1024;
/// Limit of remembered runs of numbers per stream.
const RUNS: usize = 3;
/// Longest jump of a stream's numbers that counts as a loss of the messages between. A longer one is no publisher's: at
/// 10 kHz it would take a quarter of an hour.
const LONGEST_LOSS: u64 = 10_000_000;
/// Limit of remembered streams.
const STREAMS: usize = 4096;
/// Limit of remembered message ids of foreign publishers.
const NAMES: usize = 8192;

/// Sequence numbers and message ids seen so far.
#[derive(Default)]
pub(crate) struct DuplicateFilter {
    streams: HashMap<OwnedName, MessageStream>,
    /// Streams by the time of their last message, oldest first.
    last_seen: BTreeMap<u64, OwnedName>,
    now: u64,
    names: HashSet<OwnedName>,
    oldest_names: VecDeque<OwnedName>,
    missed: u64,
    jump: Option<SequenceJump>,
}

/// The runs of a stream's numbers. Usually one: another begins with a jump, by a long loss or by a forged number, and
/// the numbers after the first run stay acceptable.
struct MessageStream {
    /// The run with the latest message last.
    runs: Vec<SequenceRun>,
    last_seen: u64,
}

/// Consecutive numbers, with gaps.
struct SequenceRun {
    /// The numbers before belong to no run.
    first: u64,
    highest: u64,
    /// Numbers below the highest that have not arrived.
    gaps: BTreeSet<u64>,
    /// `true` if the numbers between the run below and this one count as missed.
    counts_as_loss: bool,
}

/// A jump of a stream's numbers that no loss explains.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SequenceJump {
    pub stream: OwnedName,
    /// The number that was highest, or lowest if the jump leads back.
    pub from: u64,
    pub to: u64,
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

    /// Returns the last jump that no loss explains, once.
    pub(crate) fn take_jump(&mut self) -> Option<SequenceJump> {
        self.jump.take()
    }

    fn is_new_in(&mut self, name: OwnedName, sequence: u64) -> bool {
        let Some(stream) = self.streams.get_mut(&name) else {
            self.now += 1;
            let now = self.now;
            // messages published before the first one received do not count as missing
            let stream = MessageStream {
                runs: vec![SequenceRun::new(sequence)],
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
        let arrival = stream.arrive(sequence);
        match arrival {
            SequenceArrival::Next { missed } => self.missed = self.missed.saturating_add(missed),
            SequenceArrival::Late => self.missed = self.missed.saturating_sub(1),
            SequenceArrival::Repeated => return false,
            SequenceArrival::Jump { from } => {
                self.jump = Some(SequenceJump {
                    stream: name,
                    from,
                    to: sequence,
                });
            }
        }
        true
    }

    fn evict(&mut self) {
        if self.streams.len() > STREAMS
            && let Some((_, name)) = self.last_seen.pop_first()
        {
            self.streams.remove(&name);
        }
    }

    fn is_new_name(&mut self, name: OwnedName) -> bool {
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

/// The place of a number among those of its stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SequenceArrival {
    /// It follows; numbers before it may be missing.
    Next { missed: u64 },
    /// It was missing so far.
    Late,
    /// It has arrived before, or is too old to know.
    Repeated,
    /// No loss explains its distance from the number before.
    Jump { from: u64 },
}

impl MessageStream {
    fn arrive(&mut self, sequence: u64) -> SequenceArrival {
        let span = GAPS as u64;
        let around = |run: &SequenceRun| {
            let lowest = run.first.saturating_sub(span);
            (lowest..=run.highest).contains(&sequence)
        };
        // a number that one run contains and another only borders on belongs to the first
        let inside = |run: &SequenceRun| (run.first..=run.highest).contains(&sequence);
        let follows = |run: &SequenceRun| run.highest < sequence && sequence - run.highest <= span;
        let place = |is: &dyn Fn(&SequenceRun) -> bool| self.runs.iter().rposition(is);
        let found = place(&inside)
            .or_else(|| place(&follows))
            .or_else(|| place(&around));
        let Some(index) = found else {
            return self.begin_run(sequence);
        };
        // the run with the latest message last
        let run = self.runs.remove(index);
        let above = self
            .runs
            .iter()
            .filter(|other| other.first > run.highest)
            .min_by_key(|other| other.first);
        let was_missed = above.is_some_and(|above| above.counts_as_loss);
        self.runs.push(run);
        match self.runs.last_mut() {
            Some(run) => run.arrive(sequence, was_missed),
            None => SequenceArrival::Repeated,
        }
    }

    fn begin_run(&mut self, sequence: u64) -> SequenceArrival {
        let below = self.runs.iter().map(|run| run.highest);
        let below = below.filter(|highest| *highest < sequence).max();
        let lowest = self.runs.iter().map(|run| run.first).min();
        let mut run = SequenceRun::new(sequence);
        let loss = below.map(|below| sequence - below - 1);
        let loss = loss.filter(|loss| *loss <= LONGEST_LOSS);
        if loss.is_some() {
            run.first = sequence - GAPS as u64;
            run.gaps.extend(run.first..sequence);
            run.counts_as_loss = true;
        }
        if self.runs.len() >= RUNS {
            self.runs.remove(0);
        }
        self.runs.push(run);
        match (loss, below.or(lowest)) {
            (Some(missed), _) => SequenceArrival::Next { missed },
            (None, from) => SequenceArrival::Jump {
                from: from.unwrap_or(sequence),
            },
        }
    }
}

impl SequenceRun {
    fn new(sequence: u64) -> Self {
        Self {
            first: sequence,
            highest: sequence,
            gaps: BTreeSet::new(),
            counts_as_loss: false,
        }
    }

    /// `was_missed`: the numbers above this run already count as missed.
    fn arrive(&mut self, sequence: u64, was_missed: bool) -> SequenceArrival {
        if sequence <= self.highest {
            return if self.gaps.remove(&sequence) {
                SequenceArrival::Late
            } else {
                SequenceArrival::Repeated
            };
        }
        let missed = sequence - self.highest - 1;
        self.gaps.extend(self.highest + 1..sequence);
        while self.gaps.len() > GAPS {
            self.gaps.pop_first();
        }
        self.highest = sequence;
        if was_missed {
            SequenceArrival::Late
        } else {
            SequenceArrival::Next { missed }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(user: &str, name: &str) -> OwnedName {
        OwnedName {
            user: Some(user.to_owned()),
            name: name.to_owned(),
        }
    }

    fn numbered(stream: &str, sequence: u64) -> MessageIdentity {
        let stream = owned("us", stream);
        MessageIdentity::Numbered { stream, sequence }
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
    fn a_long_loss_is_counted_and_its_latecomers_let_in_once() {
        let mut repeats = DuplicateFilter::default();
        assert_eq!(kept(&mut repeats, &[1, 5000, 5000]), [1, 5000]);
        assert_eq!(repeats.missed(), 4998);
        let late = [2, 2, 4999, 4999, 3, 5001];
        assert_eq!(kept(&mut repeats, &late), [2, 4999, 3, 5001]);
        assert_eq!(repeats.missed(), 4995);
        assert_eq!(repeats.take_jump(), None);
    }

    #[test]
    fn a_forged_number_hides_no_message_of_the_stream() {
        for forged in [u64::MAX, 1 << 62, 1 << 40] {
            let mut repeats = DuplicateFilter::default();
            let came = [forged, 1, 2, 4, 4];
            assert_eq!(kept(&mut repeats, &came), [forged, 1, 2, 4]);
        }
        let mut repeats = DuplicateFilter::default();
        let came = [
            7,
            8,
            1 << 62,
            9,
            1 << 61,
            10,
            u64::MAX,
            11,
            11,
            1 << 30,
            12,
            9,
        ];
        let new = [7, 8, 1 << 62, 9, 1 << 61, 10, u64::MAX, 11, 1 << 30, 12];
        assert_eq!(kept(&mut repeats, &came), new);
        assert_eq!(repeats.missed(), 0);
        let jump = repeats.take_jump().unwrap();
        assert_eq!((jump.from, jump.to), (11, 1 << 30));
        assert_eq!(repeats.take_jump(), None);
    }

    #[test]
    fn a_jump_takes_no_more_memory_than_a_small_one() {
        let mut repeats = DuplicateFilter::default();
        for jump in 0..100 {
            assert!(repeats.is_new(numbered("s", 1 + 2000 * jump)));
        }
        let runs = &repeats.streams[&owned("us", "s")].runs;
        assert!(runs.len() <= RUNS && runs.iter().all(|run| run.gaps.len() <= GAPS));
    }

    #[test]
    fn another_user_hides_nothing() {
        let mut repeats = DuplicateFilter::default();
        let forged = |user: Option<&str>, sequence| MessageIdentity::Numbered {
            stream: OwnedName {
                user: user.map(str::to_owned),
                name: "s".to_owned(),
            },
            sequence,
        };
        for user in [Some("stranger"), None] {
            for sequence in [1, 2, 3, 4] {
                assert!(repeats.is_new(forged(user, sequence)));
            }
            let named = |user: &str| MessageIdentity::Named(owned(user, "id"));
            repeats.is_new(named("stranger"));
        }
        assert_eq!(kept(&mut repeats, &[1, 2, 3]), [1, 2, 3]);
        assert!(repeats.is_new(MessageIdentity::Named(owned("us", "id"))));
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
        assert!(repeats.is_new(MessageIdentity::Named(owned("them", "a"))));
        assert!(!repeats.is_new(MessageIdentity::Named(owned("them", "a"))));
        assert!(
            repeats.is_new(MessageIdentity::Unknown) && repeats.is_new(MessageIdentity::Unknown)
        );
    }
}
