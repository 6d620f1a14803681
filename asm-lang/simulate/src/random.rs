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
const WORDS: &[&str] = &["", "a", "b", "alpha", "beta"];

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

    fn value(&mut self, shape: &ValueShape) -> Value {
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
        // the time and messages are not random
        let is_known = declared.clock.is_some() || declared.mail.is_some();
        Ok((!is_known).then(|| self.value(&declared.codomain)))
    }
}
