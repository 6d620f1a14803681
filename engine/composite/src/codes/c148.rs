use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

use crate::signature::FunctionInfo;

/// Bound function that is never read
///
/// The composite binds this monitored function to a topic, a service, a timer or the outcome of a call, but no rule,
/// definition or invariant of the specification reads it, nor does a term in a binding. Its messages have no effect on
/// the coordinator.
///
/// ```asm
/// asm example
/// signature:
///   monitored estop: Boolean
///   monitored blocked: Boolean
///   controlled stopped: Boolean
/// definitions:
///   main rule r_Main = stopped := estop
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { estop = "std_msgs/Bool", blocked = "std_msgs/Bool" }
/// bind = { monitored = { estop = { topic = "estop", none = false }, blocked = { topic = "blocked", none = false } } }
///
/// [[promote]]
/// topic = "estop"
/// as = "estop"
///
/// [[promote]]
/// topic = "blocked"
/// as = "blocked"
/// ```
///
/// Corrected, with a rule that reads it:
///
/// ```asm corrected
/// asm example
/// signature:
///   monitored estop: Boolean
///   monitored blocked: Boolean
///   controlled stopped: Boolean
/// definitions:
///   main rule r_Main = if blocked then stopped := true else stopped := estop endif
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C148, warning)]
#[error("no rule reads the bound function `{}`", function.name)]
pub(crate) struct UnreadBoundFunction {
    pub function: FunctionInfo,
    /// Place of the first binding.
    pub at: Span,
}

impl Finding for UnreadBoundFunction {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "bound here")
            .label(
                self.function.declared,
                format!("declared `{}` here", self.function.kind.word()),
            )
            .help("read it in a rule, or remove the binding")
    }
}
