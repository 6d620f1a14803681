//! Conditions on the words of a state: masks and tables.

use super::case::{Conjunction, Division};
use super::layout::{Field, WordLayout, Words, is_within, union, word_of};

/// A selection of variables as an index into a table.
#[derive(Clone, Debug)]
pub(super) struct Selection(Vec<(Field, usize)>);

impl Selection {
    pub fn of(layout: &WordLayout, variables: &[u32]) -> Self {
        let mut stride = 1usize;
        let mut fields = Vec::new();
        for variable in variables.iter().rev() {
            if let Some(field) = layout.field(*variable) {
                fields.push((field.clone(), stride));
                stride *= field.codes() as usize;
            }
        }
        Self(fields)
    }

    #[inline]
    pub fn index<const W: usize>(&self, state: &Words<W>) -> usize {
        let parts = self.0.iter();
        parts
            .map(|(field, stride)| field.get(state) as usize * stride)
            .sum()
    }
}

/// A condition that no mask expresses.
#[derive(Clone, Debug)]
enum WordTest {
    /// The code of a field is in a set.
    Set(Field, u64),
    /// A table has `true` for the selected codes.
    Table(Selection, Box<[bool]>),
}

impl WordTest {
    #[inline]
    fn holds<const W: usize>(&self, state: &Words<W>) -> bool {
        match self {
            Self::Set(field, set) => set >> field.get(state) & 1 == 1,
            Self::Table(selection, table) => {
                table.get(selection.index(state)).copied().unwrap_or(false)
            }
        }
    }

    /// Returns the bits on which it depends.
    fn reads<const W: usize>(&self) -> Words<W> {
        match self {
            Self::Set(field, _) => field.bits_in(),
            Self::Table(Selection(fields), _) => fields
                .iter()
                .fold([0; W], |bits, (field, _)| union(&bits, &field.bits_in())),
        }
    }
}

/// A conjunction of conditions on the words of a state.
#[derive(Clone, Debug)]
pub(crate) struct WordCondition<const W: usize> {
    mask: Words<W>,
    value: Words<W>,
    tests: Box<[WordTest]>,
}

impl<const W: usize> WordCondition<W> {
    pub fn of(division: &Division<'_>, when: &Conjunction) -> Self {
        let layout = division.layout;
        let (mut mask, mut value) = ([0; W], [0; W]);
        let mut tests = Vec::new();
        for (variable, codes) in &when.codes {
            let Some(field) = layout.field(*variable) else {
                continue;
            };
            let mut possible = codes
                .iter()
                .enumerate()
                .filter(|(_, is_possible)| **is_possible);
            match (possible.next(), possible.next()) {
                (Some((code, _)), None) => {
                    field.set(&mut mask, field.mask);
                    field.set(&mut value, code as u64);
                }
                _ if codes.len() <= 64 => {
                    let set = codes.iter().enumerate();
                    let set = set.fold(0, |set, (code, is)| set | u64::from(*is) << code);
                    tests.push(WordTest::Set(field.clone(), set));
                }
                _ => {
                    let selection = Selection::of(layout, &[*variable]);
                    tests.push(WordTest::Table(selection, codes.clone().into()));
                }
            }
        }
        for literal in &when.literals {
            let values = division.values(&literal.term, &literal.variables);
            let values = values.iter().map(|it| literal.requirement.is_met(*it));
            let selection = Selection::of(layout, &literal.variables);
            tests.push(WordTest::Table(selection, values.collect()));
        }
        Self {
            mask,
            value,
            tests: tests.into(),
        }
    }

    #[inline]
    pub fn holds(&self, state: &Words<W>) -> bool {
        let mut differs = 0;
        for (index, word) in state.iter().enumerate() {
            differs |= word & word_of(&self.mask, index) ^ word_of(&self.value, index);
        }
        differs == 0 && self.tests_hold(state)
    }

    #[inline]
    fn tests_hold(&self, state: &Words<W>) -> bool {
        self.tests.iter().all(|test| test.holds(state))
    }

    /// Returns the bits on which it depends.
    pub fn reads(&self) -> Words<W> {
        let tests = self.tests.iter();
        tests.fold(self.mask, |bits, test| union(&bits, &test.reads()))
    }

    /// Returns `false` if certain bits of a state exclude it, whatever the others are.
    pub fn is_possible(&self, known: &Words<W>, state: &Words<W>) -> bool {
        let differs = |index, word: &u64| {
            let mask = word_of(&self.mask, index) & word_of(known, index);
            (word ^ word_of(&self.value, index)) & mask != 0
        };
        let mut words = state.iter().enumerate();
        let mut tests = self.tests.iter();
        !words.any(|(index, word)| differs(index, word))
            && tests.all(|test| !is_within(&test.reads(), known) || test.holds(state))
    }

    /// Returns `true` if it holds in all states that none of these sets of bits excludes.
    pub fn is_decided_by(&self, sets: &[Words<W>]) -> bool {
        let all = sets.iter().fold([0; W], |all, bits| union(&all, bits));
        let is_decided = |test: &WordTest| sets.iter().any(|bits| is_within(&test.reads(), bits));
        is_within(&self.mask, &all) && self.tests.iter().all(is_decided)
    }
}
