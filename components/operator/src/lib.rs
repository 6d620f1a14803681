//! The scripted operator: sends goals, cancels and e-stops at the times in its script.

mod operator;
mod script;

pub use operator::ScriptedOperator;
pub use script::{OperatorCommand, ScheduledCommand, ScriptError};
