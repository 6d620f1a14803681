//! The scripted operator: sends goals, cancels and e-stops at the times in its script.

mod operator;
mod script;

pub use operator::ScriptedOperator;
pub use script::{OperatorCommand, ScheduledCommand, ScriptError};

/// Protocol of the scripted operator: what it sends, depending on what it receives.
pub const PROTOCOL: &str = include_str!("../protocol.asm");
