//! Inputs that keep their values until they are set again.

use asmotion_ir::FunctionId;
use asmotion_machine::Environment;
use asmotion_value::Value;
use std::collections::BTreeMap;

/// Inputs that keep the value set last. Before that they are undef, and clocks return the time of
/// the step.
#[derive(Clone, Debug, Default)]
pub struct HeldInputs {
    values: BTreeMap<(FunctionId, Vec<Value>), Value>,
}

impl HeldInputs {
    /// Creates inputs without values.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the value of an input location.
    pub fn set(&mut self, function: FunctionId, arguments: &[Value], value: Value) {
        self.values.insert((function, arguments.to_vec()), value);
    }
}

impl Environment for HeldInputs {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        Ok(self.values.get(&(function, arguments.to_vec())).cloned())
    }
}
