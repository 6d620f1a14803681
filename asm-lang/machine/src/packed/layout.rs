//! Layout of packed states: the encoding of each slot of a program.

use asmotion_ir::{
    DomainElements, DomainId, Function, FunctionKind, Initial, Program, Slot, Storage, ValueShape,
};
use asmotion_value::{Atom, Value};

/// The escape code for a value that is encoded in bytes. 0 encodes undef; the other codes are the
/// values in ascending order.
pub(super) const ELSE: u64 = 1;

/// Number of codes that do not stand for a value.
const RESERVED: u64 = 2;

/// The encoding of a program's states, computed once for each program.
#[derive(Debug)]
pub(crate) struct Layout {
    /// The functions with eager slots, except those that the environment is asked for in each step.
    pub fields: Vec<Field>,
    /// Total number of bits of the fields that are encoded in bits.
    pub bits: usize,
    /// `true` for functions whose locations keep no value between steps, because the environment is
    /// asked for it in each; indexed by function.
    pub is_reread: Vec<bool>,
    /// Eager slots of these functions.
    pub reread: Vec<Slot>,
    /// Domains whose elements depend on the inputs of the first step.
    pub message_domains: Vec<DomainId>,
    /// `true` if the initial value of a location that is accessed later depends on the inputs of
    /// the first step. The initial state is then part of each packed state.
    pub recalls: bool,
    /// `true` if a location keeps the value that the environment provided, until it provides another.
    pub keeps_inputs: bool,
    /// `true` if the first step behaves differently from later ones.
    pub first_differs: bool,
}

/// The slots of one function.
#[derive(Debug)]
pub(crate) struct Field {
    base: Slot,
    count: u32,
    /// Index of the first bit.
    bit: usize,
    pub coding: Coding,
}

/// The encoding of a value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Coding {
    /// A code of this width for one of these values, or else the escape code.
    Bits { width: u32, values: Values },
    /// A sequence of bytes.
    Bytes,
}

/// A set of values that have codes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Values {
    Bools,
    Atoms { first: u32, count: u32 },
    Ints { low: i64, count: u64 },
}

impl Field {
    pub fn slots(&self) -> std::ops::Range<Slot> {
        self.base..self.base + self.count
    }

    /// Returns the index of the first bit of a slot.
    pub fn at(&self, index: usize) -> usize {
        self.bit + index * self.coding.width() as usize
    }
}

impl Coding {
    fn of(program: &Program, codomain: &ValueShape) -> Self {
        let values = match codomain {
            ValueShape::Bool => Values::Bools,
            ValueShape::Domain(domain) => match program.domains[domain.0 as usize].elements {
                DomainElements::Atoms { first, count } => Values::Atoms {
                    first: first.0,
                    count,
                },
                DomainElements::Ints { low, high } if low <= high => {
                    match high.abs_diff(low).checked_add(1) {
                        Some(count) if count <= 1 << 32 => Values::Ints { low, count },
                        Some(_) | None => return Self::Bytes,
                    }
                }
                DomainElements::Ints { .. }
                | DomainElements::Computed(_)
                | DomainElements::Undefined
                | DomainElements::Open => return Self::Bytes,
            },
            ValueShape::Int
            | ValueShape::Natural
            | ValueShape::Real
            | ValueShape::Char
            | ValueShape::Text
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Tuple(_)
            | ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..)
            | ValueShape::Any => return Self::Bytes,
        };
        let greatest = values.count() + RESERVED - 1;
        Self::Bits {
            width: u64::BITS - greatest.leading_zeros(),
            values,
        }
    }

    /// Returns the number of bits of a value, 0 for an encoding in bytes.
    pub fn width(self) -> u32 {
        match self {
            Self::Bits { width, .. } => width,
            Self::Bytes => 0,
        }
    }

    pub fn code(self, value: &Value) -> u64 {
        if value.is_undef() {
            return 0;
        }
        let Self::Bits { values, .. } = self else {
            return ELSE;
        };
        values.index(value).map_or(ELSE, |index| index + RESERVED)
    }

    /// Returns the value for a code other than [`ELSE`].
    pub fn value(self, code: u64) -> Option<Value> {
        let Self::Bits { values, .. } = self else {
            return None;
        };
        match code {
            0 => Some(Value::Undef),
            code => values.value(code.checked_sub(RESERVED)?),
        }
    }
}

impl Values {
    fn count(self) -> u64 {
        match self {
            Self::Bools => 2,
            Self::Atoms { count, .. } => u64::from(count),
            Self::Ints { count, .. } => count,
        }
    }

    fn index(self, value: &Value) -> Option<u64> {
        let index = match (self, value) {
            (Self::Bools, Value::Bool(truth)) => u64::from(*truth),
            (Self::Atoms { first, .. }, Value::Atom(atom)) => u64::from(atom.0.checked_sub(first)?),
            (Self::Ints { low, .. }, Value::Int(number)) if *number >= low => number.abs_diff(low),
            (Self::Bools | Self::Atoms { .. } | Self::Ints { .. }, _) => return None,
        };
        (index < self.count()).then_some(index)
    }

    fn value(self, index: u64) -> Option<Value> {
        if index >= self.count() {
            return None;
        }
        Some(match self {
            Self::Bools => Value::Bool(index == 1),
            Self::Atoms { first, .. } => Value::Atom(Atom(first + u32::try_from(index).ok()?)),
            Self::Ints { low, .. } => Value::Int(low.checked_add_unsigned(index)?),
        })
    }
}

impl Layout {
    pub fn of(program: &Program) -> Self {
        let is_reread: Vec<bool> = program.functions.iter().map(is_reread).collect();
        let mut fields = Vec::new();
        let mut reread = Vec::new();
        let mut bits = 0;
        for id in &program.dense {
            let function = &program.functions[id.0 as usize];
            let Storage::Dense {
                base,
                count,
                lazy: false,
                ..
            } = function.storage
            else {
                continue;
            };
            if is_reread[id.0 as usize] {
                reread.extend(base..base + count);
                continue;
            }
            let coding = Coding::of(program, &function.codomain);
            fields.push(Field {
                base,
                count,
                bit: bits,
                coding,
            });
            bits += coding.width() as usize * count as usize;
        }
        let inputs = program.initial_inputs.iter();
        let heard_domains = inputs.filter_map(|initial| match initial {
            Initial::Domain(domain) => Some(*domain),
            Initial::Function(_) => None,
        });
        let mut inputs = program.initial_inputs.iter();
        let recalls = inputs.any(|initial| match initial {
            Initial::Function(_) => true,
            Initial::Domain(_) => false,
        });
        let mut functions = program.functions.iter();
        let hears_late = functions.any(|function| function.initial.is_some() && is_input(function));
        let mut functions = program.functions.iter().zip(&is_reread);
        let keeps_inputs = functions.any(|(function, is_reread)| is_input(function) && !is_reread);
        let waits = program.invariants.iter().any(|invariant| invariant.waits);
        Self {
            fields,
            bits,
            reread,
            message_domains: heard_domains.collect(),
            recalls: recalls && !program.compatible,
            keeps_inputs,
            first_differs: !program.initial_inputs.is_empty() || waits || hears_late,
            is_reread,
        }
    }
}

fn is_input(function: &Function) -> bool {
    match function.kind {
        FunctionKind::Monitored | FunctionKind::Shared => true,
        FunctionKind::Controlled
        | FunctionKind::Out
        | FunctionKind::Local
        | FunctionKind::Fixed => false,
    }
}

/// Returns `true` if a location does not keep its value when the environment provides none; mirrors
/// `StepContext::input`.
fn is_reread(function: &Function) -> bool {
    let has_none = function.kind == FunctionKind::Monitored && function.initial.is_none();
    is_input(function) && (has_none || function.clock.is_some() || function.mail.is_some())
}
