//! The inputs of one step: the values of all bound functions, fixed before the step begins.

use asmotion_lang::Environment;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::value::Value;

/// The inputs of one step.
#[derive(Debug, Default)]
pub(crate) struct InputFrame {
    values: Vec<(FunctionId, Value)>,
}

impl InputFrame {
    pub fn clear(&mut self) {
        self.values.clear();
    }

    pub fn set(&mut self, function: FunctionId, value: Value) {
        self.values.push((function, value));
    }
}

impl Environment for InputFrame {
    /// A function without binding is undef.
    fn read(
        &mut self,
        function: FunctionId,
        _arguments: &[Value],
    ) -> Result<Option<Value>, String> {
        let bound = self.values.iter().find(|(known, _)| *known == function);
        Ok(bound.map(|(_, value)| value.clone()))
    }

    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        "what the composite binds to it".to_owned()
    }
}
