//! The operator on schedule: goals, cancels, e-stops, at the times a script says.

mod operator;
mod script;

pub use operator::Operator;
pub use script::{Command, Deed, ScriptError};
