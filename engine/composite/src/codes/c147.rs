use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Control state without exit
///
/// A rule enters this state, and none leaves it: the coordinator stays in it until the system restarts. A state in which the
/// coordinator is meant to end is declared as final with a comment in the specification, such as `//@Final ARRIVED FAILED`.
/// Control states are functions named `mode`, `state`, `ctl_state` or `ctlState` without arguments.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Mode = {IDLE | RUNNING | FAILED}
///   monitored estop: Boolean
///   controlled mode: Mode
/// definitions:
///   main rule r_Main =
///     switch mode
///       case IDLE: if estop then skip else mode := RUNNING endif
///       case RUNNING: if estop then mode := FAILED endif
///     endswitch
/// default init s0:
///   function mode = IDLE
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
/// subscribe = { estop = "std_msgs/Bool" }
/// bind = { monitored = { estop = { topic = "estop", none = false } } }
///
/// [[promote]]
/// topic = "estop"
/// as = "estop"
/// ```
///
/// Corrected, a state that ends the run on purpose:
///
/// ```asm corrected
/// asm example
/// signature:
///   enum domain Mode = {IDLE | RUNNING | FAILED}
///   monitored estop: Boolean
///   controlled mode: Mode
/// definitions:
///   //@Final FAILED
///   main rule r_Main =
///     switch mode
///       case IDLE: if estop then skip else mode := RUNNING endif
///       case RUNNING: if estop then mode := FAILED endif
///     endswitch
/// default init s0:
///   function mode = IDLE
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C147, warning)]
#[error("no rule leaves `{function} = {state}`")]
pub(crate) struct StateWithoutExit {
    pub function: String,
    pub state: String,
    pub at: Span,
    /// Location of the update that enters the state.
    pub entered: Span,
}

impl Finding for StateWithoutExit {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "this coordinator would stay in it")
            .label(self.entered, "entered here")
            .help(format!(
                "add a rule that leaves it; if the coordinator is meant to end there, add the comment `//@Final {}` to the specification",
                self.state
            ))
    }
}
