//! Inputs that keep their values.

use asmotion_ir::FunctionId;
use asmotion_machine::Environment;
use asmotion_value::Value;
use std::collections::BTreeMap;

/// Inputs that hold what they were given last; before that they are undef, and clocks tell the time.
#[derive(Clone, Debug, Default)]
pub struct HeldInputs {
    values: BTreeMap<(FunctionId, Vec<Value>), Value>,
}

impl HeldInputs {
    /// Nothing was given yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Gives an input its value.
    pub fn set(&mut self, function: FunctionId, arguments: &[Value], value: Value) {
        self.values.insert((function, arguments.to_vec()), value);
    }
}

impl Environment for HeldInputs {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        Ok(self.values.get(&(function, arguments.to_vec())).cloned())
    }
}
