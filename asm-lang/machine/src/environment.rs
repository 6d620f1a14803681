//! The environment of a machine: the source of monitored and shared values.

use asmotion_ir::FunctionId;
use asmotion_value::Value;

/// Provides the values of monitored and shared functions. Within a step, each location is read at
/// most once, when a rule first needs it, and the value holds for the whole step.
pub trait Environment {
    /// Returns the value of a location. `None` means that the environment has none: a location that
    /// is shared or has an initial value then keeps its value, a clock returns the time of the
    /// step, and any other monitored location is undef.
    ///
    /// # Errors
    /// The value is not available, for the reason in the error text. The step then fails.
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String>;

    /// Names the source of a location's value, for the message about a value outside the codomain.
    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        "the environment".to_owned()
    }
}

/// An environment that provides no values.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoInputs;

impl Environment for NoInputs {
    fn read(
        &mut self,
        _function: FunctionId,
        _arguments: &[Value],
    ) -> Result<Option<Value>, String> {
        Ok(None)
    }
}
