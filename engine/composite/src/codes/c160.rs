use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

use crate::nearest::Nearest;

/// Protocol names something that its component does not have
///
/// A function of a protocol stands for a port, an operation or a field of the component whose key `protocol` names the file: the
/// one in the comment `//@Port` before it, or the port with the name of the function. A monitored function is something that the
/// component receives, an out function something that it sends. The comment `//@Echo` names a field of an output and a field of
/// an input.
///
/// ```asm
/// asm example
/// signature:
///   monitored command: Boolean
///   out done: Boolean
/// definitions:
///   main rule r_Main = if command then done := true endif
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
/// ports.in = { command = "std_msgs/Bool" }
/// ports.out = { finished = "std_msgs/Bool" }
///
/// [components.Panel]
/// implementation = { process = "panel" }
/// ports.out = { command = "std_msgs/Bool" }
///
/// [[connections]]
/// from = "Panel.command"
/// to = "Gripper.command"
/// ```
///
/// Corrected, with the port that the function stands for:
///
/// ```asm corrected
/// asm example
/// signature:
///   monitored command: Boolean
///   //@Port finished
///   out done: Boolean
/// definitions:
///   main rule r_Main = if command then done := true endif
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C160, error)]
#[error("`{component}` has no {what} `{name}`, which its protocol names")]
pub(crate) struct UnknownProtocolEnd {
    /// Name of the component.
    pub component: String,
    /// Kind of what is missing.
    pub what: &'static str,
    pub name: String,
    /// The function or annotation in the protocol.
    pub at: Span,
    /// The key `protocol`.
    pub key: Span,
    pub nearest: Option<Nearest>,
    /// The way out without a similar name.
    pub help: String,
}

impl Finding for UnknownProtocolEnd {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic
            .label(
                self.at,
                format!("stands for the {} `{}`", self.what, self.name),
            )
            .label(self.key, "the protocol of the component");
        match &self.nearest {
            // the place is a function or an annotation, not the name alone, so there is no fix to apply
            Some(nearest) => diagnostic.help(format!(
                "did you mean `{}`? Write `//@Port {}` before the function, or `//@Echo` with that name",
                nearest.name, nearest.name
            )),
            None => diagnostic.help(self.help.clone()),
        }
    }
}
