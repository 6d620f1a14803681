//! The set of states that have been reached, each with a number.

use crate::spill::{Spill, Table};
use hashbrown::HashTable;
use std::borrow::Cow;
use std::collections::VecDeque;

/// The storage of the states of an exploration.
#[derive(Clone, Debug, Default)]
pub(crate) enum StateStorage {
    /// In memory.
    #[default]
    Memory,
    /// As a fingerprint of 64 bits each, apart from those that have not been explored yet.
    Fingerprints,
    /// In files.
    Files(Spill),
}

impl StateStorage {
    /// Returns the space for tables outside of memory, if there is one.
    pub fn spill(&self) -> Option<&Spill> {
        match self {
            Self::Memory | Self::Fingerprints => None,
            Self::Files(spill) => Some(spill),
        }
    }
}

/// Packed states, numbered in the order in which they were added.
#[derive(Debug, Default)]
pub(crate) struct StateStore {
    kept: KeptBytes,
    index: HashTable<u32>,
}

/// The states, or their fingerprints.
#[derive(Debug)]
enum KeptBytes {
    All {
        /// The bytes of all states, one after the other.
        bytes: Table<u8>,
        /// End of each state in `bytes`.
        ends: Table<u64>,
        /// Hash of each state, if its bytes are not in memory.
        hashes: Option<Vec<u64>>,
    },
    Fingerprints {
        fingerprints: Vec<u64>,
        /// The states that have not been explored yet.
        waiting: VecDeque<Box<[u8]>>,
        /// Number of the first of them.
        first: u32,
        /// Number of their bytes.
        bytes: usize,
    },
}

impl Default for KeptBytes {
    fn default() -> Self {
        Self::All {
            bytes: Table::default(),
            ends: Table::default(),
            hashes: None,
        }
    }
}

impl StateStore {
    pub fn new(storage: &StateStorage) -> Self {
        let kept = match storage {
            StateStorage::Memory => KeptBytes::default(),
            StateStorage::Fingerprints => KeptBytes::Fingerprints {
                fingerprints: Vec::new(),
                waiting: VecDeque::new(),
                first: 0,
                bytes: 0,
            },
            StateStorage::Files(spill) => KeptBytes::All {
                bytes: Table::new(Some(spill)),
                ends: Table::new(Some(spill)),
                hashes: Some(Vec::new()),
            },
        };
        Self {
            kept,
            index: HashTable::new(),
        }
    }

    /// Returns the number of states.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Returns the bytes of a state; empty for one that is unknown or no longer kept.
    pub fn get(&self, state: u32) -> Cow<'_, [u8]> {
        match &self.kept {
            KeptBytes::All { bytes, ends, .. } => {
                let (start, end) = range(ends, state);
                match bytes {
                    Table::Memory(all) => Cow::Borrowed(all.get(start..end).unwrap_or_default()),
                    Table::Spilled(_) => {
                        let mut read = Vec::with_capacity(end - start);
                        bytes.read(start..end, &mut read);
                        Cow::Owned(read)
                    }
                }
            }
            KeptBytes::Fingerprints { waiting, first, .. } => {
                let at = state.checked_sub(*first);
                let kept = at.and_then(|at| waiting.get(at as usize));
                Cow::Borrowed(kept.map(|it| &**it).unwrap_or_default())
            }
        }
    }

    /// Returns the number of a state; `None` if it is not stored.
    pub fn find(&self, state: &[u8]) -> Option<u32> {
        let hash = fingerprint(state);
        let is_it = |known: &u32| self.kept.is_it(*known, hash, state);
        self.index.find(hash, is_it).copied()
    }

    /// Returns the number of a state, and `true` if it is new. `None` if 2^32 states are stored.
    pub fn add(&mut self, state: &[u8]) -> Option<(u32, bool)> {
        let Self { kept, index } = self;
        let hash = fingerprint(state);
        if let Some(known) = index.find(hash, |known| kept.is_it(*known, hash, state)) {
            return Some((*known, false));
        }
        let number = u32::try_from(kept.len()).ok()?;
        match kept {
            KeptBytes::All {
                bytes,
                ends,
                hashes,
            } => {
                bytes.extend(state.iter().copied());
                ends.push(bytes.len() as u64);
                if let Some(hashes) = hashes {
                    hashes.push(hash);
                }
            }
            KeptBytes::Fingerprints {
                fingerprints,
                waiting,
                bytes,
                ..
            } => {
                fingerprints.push(hash);
                *bytes += state.len();
                waiting.push_back(state.into());
            }
        }
        index.insert_unique(hash, number, |known| kept.hash(*known));
        Some((number, true))
    }

    /// Forgets the bytes of the states before this one, if only fingerprints are kept of them.
    pub fn forget_before(&mut self, state: u32) {
        if let KeptBytes::Fingerprints {
            waiting,
            first,
            bytes,
            ..
        } = &mut self.kept
        {
            while *first < state
                && let Some(explored) = waiting.pop_front()
            {
                *first += 1;
                *bytes -= explored.len();
            }
        }
    }

    /// Returns `true` if only fingerprints are kept of states that have been explored.
    pub fn is_compact(&self) -> bool {
        matches!(self.kept, KeptBytes::Fingerprints { .. })
    }

    /// Returns the memory in use, in bytes.
    pub fn memory(&self) -> usize {
        let kept = match &self.kept {
            KeptBytes::All {
                bytes,
                ends,
                hashes,
            } => {
                let hashes = hashes.as_ref().map_or(0, Vec::capacity);
                bytes.memory() + ends.memory() + hashes * 8
            }
            KeptBytes::Fingerprints {
                fingerprints,
                waiting,
                bytes,
                ..
            } => fingerprints.capacity() * 8 + waiting.capacity() * size_of::<Box<[u8]>>() + bytes,
        };
        kept + self.index.allocation_size()
    }
}

impl KeptBytes {
    fn len(&self) -> usize {
        match self {
            Self::All { ends, .. } => ends.len(),
            Self::Fingerprints { fingerprints, .. } => fingerprints.len(),
        }
    }

    /// Returns `true` if this is the state with a number, as far as is known of it.
    fn is_it(&self, number: u32, hash: u64, state: &[u8]) -> bool {
        match self {
            Self::All {
                bytes,
                ends,
                hashes,
            } => {
                let known = hashes.as_ref().and_then(|all| all.get(number as usize));
                if known.is_some_and(|known| *known != hash) {
                    return false;
                }
                let (start, end) = range(ends, number);
                end - start == state.len() && bytes.is_at(start, state)
            }
            Self::Fingerprints { fingerprints, .. } => {
                fingerprints.get(number as usize) == Some(&hash)
            }
        }
    }

    fn hash(&self, number: u32) -> u64 {
        match self {
            Self::All {
                hashes: Some(hashes),
                ..
            }
            | Self::Fingerprints {
                fingerprints: hashes,
                ..
            } => hashes.get(number as usize).copied().unwrap_or_default(),
            Self::All {
                bytes,
                ends,
                hashes: None,
            } => {
                let (start, end) = range(ends, number);
                let mut read = Vec::new();
                if let Table::Memory(all) = bytes {
                    return fingerprint(all.get(start..end).unwrap_or_default());
                }
                bytes.read(start..end, &mut read);
                fingerprint(&read)
            }
        }
    }
}

fn range(ends: &Table<u64>, state: u32) -> (usize, usize) {
    let at = state as usize;
    let end = ends.get(at).unwrap_or(0) as usize;
    let start = at.checked_sub(1).and_then(|before| ends.get(before));
    // the end of an unreadable table is 0
    (start.unwrap_or(0).min(end as u64) as usize, end)
}

/// Mixes a word into a hash, so that every bit of the result depends on every bit of both.
#[inline]
pub(crate) fn mixed(hash: u64, word: u64) -> u64 {
    const FIRST: u64 = 0x9e37_79b9_7f4a_7c15;
    const SECOND: u64 = 0xd1b5_4a32_d192_ed03;
    let product = u128::from(word ^ hash) * u128::from(SECOND);
    (product as u64 ^ (product >> 64) as u64).wrapping_mul(FIRST)
}

/// The hash of a state: 64 bits that all depend on all of its bytes and on their number.
fn fingerprint(state: &[u8]) -> u64 {
    let mut hash = mixed(0x9e37_79b9_7f4a_7c15, state.len() as u64);
    let (words, rest) = state.as_chunks::<8>();
    for word in words {
        hash = mixed(hash, u64::from_le_bytes(*word));
    }
    if !rest.is_empty() {
        let mut last = [0; 8];
        for (to, from) in last.iter_mut().zip(rest) {
            *to = *from;
        }
        hash = mixed(hash, u64::from_le_bytes(last));
    }
    let hash = hash ^ hash >> 32;
    hash.wrapping_mul(0xd1b5_4a32_d192_ed03) ^ hash >> 29
}

/// Returns the expected number of pairs among so many states that have the same fingerprint of 64 bits, which is that of the states
/// that are taken for others.
pub(crate) fn expected_missed(states: u64) -> f64 {
    let states = states as f64;
    states * (states - 1.0).max(0.0) / 2.0 / 2.0f64.powi(64)
}
