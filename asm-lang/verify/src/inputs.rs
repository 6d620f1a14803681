//! The possible values of inputs: monitored and shared functions.

use asmotion_lang::ir::{DomainElements, FunctionId, FunctionKind, Program, ValueShape};
use asmotion_lang::{Machine, Value};
use std::collections::BTreeMap;

/// Limit for the values of an input.
pub(crate) const MAX_VALUES: usize = 4096;

/// The reason for which an input has no value.
pub(crate) const NOT_ENUMERATED: &str = "its values cannot be enumerated";

/// The possible values of each input.
#[derive(Clone, Debug, Default)]
pub(crate) struct InputRanges {
    values: BTreeMap<FunctionId, Vec<Value>>,
}

impl InputRanges {
    /// Returns the ranges that follow from the codomains. An input whose codomain is infinite or too large has no range.
    pub fn of_program(machine: &Machine) -> Self {
        let program = machine.program();
        let mut ranges = Self::default();
        for (index, function) in program.functions.iter().enumerate() {
            let is_input = match function.kind {
                FunctionKind::Monitored | FunctionKind::Shared => true,
                FunctionKind::Controlled
                | FunctionKind::Out
                | FunctionKind::Local
                | FunctionKind::Fixed => false,
            };
            // the time and the states of messages are no independent inputs
            let is_free = is_input && function.clock.is_none() && function.mail.is_none();
            if is_free && let Some(values) = elements(machine, program, &function.codomain) {
                ranges.values.insert(FunctionId(index as u32), values);
            }
        }
        ranges
    }

    /// Restricts an input to these values, in this order.
    pub fn set(&mut self, function: FunctionId, values: Vec<Value>) {
        self.values.insert(function, values);
    }

    /// Returns the values of an input.
    ///
    /// # Errors
    /// There are infinitely or too many.
    pub fn of(&self, function: FunctionId) -> Result<&[Value], String> {
        let values = self.values.get(&function).map(Vec::as_slice);
        values.ok_or_else(|| NOT_ENUMERATED.to_owned())
    }
}

/// Returns the elements of a shape in ascending order; `None` if there are more than [`MAX_VALUES`].
pub(crate) fn elements(
    machine: &Machine,
    program: &Program,
    shape: &ValueShape,
) -> Option<Vec<Value>> {
    match shape {
        ValueShape::Bool => Some(vec![Value::Bool(false), Value::Bool(true)]),
        ValueShape::Domain(domain) => match program.domains.get(domain.0 as usize)?.elements {
            DomainElements::Ints { .. } => {
                let named = program.named_elements(shape)?;
                Some(named.into_iter().map(|(_, value)| value).collect())
            }
            DomainElements::Atoms { .. } | DomainElements::Computed(_) => {
                let extent = machine.state().extent(*domain);
                (extent.len() <= MAX_VALUES).then(|| extent.to_vec())
            }
            DomainElements::Undefined | DomainElements::Open => None,
        },
        ValueShape::Tuple(items) => {
            let mut all: Vec<Vec<Value>> = vec![Vec::new()];
            for item in items {
                let items = elements(machine, program, item)?;
                if all.len().saturating_mul(items.len()) > MAX_VALUES {
                    return None;
                }
                let extended = all.iter().flat_map(|start| {
                    items.iter().map(|item| {
                        let mut tuple = start.clone();
                        tuple.push(item.clone());
                        tuple
                    })
                });
                all = extended.collect();
            }
            Some(all.into_iter().map(Value::tuple).collect())
        }
        ValueShape::Set(item) => {
            let items = elements(machine, program, item)?;
            let count = 1usize.checked_shl(u32::try_from(items.len()).ok()?)?;
            (items.len() < usize::BITS as usize && count <= MAX_VALUES).then(|| {
                let members = |set: usize| {
                    let items = items.iter().enumerate();
                    items.filter(move |(index, _)| set >> index & 1 == 1)
                };
                let set = |set| Value::set(members(set).map(|(_, item)| item.clone()));
                (0..count).map(set).collect()
            })
        }
        ValueShape::Int
        | ValueShape::Natural
        | ValueShape::Real
        | ValueShape::Char
        | ValueShape::Text
        | ValueShape::Complex
        | ValueShape::Rule
        | ValueShape::Seq(_)
        | ValueShape::Bag(_)
        | ValueShape::Map(..)
        | ValueShape::Any => None,
    }
}
