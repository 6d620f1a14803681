//! The operator on schedule: goals, cancels, e-stops, at the times a script says.

mod operator;
mod script;

pub use operator::ScriptedOperator;
pub use script::{Deed, OperatorCommand, ScriptError};
