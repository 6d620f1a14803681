//! Who answers for what the environment owns.

use asmotion_ir::FunctionId;
use asmotion_value::Value;

/// Gives monitored and shared functions their values. Within a step, every location is asked for at
/// most once, when a rule first reads it; the answer holds for the whole step.
pub trait Environment {
    /// The value of a location. `None` leaves a location as it is that is shared or has an initial
    /// value; a clock then tells the time of the step, and any other monitored location is undef.
    ///
    /// # Errors
    /// There is no answer to be had; the text says why. The step then fails.
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String>;

    /// Who gives a location its value, as a message says it of a value that is none of the location's.
    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        "the environment".to_owned()
    }
}

/// An environment that has nothing to say.
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
