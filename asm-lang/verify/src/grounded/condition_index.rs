//! Which of many conditions hold in a state, found with a few look-ups for all of them together.

use super::condition::WordCondition;
use super::layout::{Field, WordLayout, Words, overlaps, union};

/// Limit for the bits of a window.
const MAX_BITS: u32 = 8;

/// Limit for the words of the sets of a window with several fields: those that states look up should stay in the caches.
const MAX_WINDOW_WORDS: usize = 512;

/// Limit for the words of all sets.
const MAX_WORDS: usize = 1 << 15;

/// Consecutive bits of a word, the fields in which are looked up together.
#[derive(Clone, Copy, Debug)]
struct FieldWindow {
    word: usize,
    shift: u32,
    bits: u32,
}

impl FieldWindow {
    fn of(field: &Field) -> Self {
        Self {
            word: field.word,
            shift: field.shift,
            bits: field.bits(),
        }
    }

    /// Returns the window from the first bit of one to the last bit of another that follows it.
    fn up_to(self, other: Self) -> Option<Self> {
        let bits = (other.shift + other.bits).checked_sub(self.shift)?;
        (self.word == other.word).then_some(Self { bits, ..self })
    }

    /// Number of codes of its bits.
    fn codes(self) -> usize {
        1 << self.bits
    }

    #[inline]
    fn code<const W: usize>(self, state: &Words<W>) -> usize {
        let word = state.get(self.word).copied().unwrap_or(0);
        (word >> self.shift) as usize & (self.codes() - 1)
    }

    /// Returns a state with a code in the window, and no other bits.
    fn state<const W: usize>(self, code: u64) -> Words<W> {
        let mut state = [0; W];
        if let Some(word) = state.get_mut(self.word) {
            *word = code << self.shift;
        }
        state
    }

    /// Returns its bits.
    fn mask<const W: usize>(self) -> Words<W> {
        self.state(self.codes() as u64 - 1)
    }
}

/// Conditions, with the set of those that each code of a few bits permits.
#[derive(Debug, Default)]
pub(crate) struct ConditionIndex<const W: usize> {
    /// Number of words of a set of conditions.
    words: usize,
    /// Windows, each with the place of its sets in `sets`.
    windows: Vec<(FieldWindow, usize)>,
    /// For each window and code, the conditions that it permits.
    sets: Vec<u64>,
    /// All conditions.
    all: Vec<u64>,
    /// Conditions that the windows do not decide.
    undecided: Vec<u64>,
    conditions: Vec<WordCondition<W>>,
}

impl<const W: usize> ConditionIndex<W> {
    pub fn of(layout: &WordLayout, conditions: Vec<WordCondition<W>>) -> Self {
        let words = conditions.len().div_ceil(64);
        let reads: Vec<Words<W>> = conditions.iter().map(|it| it.reads()).collect();
        let mut windows = windows(layout, words, &reads);
        // what most conditions read excludes most of them
        windows.sort_by_key(|window| {
            let readers = reads.iter().filter(|reads| overlaps(reads, &window.mask()));
            std::cmp::Reverse(readers.count())
        });
        let mut index = Self {
            words,
            windows: Vec::new(),
            sets: Vec::new(),
            all: set_of(&conditions, |_| true),
            undecided: Vec::new(),
            conditions: Vec::new(),
        };
        for window in windows {
            if index.sets.len() + window.codes() * words > MAX_WORDS {
                continue;
            }
            index.windows.push((window, index.sets.len()));
            for code in 0..window.codes() as u64 {
                let state = window.state(code);
                let permitted = set_of(&conditions, |it| it.is_possible(&window.mask(), &state));
                index.sets.extend(permitted);
            }
        }
        let masks = index.windows.iter().map(|(window, _)| window.mask());
        let masks: Vec<Words<W>> = masks.collect();
        index.undecided = set_of(&conditions, |it| !it.is_decided_by(&masks));
        index.conditions = conditions;
        index
    }

    /// Number of conditions.
    pub fn len(&self) -> usize {
        self.conditions.len()
    }

    /// Returns `true` if one of the conditions holds in a state.
    #[inline]
    pub fn holds(&self, state: &Words<W>) -> bool {
        self.held(state).next().is_some()
    }

    /// Returns the set of all conditions.
    pub fn all(&self) -> Vec<u64> {
        self.all.clone()
    }

    /// Returns the conditions that hold in a state, in order.
    #[inline]
    pub fn held<'a>(&'a self, state: &'a Words<W>) -> HeldConditions<'a, W> {
        self.held_among(state, &self.all)
    }

    /// Returns the conditions of a set that hold in a state, in order.
    #[inline]
    pub fn held_among<'a>(&'a self, state: &'a Words<W>, set: &'a [u64]) -> HeldConditions<'a, W> {
        HeldConditions {
            index: self,
            state,
            set,
            word: 0,
            permitted: self.permitted(state, set, 0),
        }
    }

    /// Returns a word of the conditions of a set that the windows permit.
    #[inline]
    fn permitted(&self, state: &Words<W>, set: &[u64], word: usize) -> u64 {
        let mut permitted = set.get(word).copied().unwrap_or(0);
        if permitted == 0 {
            return 0;
        }
        for (window, start) in &self.windows {
            let place = start + window.code(state) * self.words + word;
            permitted &= self.sets.get(place).copied().unwrap_or(0);
        }
        permitted
    }
}

/// The conditions that hold in a state.
pub(crate) struct HeldConditions<'a, const W: usize> {
    index: &'a ConditionIndex<W>,
    state: &'a Words<W>,
    set: &'a [u64],
    /// The word of the set that is visited, and those of its conditions that have not been.
    word: usize,
    permitted: u64,
}

impl<const W: usize> Iterator for HeldConditions<'_, W> {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        loop {
            while self.permitted == 0 {
                self.word += 1;
                if self.word >= self.index.words {
                    return None;
                }
                self.permitted = self.index.permitted(self.state, self.set, self.word);
            }
            let bit = self.permitted & self.permitted.wrapping_neg();
            self.permitted ^= bit;
            let number = self.word * 64 + bit.trailing_zeros() as usize;
            let undecided = self.index.undecided.get(self.word).copied().unwrap_or(0);
            if undecided & bit == 0 || self.index.conditions.get(number)?.holds(self.state) {
                return Some(number);
            }
        }
    }
}

/// Returns windows that together contain the fields of up to [`MAX_BITS`] that conditions read.
fn windows<const W: usize>(
    layout: &WordLayout,
    words: usize,
    reads: &[Words<W>],
) -> Vec<FieldWindow> {
    let all = reads.iter().fold([0; W], |all, reads| union(&all, reads));
    let read = |field: &&Field| field.bits() <= MAX_BITS && overlaps(&all, &field.bits_in());
    let mut fields: Vec<&Field> = layout.fields.iter().filter(read).collect();
    fields.sort_by_key(|field| (field.word, field.shift));
    let mut windows: Vec<FieldWindow> = Vec::new();
    for field in fields {
        let own = FieldWindow::of(field);
        let joined = windows.last().and_then(|last| last.up_to(own));
        let joined =
            joined.filter(|it| it.bits <= MAX_BITS && it.codes() * words <= MAX_WINDOW_WORDS);
        match (windows.last_mut(), joined) {
            (Some(last), Some(joined)) => *last = joined,
            _ => windows.push(own),
        }
    }
    windows
}

/// Returns the set of the conditions that have a property.
fn set_of<const W: usize>(
    conditions: &[WordCondition<W>],
    is_in: impl Fn(&WordCondition<W>) -> bool,
) -> Vec<u64> {
    let mut set = vec![0; conditions.len().div_ceil(64)];
    for (number, condition) in conditions.iter().enumerate() {
        if let Some(word) = set.get_mut(number / 64) {
            *word |= u64::from(is_in(condition)) << (number % 64);
        }
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grounded::case::{Conjunction, Division, Literal, Requirement};
    use asmotion_ground::GroundTerm;

    struct Random(u64);

    impl Random {
        fn below(&mut self, count: u64) -> u64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (self.0 >> 33) % count
        }
    }

    /// Fields of one to ten bits in two words.
    fn layout() -> WordLayout {
        let mut fields = Vec::new();
        let (mut word, mut shift) = (0, 0);
        for bits in [1, 2, 10, 3, 1, 8, 6, 9, 4, 7, 5, 10, 2, 1, 3, 8] {
            if shift + bits > 64 {
                (word, shift) = (word + 1, 0);
            }
            fields.push(Field {
                word,
                shift,
                mask: (1 << bits) - 1,
                low: 0,
                count: (1 << bits) - 1,
                may_be_undef: bits % 2 == 0,
            });
            shift += bits;
        }
        let words = word + 1;
        WordLayout { fields, words }
    }

    fn random_condition(layout: &WordLayout, random: &mut Random) -> WordCondition<2> {
        let mut when = Conjunction::default();
        for _ in 0..random.below(4) {
            let variable = random.below(layout.fields.len() as u64) as u32;
            let codes = layout.fields[variable as usize].codes();
            let possible = if random.below(2) == 0 {
                let only = random.below(codes);
                (0..codes).map(|code| code == only).collect()
            } else {
                (0..codes).map(|_| random.below(4) > 0).collect()
            };
            when.codes.insert(variable, possible);
        }
        let narrow = [0, 1, 3, 4, 8, 12, 13, 14];
        for _ in 0..random.below(3) {
            let mut pair = [0; 2].map(|_| narrow[random.below(8) as usize]);
            pair.sort_unstable();
            let [left, right] = pair.map(|it| Box::new(GroundTerm::Variable(it)));
            when.literals.push(Literal {
                variables: if pair[0] == pair[1] {
                    vec![pair[0]]
                } else {
                    pair.to_vec()
                },
                term: GroundTerm::Equal(left, right),
                requirement: [Requirement::True, Requirement::False][random.below(2) as usize],
            });
        }
        WordCondition::of(&Division { layout }, &when)
    }

    #[test]
    fn it_returns_the_conditions_that_hold() {
        let (layout, mut random) = (layout(), Random(7));
        assert_eq!(layout.words, 2);
        let mut held = 0;
        for count in [0, 1, 2, 63, 64, 65, 400, 5000] {
            let conditions = (0..count).map(|_| random_condition(&layout, &mut random));
            let conditions: Vec<WordCondition<2>> = conditions.collect();
            let index = ConditionIndex::of(&layout, conditions.clone());
            for _ in 0..300 {
                let mut state = [0; 2];
                for field in &layout.fields {
                    field.set(&mut state, random.below(field.codes()));
                }
                let expected: Vec<usize> = (0..count)
                    .filter(|number| conditions[*number].holds(&state))
                    .collect();
                held += expected.len();
                assert_eq!(index.holds(&state), !expected.is_empty());
                assert_eq!(index.held(&state).collect::<Vec<_>>(), expected);
                let set: Vec<u64> = index
                    .all()
                    .iter()
                    .map(|all| all & 0x5555_5555_5555_5555)
                    .collect();
                let even: Vec<usize> = expected.into_iter().filter(|it| it % 2 == 0).collect();
                assert_eq!(index.held_among(&state, &set).collect::<Vec<_>>(), even);
            }
        }
        // neither none nor all
        assert!((10_000..1_000_000).contains(&held), "{held}");
    }
}
