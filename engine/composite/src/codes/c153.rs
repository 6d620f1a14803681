use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_program::ProgramError;

/// Program without a declaration
///
/// A component of the composite is a program of its own, which is started to ask for its ports, services, references and
/// properties. It could not be started, ended or failed to answer in time, or its answer violates the protocol
/// (`docs/program-protocol.md`). `asmotion check --no-programs` starts no program.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Gripper]
/// implementation = { process = "grippr" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Gripper]
/// implementation = { process = ["python3", "gripper.py"] }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C153, error)]
#[error("program `{command}` cannot be asked for its declaration")]
pub(crate) struct ProgramWithoutDeclaration {
    /// The command as a line of text.
    pub command: String,
    pub at: Span,
    /// Working directory of the program.
    pub directory: String,
    pub reason: ProgramError,
}

impl Finding for ProgramWithoutDeclaration {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let lines = self.reason.last_lines().iter();
        let reason = self.reason.clone().without_lines();
        let mut diagnostic = diagnostic.label(self.at, reason.to_string());
        for line in lines {
            diagnostic = diagnostic.note(format!("its output: {}", line.trim()));
        }
        match &self.reason {
            ProgramError::NotStarted { .. } => diagnostic.help(format!(
                "the program is started in `{}`, the directory of the composite unless `directory` names another one",
                self.directory
            )),
            ProgramError::NotConnected { .. } => diagnostic.help(
                "a component's program connects to the Unix socket whose path is in `ASMOTION_SOCKET`; `start_timeout_s` \
                 gives it more time",
            ),
            ProgramError::Silent { .. } => {
                diagnostic.help("`start_timeout_s` gives the program more time")
            }
            ProgramError::Ended { .. } | ProgramError::Fault { .. } => diagnostic,
            ProgramError::Protocol(_) => {
                diagnostic.help("docs/program-protocol.md specifies the messages of a program")
            }
        }
    }
}
