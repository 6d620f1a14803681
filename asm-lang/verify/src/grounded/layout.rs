//! The layout of states in words: each variable has a field of bits that contains its code.

use asmotion_ground::{FAULT, GroundProgram, StateVariable, UNDEF};

/// Greatest number of words of a state.
pub(crate) const MAX_WORDS: usize = 8;

/// A state, with one word for each 64 bits of its variables.
pub(crate) type Words<const W: usize> = [u64; W];

/// Returns a word of a state. Where several states are visited together, it costs less than a `zip`, whose code may be in another unit of
/// code generation than that of the loop.
#[inline]
pub(crate) fn word_of<const W: usize>(words: &Words<W>, index: usize) -> u64 {
    words.get(index).copied().unwrap_or(0)
}

/// Returns the bits of either.
pub(crate) fn union<const W: usize>(one: &Words<W>, other: &Words<W>) -> Words<W> {
    std::array::from_fn(|index| word_of(one, index) | word_of(other, index))
}

/// Returns `true` if there are bits of both.
pub(crate) fn overlaps<const W: usize>(one: &Words<W>, other: &Words<W>) -> bool {
    (0..W).any(|index| word_of(one, index) & word_of(other, index) != 0)
}

/// Returns `true` if all bits are among others.
pub(crate) fn is_within<const W: usize>(bits: &Words<W>, others: &Words<W>) -> bool {
    (0..W).all(|index| word_of(bits, index) & !word_of(others, index) == 0)
}

/// The place of a variable in the words, and the coding of its numbers: the distance from the least one, or a code for undef.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub word: usize,
    pub shift: u32,
    /// Mask of the code before it is shifted.
    pub mask: u64,
    pub low: i64,
    /// Number of codes of numbers; undef has the next code.
    pub count: u64,
    pub may_be_undef: bool,
}

impl Field {
    /// Returns the code of a number; `None` if it has none.
    #[inline]
    pub fn code(&self, number: i64) -> Option<u64> {
        if number == UNDEF {
            return self.may_be_undef.then_some(self.count);
        }
        let code = number.checked_sub(self.low)?;
        u64::try_from(code).ok().filter(|code| *code < self.count)
    }

    /// Returns the number that a code stands for.
    #[inline]
    pub fn number(&self, code: u64) -> i64 {
        if code >= self.count {
            UNDEF
        } else {
            self.low.wrapping_add(code as i64)
        }
    }

    /// Returns the code of the variable in a state.
    #[inline]
    pub fn get<const W: usize>(&self, state: &Words<W>) -> u64 {
        state.get(self.word).copied().unwrap_or(0) >> self.shift & self.mask
    }

    /// Replaces the code of the variable in a state.
    #[inline]
    pub fn set<const W: usize>(&self, state: &mut Words<W>, code: u64) {
        if let Some(word) = state.get_mut(self.word) {
            *word = *word & !(self.mask << self.shift) | code << self.shift;
        }
    }

    /// Returns its bits in a state.
    pub fn bits_in<const W: usize>(&self) -> Words<W> {
        let mut bits = [0; W];
        self.set(&mut bits, self.mask);
        bits
    }

    /// Number of codes that a state can contain.
    pub fn codes(&self) -> u64 {
        self.count + u64::from(self.may_be_undef)
    }

    /// Number of bits.
    pub fn bits(&self) -> u32 {
        self.mask.count_ones()
    }
}

/// The fields of all variables.
#[derive(Clone, Debug)]
pub(crate) struct WordLayout {
    pub fields: Vec<Field>,
    /// Number of words.
    pub words: usize,
}

impl WordLayout {
    /// Lays out the variables. `None` if a state has too many words.
    pub fn of(program: &GroundProgram) -> Option<Self> {
        let mut used: Vec<u32> = Vec::new();
        let mut fields = Vec::new();
        for variable in &program.variables {
            let (low, high) = variable.range;
            let count = high.abs_diff(low).checked_add(1)?;
            let codes = count.checked_add(u64::from(variable.may_be_undef))?;
            let bits = (64 - (codes - 1).leading_zeros()).max(1);
            if bits >= 63 {
                return None;
            }
            let known = used.iter().position(|used| used + bits <= 64);
            let word = known.unwrap_or(used.len());
            if known.is_none() {
                used.push(0);
            }
            let shift = used.get(word).copied()?;
            if let Some(used) = used.get_mut(word) {
                *used += bits;
            }
            fields.push(Field {
                word,
                shift,
                mask: (1 << bits) - 1,
                low,
                count,
                may_be_undef: variable.may_be_undef,
            });
        }
        let words = used.len().max(1);
        (words <= MAX_WORDS).then_some(Self { fields, words })
    }

    pub fn field(&self, variable: u32) -> Option<&Field> {
        self.fields.get(variable as usize)
    }

    /// Writes the numbers of a state.
    pub fn decode<const W: usize>(&self, state: &Words<W>, numbers: &mut Vec<i64>) {
        numbers.clear();
        let fields = self.fields.iter();
        numbers.extend(fields.map(|field| field.number(field.get(state))));
    }

    /// Returns the words of a state, or the first variable whose number has no code.
    pub fn encode<const W: usize>(&self, numbers: &[i64]) -> Result<Words<W>, u32> {
        let mut state = [0; W];
        for ((field, number), variable) in self.fields.iter().zip(numbers).zip(0u32..) {
            let code = field.code(*number).ok_or(variable)?;
            field.set(&mut state, code);
        }
        Ok(state)
    }
}

/// Widens the range of a variable so that it contains a number, generously, since others may follow. Returns `false` if it cannot
/// have that number.
pub(crate) fn widen(variable: &mut StateVariable, number: i64) -> bool {
    if number == UNDEF {
        variable.may_be_undef = true;
        return true;
    }
    if number == FAULT {
        return false;
    }
    let (low, high) = variable.range;
    let span = high.saturating_sub(low).saturating_add(1);
    variable.range = if number < low {
        (number.min(low.saturating_sub(span)).max(FAULT + 1), high)
    } else {
        (low, number.max(high.saturating_add(span)))
    };
    true
}
