//! The possible values of inputs: monitored and shared functions.

use asmotion_lang::ir::{FunctionId, FunctionKind};
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
            if is_free && let Some(values) = machine.elements(&function.codomain, MAX_VALUES) {
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
