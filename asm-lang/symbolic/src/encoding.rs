//! Boolean variables for locations and inputs: each has finitely many values, and a value is a number in binary.

use crate::bdd::{Bdd, BddStore, BitIndex};
use crate::error::SymbolicError;
use asmotion_lang::Value;
use asmotion_lang::ir::{FunctionId, Slot};
use std::collections::BTreeMap;

/// The variables of one of several values.
#[derive(Clone)]
pub(crate) struct Code {
    pub bits: Vec<BitIndex>,
    /// Condition for each value.
    pub values: Vec<Bdd>,
}

impl Code {
    /// Returns the conditions of this number of values on variables, the first of which is the most significant.
    pub fn of(store: &BddStore, bits: Vec<BitIndex>, count: usize) -> Result<Self, SymbolicError> {
        let mut values = Vec::with_capacity(count);
        for value in 0..count {
            let mut guard = store.always();
            for (place, bit) in bits.iter().rev().enumerate() {
                guard = store.and(&guard, &store.bit(*bit, value >> place & 1 == 1)?)?;
            }
            values.push(guard);
        }
        Ok(Self { bits, values })
    }

    /// Adds variables for this number of values.
    pub fn add(store: &BddStore, count: usize) -> Result<Self, SymbolicError> {
        let first = store.add_bits(width(count))?;
        let bits = (first..).take(width(count) as usize).collect();
        Self::of(store, bits, count)
    }

    /// Returns the assignment for a value.
    pub fn assignment(&self, value: usize, to: &mut Vec<(BitIndex, bool)>) {
        let places = self.bits.iter().rev().enumerate();
        to.extend(places.map(|(place, bit)| (*bit, value >> place & 1 == 1)));
    }

    /// Returns the condition of the first value.
    pub fn first(&self, store: &BddStore) -> Bdd {
        self.values
            .first()
            .cloned()
            .unwrap_or_else(|| store.always())
    }
}

/// Returns the number of bits for this number of values.
fn width(count: usize) -> u32 {
    match count {
        0 | 1 => 0,
        _ => (count - 1).ilog2() + 1,
    }
}

/// The variables of a location in the current and in the next state.
pub(crate) struct SlotCode {
    pub values: Vec<Value>,
    pub now: Code,
    pub then: Code,
    /// The value remains the same.
    pub same: Bdd,
}

impl SlotCode {
    /// Adds variables; those of the current and the next state alternate.
    pub fn add(store: &BddStore, values: Vec<Value>) -> Result<Self, SymbolicError> {
        let width = width(values.len());
        let first = store.add_bits(2 * width)?;
        let bits = |offset: u32| (0..width).map(|place| first + 2 * place + offset).collect();
        let now = Code::of(store, bits(0), values.len())?;
        let then = Code::of(store, bits(1), values.len())?;
        let mut same = store.always();
        for (before, after) in now.bits.iter().zip(&then.bits).rev() {
            let equal = store.same(&store.bit(*before, true)?, &store.bit(*after, true)?)?;
            same = store.and(&same, &equal)?;
        }
        Ok(Self {
            values,
            now,
            then,
            same,
        })
    }

    /// Returns the index of a value.
    pub fn index(&self, value: &Value) -> Option<usize> {
        self.values.iter().position(|known| known == value)
    }

    /// Returns the condition that the next value is this one; `None` if the location cannot have it.
    pub fn becomes(&self, value: &Value) -> Option<&Bdd> {
        self.then.values.get(self.index(value)?)
    }

    /// Returns the condition that the current value is this one; `None` if the location cannot have it.
    pub fn is(&self, value: &Value) -> Option<&Bdd> {
        self.now.values.get(self.index(value)?)
    }
}

/// An input location.
pub(crate) struct InputCode {
    pub values: Vec<Value>,
    /// The value in a state that is considered with its inputs; one more code stands for an input that no condition reads.
    pub known: Option<Code>,
    /// The value in a step.
    pub free: Option<Code>,
}

impl InputCode {
    /// Returns the same input with new variables.
    pub fn coded_again(&self, store: &BddStore) -> Result<Self, SymbolicError> {
        let add = |code: &Option<Code>| {
            let count = code.as_ref().map(|it| it.values.len());
            count.map(|count| Code::add(store, count)).transpose()
        };
        Ok(Self {
            values: self.values.clone(),
            known: add(&self.known)?,
            free: add(&self.free)?,
        })
    }
}

/// The inputs that steps and conditions read.
#[derive(Default)]
pub(crate) struct Inputs {
    pub all: Vec<InputCode>,
    /// An input with arguments has got variables after those of all locations.
    pub is_late: bool,
    numbers: BTreeMap<(FunctionId, Vec<Value>), usize>,
}

impl Inputs {
    /// Returns the number of an input.
    pub fn number(
        &mut self,
        function: FunctionId,
        arguments: &[Value],
        values: impl FnOnce() -> Option<Vec<Value>>,
    ) -> Option<usize> {
        let key = (function, arguments.to_vec());
        if let Some(number) = self.numbers.get(&key) {
            return Some(*number);
        }
        let number = self.all.len();
        self.all.push(InputCode {
            values: values()?,
            known: None,
            free: None,
        });
        self.numbers.insert(key, number);
        Some(number)
    }

    /// Adds an input that is not known.
    pub fn add(&mut self, function: FunctionId, arguments: Vec<Value>, input: InputCode) {
        self.numbers.insert((function, arguments), self.all.len());
        self.all.push(input);
    }

    /// Returns the inputs with their locations, in ascending order.
    pub fn named(&self) -> impl Iterator<Item = (&(FunctionId, Vec<Value>), &InputCode)> {
        let numbers = self.numbers.iter();
        numbers.filter_map(|(location, number)| Some((location, self.all.get(*number)?)))
    }

    /// Returns the number of an input that is known.
    pub fn find(&self, function: FunctionId, arguments: &[Value]) -> Option<usize> {
        let key = (function, arguments.to_vec());
        self.numbers.get(&key).copied()
    }
}

/// The locations that steps change.
pub(crate) type Slots = BTreeMap<Slot, SlotCode>;
