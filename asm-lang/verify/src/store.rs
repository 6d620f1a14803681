//! The set of states that have been reached, each with a number.

use hashbrown::HashTable;
use rustc_hash::FxHasher;
use std::hash::Hasher;

/// Packed states, numbered in the order in which they were added.
#[derive(Debug, Default)]
pub(crate) struct StateStore {
    /// The bytes of all states, one after the other.
    bytes: Vec<u8>,
    /// End of each state in `bytes`.
    ends: Vec<u64>,
    index: HashTable<u32>,
}

impl StateStore {
    /// Returns the number of states.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns the bytes of a state; empty for an unknown one.
    pub fn get(&self, state: u32) -> &[u8] {
        bytes_of(&self.bytes, &self.ends, state)
    }

    /// Returns the number of a state, and `true` if it is new. `None` if 2^32 states are stored.
    pub fn add(&mut self, state: &[u8]) -> Option<(u32, bool)> {
        let Self { bytes, ends, index } = self;
        let hash = hash(state);
        let known = index.find(hash, |known| bytes_of(bytes, ends, *known) == state);
        if let Some(known) = known {
            return Some((*known, false));
        }
        let number = u32::try_from(ends.len()).ok()?;
        bytes.extend_from_slice(state);
        ends.push(bytes.len() as u64);
        let rehash = |known: &u32| self::hash(bytes_of(bytes, ends, *known));
        index.insert_unique(hash, number, rehash);
        Some((number, true))
    }

    /// Returns the memory in use, in bytes.
    pub fn memory(&self) -> usize {
        self.bytes.capacity() + self.ends.capacity() * 8 + self.index.allocation_size()
    }
}

fn bytes_of<'a>(bytes: &'a [u8], ends: &[u64], state: u32) -> &'a [u8] {
    let at = state as usize;
    let end = ends.get(at).copied().unwrap_or(0) as usize;
    let start = at.checked_sub(1).and_then(|before| ends.get(before));
    let start = start.copied().unwrap_or(0) as usize;
    bytes.get(start..end).unwrap_or_default()
}

fn hash(state: &[u8]) -> u64 {
    let mut hasher = FxHasher::default();
    hasher.write(state);
    hasher.finish()
}
