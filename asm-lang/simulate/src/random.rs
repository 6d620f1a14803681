//! Random inputs and choices, determined by a seed.

use asmotion_ir::{FunctionId, ValueShape};
use asmotion_machine::{Chooser, Environment, Machine};
use asmotion_value::Value;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Chooses among the candidates with uniform probability.
///
/// The serialised form consists of the seed and the position in the sequence; once deserialised, it
/// continues with the choices that would have followed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Seeded {
    random: ChaCha8Rng,
}

impl Seeded {
    /// Creates the sequence of choices for a seed.
    pub fn new(seed: u64) -> Self {
        // separate streams for inputs and choices, so that drawing from one does not shift the
        // other
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(1);
        Self { random }
    }
}

impl Chooser for Seeded {
    fn choose(&mut self, count: usize) -> usize {
        self.random.random_range(0..count.max(1))
    }
}

/// Generates random inputs: truth values and elements of domains with uniform probability, numbers
/// from −100 to 100, sequences and sets of up to three elements.
#[derive(Clone, Debug)]
pub struct Random {
    random: ChaCha8Rng,
    program: Arc<asmotion_ir::Program>,
    /// Elements of each domain in the machine's initial state.
    extents: Vec<Vec<Value>>,
}

const NUMBERS: std::ops::RangeInclusive<i64> = -100..=100;
const NUMBER_COUNT: u64 = 201;
const NATURAL_COUNT: u64 = 101;
const LETTERS: &[u8] = b"abcdefghijklmnopqrstuvwxyz";
const WORDS: &[&str] = &["", "a", "b", "alpha", "beta"];

/// The number of values that can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CandidateCount {
    /// All of them can be listed.
    Finite(u64),
    /// More than can be listed.
    Many,
}

impl Random {
    /// Creates the sequence of inputs for a seed and a machine.
    pub fn new(program: Arc<asmotion_ir::Program>, machine: &Machine, seed: u64) -> Self {
        let extent = |index: usize| {
            let domain = asmotion_ir::DomainId(index as u32);
            match program.domains[index].elements {
                // sampled by their bounds, without listing them
                asmotion_ir::DomainElements::Ints { .. } => Vec::new(),
                asmotion_ir::DomainElements::Atoms { .. }
                | asmotion_ir::DomainElements::Computed(_)
                | asmotion_ir::DomainElements::Undefined
                | asmotion_ir::DomainElements::Open => machine.state().extent(domain).to_vec(),
            }
        };
        let extents = (0..program.domains.len()).map(extent).collect();
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            program,
            extents,
        }
    }

    /// Returns whether the values of an input are random; the time and messages are not.
    pub(crate) fn is_drawn(&self, function: FunctionId) -> bool {
        let declared = &self.program.functions[function.0 as usize];
        declared.clock.is_none() && declared.mail.is_none()
    }

    /// Returns a number less than `count`, or 0.
    pub(crate) fn below(&mut self, count: u64) -> u64 {
        self.random.random_range(0..count.max(1))
    }

    /// Returns the number of values that [`Random::value`] draws for a shape.
    pub(crate) fn candidates(&self, shape: &ValueShape) -> CandidateCount {
        let count = match shape {
            ValueShape::Bool => 2,
            ValueShape::Int | ValueShape::Real => NUMBER_COUNT,
            ValueShape::Natural => NATURAL_COUNT,
            ValueShape::Char => LETTERS.len() as u64,
            ValueShape::Text => WORDS.len() as u64,
            ValueShape::Domain(domain) => {
                let index = domain.0 as usize;
                if let asmotion_ir::DomainElements::Ints { low, high } =
                    self.program.domains[index].elements
                {
                    high.abs_diff(low).saturating_add(1)
                } else {
                    (self.extents[index].len() as u64).max(1)
                }
            }
            ValueShape::Tuple(items) => {
                let product = items.iter().try_fold(1_u64, |product, item| {
                    let CandidateCount::Finite(count) = self.candidates(item) else {
                        return None;
                    };
                    product.checked_mul(count)
                });
                return product.map_or(CandidateCount::Many, CandidateCount::Finite);
            }
            ValueShape::Seq(_) | ValueShape::Set(_) | ValueShape::Bag(_) | ValueShape::Map(..) => {
                return CandidateCount::Many;
            }
            ValueShape::Complex | ValueShape::Rule | ValueShape::Any => 1,
        };
        CandidateCount::Finite(count)
    }

    /// Returns one of the [`Random::candidates`] by its index.
    pub(crate) fn candidate(&self, shape: &ValueShape, index: u64) -> Value {
        let number = |low: i64| low.saturating_add_unsigned(index);
        match shape {
            ValueShape::Bool => Value::Bool(index == 1),
            ValueShape::Int => Value::Int(number(*NUMBERS.start())),
            ValueShape::Natural => Value::Int(number(0)),
            ValueShape::Real => Value::real(number(*NUMBERS.start()) as f64 / 4.0),
            ValueShape::Char => Value::Char(char::from(LETTERS[index as usize])),
            ValueShape::Text => Value::text(WORDS[index as usize]),
            ValueShape::Domain(domain) => {
                let domain = domain.0 as usize;
                if let asmotion_ir::DomainElements::Ints { low, .. } =
                    self.program.domains[domain].elements
                {
                    return Value::Int(number(low));
                }
                let element = self.extents[domain].get(index as usize);
                element.cloned().unwrap_or_default()
            }
            ValueShape::Tuple(items) => {
                let mut index = index;
                let items = items.iter().map(|item| {
                    let CandidateCount::Finite(count) = self.candidates(item) else {
                        return Value::Undef;
                    };
                    let value = self.candidate(item, index % count);
                    index /= count;
                    value
                });
                Value::tuple(items.collect::<Vec<_>>())
            }
            ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..)
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Any => Value::Undef,
        }
    }

    pub(crate) fn value(&mut self, shape: &ValueShape) -> Value {
        match shape {
            ValueShape::Bool => Value::Bool(self.random.random_bool(0.5)),
            ValueShape::Int => Value::Int(self.random.random_range(NUMBERS)),
            ValueShape::Natural => Value::Int(self.random.random_range(0..=*NUMBERS.end())),
            ValueShape::Real => Value::real(self.random.random_range(NUMBERS) as f64 / 4.0),
            ValueShape::Char => Value::Char(char::from(self.random.random_range(b'a'..=b'z'))),
            ValueShape::Text => Value::text(WORDS[self.random.random_range(0..WORDS.len())]),
            ValueShape::Domain(domain) => self.element(*domain),
            ValueShape::Tuple(items) => {
                let items: Vec<Value> = items.iter().map(|item| self.value(item)).collect();
                Value::tuple(items)
            }
            ValueShape::Seq(item) => Value::seq(self.random_values(item)),
            ValueShape::Set(item) => Value::set(self.random_values(item)),
            ValueShape::Bag(item) => Value::bag(self.random_values(item)),
            ValueShape::Map(key, value) => {
                let keys = self.random_values(key);
                let pairs: Vec<(Value, Value)> = keys
                    .into_iter()
                    .map(|key| (key, self.value(value)))
                    .collect();
                Value::map(pairs)
            }
            ValueShape::Complex | ValueShape::Rule | ValueShape::Any => Value::Undef,
        }
    }

    fn element(&mut self, domain: asmotion_ir::DomainId) -> Value {
        if let asmotion_ir::DomainElements::Ints { low, high } =
            self.program.domains[domain.0 as usize].elements
        {
            return Value::Int(self.random.random_range(low..=high));
        }
        let elements = &self.extents[domain.0 as usize];
        if elements.is_empty() {
            return Value::Undef;
        }
        elements[self.random.random_range(0..elements.len())].clone()
    }

    fn random_values(&mut self, item: &ValueShape) -> Vec<Value> {
        let count = self.random.random_range(0..=3);
        (0..count).map(|_| self.value(item)).collect()
    }
}

impl Environment for Random {
    fn read(
        &mut self,
        function: FunctionId,
        _arguments: &[Value],
    ) -> Result<Option<Value>, String> {
        let program = self.program.clone();
        let declared = &program.functions[function.0 as usize];
        Ok(self
            .is_drawn(function)
            .then(|| self.value(&declared.codomain)))
    }
}
