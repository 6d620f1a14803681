//! The set of states as words: an array of states and an index of their numbers.

use super::layout::Words;
use crate::spill::{Table, WordElement};
use crate::store::{StateStorage, mixed};
use std::collections::VecDeque;

/// Entry of a free place of the index.
const FREE: u32 = u32::MAX;

/// Least number of places of the index.
const MIN_PLACES: usize = 1 << 12;

/// Numbered states. An entry of the index contains the number of a state in its lower bits, and bits of its hash in the others, so
/// that different states are rarely compared.
#[derive(Debug)]
pub(crate) struct WordStore<const W: usize> {
    kept: KeptWords<W>,
    index: Vec<u32>,
    /// Number of bits of an entry that contain the number.
    number_bits: u32,
}

/// The states, or their fingerprints.
#[derive(Debug)]
enum KeptWords<const W: usize> {
    All(Table<WordElement<W>>),
    Fingerprints {
        fingerprints: Vec<u64>,
        /// The states that have not been explored yet.
        waiting: VecDeque<Words<W>>,
        /// Number of the first of them.
        first: usize,
    },
}

impl<const W: usize> KeptWords<W> {
    #[inline]
    fn len(&self) -> usize {
        match self {
            Self::All(states) => states.len(),
            Self::Fingerprints { fingerprints, .. } => fingerprints.len(),
        }
    }

    /// Returns `true` if this is the state with a number, as far as is known of it.
    #[inline]
    fn is_it(&self, number: u32, wanted: &HashedState<W>) -> bool {
        match self {
            Self::All(states) => states.get(number as usize) == Some(WordElement(wanted.state)),
            Self::Fingerprints { fingerprints, .. } => {
                fingerprints.get(number as usize) == Some(&wanted.hash)
            }
        }
    }

    fn push(&mut self, new: &HashedState<W>) {
        match self {
            Self::All(states) => states.push(WordElement(new.state)),
            Self::Fingerprints {
                fingerprints,
                waiting,
                ..
            } => {
                fingerprints.push(new.hash);
                waiting.push_back(new.state);
            }
        }
    }

    fn hash(&self, number: usize) -> Option<u64> {
        match self {
            Self::All(states) => states.get(number).map(|it| hash(&it.0)),
            Self::Fingerprints { fingerprints, .. } => fingerprints.get(number).copied(),
        }
    }
}

/// A state on its way into the store.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HashedState<const W: usize> {
    pub state: Words<W>,
    pub hash: u64,
}

impl<const W: usize> HashedState<W> {
    #[inline]
    pub fn of(state: Words<W>) -> Self {
        Self {
            state,
            hash: hash(&state),
        }
    }
}

/// Mixes the words of a state; every bit of the result depends on every bit of the state.
#[inline]
fn hash<const W: usize>(state: &Words<W>) -> u64 {
    let first = 0x9e37_79b9_7f4a_7c15;
    let hash = state.iter().fold(first, |hash, word| mixed(hash, *word));
    hash ^ hash >> 32
}

impl<const W: usize> WordStore<W> {
    pub fn new(storage: &StateStorage) -> Self {
        let kept = match storage {
            // a state of one word is no larger than its fingerprint
            StateStorage::Fingerprints if W > 1 => KeptWords::Fingerprints {
                fingerprints: Vec::new(),
                waiting: VecDeque::new(),
                first: 0,
            },
            StateStorage::Fingerprints | StateStorage::Memory | StateStorage::Files(_) => {
                KeptWords::All(Table::new(storage.spill()))
            }
        };
        Self {
            kept,
            index: vec![FREE; MIN_PLACES],
            number_bits: 12,
        }
    }

    /// Returns the number of states.
    #[inline]
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Returns a state; `None` for one that is unknown or no longer kept.
    #[inline]
    pub fn get(&self, number: u32) -> Option<Words<W>> {
        match &self.kept {
            KeptWords::All(states) => states.get(number as usize).map(|it| it.0),
            KeptWords::Fingerprints { waiting, first, .. } => {
                let at = (number as usize).checked_sub(*first)?;
                waiting.get(at).copied()
            }
        }
    }

    /// Returns `true` if only fingerprints are kept of states that have been explored.
    pub fn is_compact(&self) -> bool {
        matches!(self.kept, KeptWords::Fingerprints { .. })
    }

    /// Forgets the states before this one, if only fingerprints are kept of them.
    pub fn forget_before(&mut self, state: u32) {
        if let KeptWords::Fingerprints { waiting, first, .. } = &mut self.kept {
            while *first < state as usize && waiting.pop_front().is_some() {
                *first += 1;
            }
        }
    }

    /// Returns the first place of a hash.
    #[inline]
    fn place(&self, hash: u64) -> usize {
        ((u128::from(hash) * self.index.len() as u128) >> 64) as usize
    }

    /// Returns the entry of a hash without its number.
    #[inline]
    fn tag(&self, hash: u64) -> u32 {
        // the upper bits determine the place
        (hash as u32) << self.number_bits
    }

    /// Reads the place of a state in the index, so that it is in the cache when the state is added.
    #[inline]
    pub fn touch(&self, hash: u64) -> u32 {
        self.index.get(self.place(hash)).copied().unwrap_or(FREE)
    }

    /// Returns the number of a state and `true` if it is new. `None` if no number is left.
    #[inline]
    pub fn add(&mut self, new: &HashedState<W>) -> Option<(u32, bool)> {
        match self.find(new) {
            Ok(known) => Some((known, false)),
            Err(place) => self.insert(new, place).map(|number| (number, true)),
        }
    }

    /// Returns the number of a state, or the free place for it.
    #[inline]
    pub fn find(&self, wanted: &HashedState<W>) -> Result<u32, usize> {
        let mask = (1u32 << self.number_bits) - 1;
        let tag = self.tag(wanted.hash);
        let mut place = self.place(wanted.hash);
        loop {
            let entry = self.index.get(place).copied().unwrap_or(FREE);
            if entry == FREE {
                return Err(place);
            }
            if entry & !mask == tag {
                let number = entry & mask;
                if self.kept.is_it(number, wanted) {
                    return Ok(number);
                }
            }
            place += 1;
            if place == self.index.len() {
                place = 0;
            }
        }
    }

    fn insert(&mut self, new: &HashedState<W>, mut place: usize) -> Option<u32> {
        let number = self.kept.len();
        // at most three quarters of the places are taken, and no entry is that of a free place
        if (number + 1) * 4 > self.index.len() * 3 || number + 1 >= 1 << self.number_bits {
            self.grow()?;
            place = self.find(new).err()?;
        }
        self.kept.push(new);
        let entry = self.tag(new.hash) | number as u32;
        if let Some(free) = self.index.get_mut(place) {
            *free = entry;
        }
        Some(number as u32)
    }

    fn grow(&mut self) -> Option<()> {
        let places = self.index.len() / 2 * 3;
        // one number remains unused, so that no entry has all bits
        let needed = usize::BITS - places.leading_zeros();
        if needed > 31 {
            return None;
        }
        self.number_bits = needed;
        self.index = Vec::new();
        self.index = vec![FREE; places];
        for number in 0..self.kept.len() {
            let Some(hash) = self.kept.hash(number) else {
                continue;
            };
            let mut place = self.place(hash);
            while self.index.get(place).is_some_and(|entry| *entry != FREE) {
                place += 1;
                if place == self.index.len() {
                    place = 0;
                }
            }
            let entry = self.tag(hash) | number as u32;
            if let Some(free) = self.index.get_mut(place) {
                *free = entry;
            }
        }
        Some(())
    }

    /// Returns the memory in use, in bytes.
    pub fn memory(&self) -> usize {
        let kept = match &self.kept {
            KeptWords::All(Table::Memory(states)) => states.len() * size_of::<Words<W>>(),
            KeptWords::All(states) => states.memory(),
            KeptWords::Fingerprints {
                fingerprints,
                waiting,
                ..
            } => fingerprints.len() * 8 + waiting.len() * size_of::<Words<W>>(),
        };
        kept + self.index.len() * 4
    }
}
