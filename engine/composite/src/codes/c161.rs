use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Values in a protocol that its port cannot carry
///
/// A function of a protocol has the values of the messages for which it stands: `Boolean` for an arrival, for a field with a truth
/// value, and for a list, which is true if it has elements; an enumeration for a text that is one of its literals. The answer
/// to a request is an enumeration of `OK` and the codes of faults. Functions of a protocol have no arguments.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Speed = {SLOW | FAST}
///   //@Port speed.data
///   monitored speed: Speed
///   out done: Boolean
/// definitions:
///   main rule r_Main = if speed = FAST then done := true endif
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Gripper]
/// implementation = { process = "gripper" }
/// protocol = "example.asm"
/// ports.in = { speed = "std_msgs/Float64" }
/// ports.out = { done = "std_msgs/Bool" }
///
/// [components.Panel]
/// implementation = { process = "panel" }
/// ports.out = { speed = "std_msgs/Float64" }
///
/// [[connections]]
/// from = "Panel.speed"
/// to = "Gripper.speed"
/// ```
///
/// Corrected, with what the protocol can know of a number, its arrival:
///
/// ```asm corrected
/// asm example
/// signature:
///   monitored speed: Boolean
///   out done: Boolean
/// definitions:
///   main rule r_Main = if speed then done := true endif
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C161, error)]
#[error("`{function}` in the protocol of `{component}` {problem}")]
pub(crate) struct UnfitProtocolFunction {
    /// Name of the component.
    pub component: String,
    pub function: String,
    /// The misfit, after the name of the function.
    pub problem: String,
    /// The declaration of the function.
    pub at: Span,
    /// The key `protocol`.
    pub key: Span,
    pub help: &'static str,
}

impl Finding for UnfitProtocolFunction {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "declared here")
            .label(self.key, "the protocol of the component")
            .help(self.help)
    }
}
