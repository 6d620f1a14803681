//! Sets of nodes or edges.

/// A set of numbers below a fixed size, one bit each.
///
/// Operations on two sets treat numbers beyond the size of the smaller one as absent.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Bits {
    words: Vec<u64>,
    size: usize,
}

impl Bits {
    /// Returns the empty set of numbers below `size`.
    pub fn new(size: usize) -> Self {
        Self {
            words: vec![0; size.div_ceil(64)],
            size,
        }
    }

    /// Returns the set of all numbers below `size`.
    pub fn full(size: usize) -> Self {
        let mut bits = Self {
            words: vec![u64::MAX; size.div_ceil(64)],
            size,
        };
        bits.clear_tail();
        bits
    }

    /// Returns the set of the given numbers; numbers that are not below `size` are left out.
    pub fn from_ones(size: usize, ones: impl IntoIterator<Item = usize>) -> Self {
        let mut bits = Self::new(size);
        for one in ones {
            bits.insert(one);
        }
        bits
    }

    /// Returns the set of the numbers below `size` that satisfy a condition.
    pub fn from_fn(size: usize, mut contains: impl FnMut(usize) -> bool) -> Self {
        let mut bits = Self::new(size);
        for (at, word) in bits.words.iter_mut().enumerate() {
            for bit in 0..64.min(size - 64 * at) {
                *word |= u64::from(contains(64 * at + bit)) << bit;
            }
        }
        bits
    }

    /// Returns the set of numbers below `size` whose bits are set in `words`; missing words are 0.
    pub(crate) fn from_words(size: usize, mut words: Vec<u64>) -> Self {
        words.resize(size.div_ceil(64), 0);
        let mut bits = Self { words, size };
        bits.clear_tail();
        bits
    }

    /// Returns the bound of the numbers; [`Self::count`] is the number of elements.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Returns whether the set contains a number.
    #[inline]
    pub fn contains(&self, number: usize) -> bool {
        let word = self.words.get(number / 64).copied().unwrap_or(0);
        word >> (number % 64) & 1 != 0
    }

    /// Adds a number, and returns whether it is new. A number that is not below the size is not added.
    #[inline]
    pub fn insert(&mut self, number: usize) -> bool {
        if number >= self.size {
            return false;
        }
        let bit = 1 << (number % 64);
        let Some(word) = self.words.get_mut(number / 64) else {
            return false;
        };
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }

    /// Removes a number.
    pub fn remove(&mut self, number: usize) {
        if let Some(word) = self.words.get_mut(number / 64) {
            *word &= !(1 << (number % 64));
        }
    }

    /// Returns the number of elements.
    pub fn count(&self) -> usize {
        let ones = self.words.iter().map(|word| word.count_ones() as usize);
        ones.sum()
    }

    /// Returns whether the set has no element.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|word| *word == 0)
    }

    /// Returns whether both sets have a common element.
    pub fn intersects(&self, other: &Self) -> bool {
        let mut pairs = self.words.iter().zip(&other.words);
        pairs.any(|(one, other)| one & other != 0)
    }

    /// Returns whether the other set contains every element.
    pub fn is_subset(&self, other: &Self) -> bool {
        let others = other.words.iter().copied().chain(std::iter::repeat(0));
        self.words
            .iter()
            .zip(others)
            .all(|(one, other)| one & !other == 0)
    }

    /// Adds the elements of another set.
    pub fn union_with(&mut self, other: &Self) {
        for (one, other) in self.words.iter_mut().zip(&other.words) {
            *one |= other;
        }
        self.clear_tail();
    }

    /// Keeps the elements that another set contains, too.
    pub fn intersect_with(&mut self, other: &Self) {
        let others = other.words.iter().copied().chain(std::iter::repeat(0));
        for (one, other) in self.words.iter_mut().zip(others) {
            *one &= other;
        }
    }

    /// Removes the elements of another set.
    pub fn subtract(&mut self, other: &Self) {
        for (one, other) in self.words.iter_mut().zip(&other.words) {
            *one &= !other;
        }
    }

    /// Replaces the set by its complement.
    pub fn complement(&mut self) {
        for word in &mut self.words {
            *word = !*word;
        }
        self.clear_tail();
    }

    /// Returns the complement.
    #[must_use]
    pub fn complemented(mut self) -> Self {
        self.complement();
        self
    }

    /// Returns the elements in ascending order.
    pub fn ones(&self) -> impl Iterator<Item = usize> + '_ {
        self.words.iter().enumerate().flat_map(|(at, word)| {
            let mut rest = *word;
            std::iter::from_fn(move || {
                let bit = rest.trailing_zeros() as usize;
                let is_one = rest != 0;
                rest &= rest.wrapping_sub(1);
                is_one.then_some(64 * at + bit)
            })
        })
    }

    /// Clears the bits beyond the size, which every operation expects to be 0.
    fn clear_tail(&mut self) {
        let used = self.size % 64;
        if let Some(last) = self.words.last_mut()
            && used != 0
        {
            *last &= (1 << used) - 1;
        }
    }
}
