use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_program::ProgramError;

/// Program of another machine without a declaration
///
/// A component runs in a process of another machine (`host`, in `deploy.processes`), or in another process than the one that is
/// started (`asmotion run --process`). Its program cannot be asked for its declaration here, so the members of the component
/// are not verified; the process that runs it verifies them. Message types that only this program declares are unknown
/// here, unless a type file (`types`, in `composite`) defines them.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Gripper]
/// implementation = { process = "grippr" }
///
/// [[deploy.processes]]
/// name = "arm"
/// host = "robot"
/// components = ["Gripper"]
/// ```
///
/// Corrected, if the program is installed here, too:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Gripper]
/// implementation = { process = "gripper" }
///
/// [[deploy.processes]]
/// name = "arm"
/// host = "robot"
/// components = ["Gripper"]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C154, warning)]
#[error("program `{command}` of another process cannot be asked for its declaration here")]
pub(crate) struct ProgramElsewhere {
    /// The command as a line of text.
    pub command: String,
    pub at: Span,
    /// The members of the component that the composite lists.
    pub unverified: Vec<String>,
    pub reason: ProgramError,
}

impl Finding for ProgramElsewhere {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let reason = self.reason.clone().without_lines();
        let diagnostic = diagnostic.label(self.at, reason.to_string());
        let diagnostic = if self.unverified.is_empty() {
            diagnostic
        } else {
            diagnostic.note(format!("not verified: {}", self.unverified.join(", ")))
        };
        diagnostic.help(
            "the process that runs it verifies it; define its message types in a file of `types` if components here use them",
        )
    }
}
