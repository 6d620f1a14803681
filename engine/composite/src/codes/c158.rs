use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_program::ProgramError;

/// Component of another robot without a declaration
///
/// A component of the composite stands for one of another robot (`builtin = "remote"`). Its ports and services are those that the
/// robot announces on the broker. The address is not of the form `robot://ROBOT/Component`, or no robot of this name announced
/// such a component in time, or several processes did.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Arm]
/// implementation = { builtin = "remote", target = "arm/Driver" }
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
/// [components.Arm]
/// implementation = { builtin = "remote", target = "robot://arm/Driver" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C158, error)]
#[error("the interface of `{target}` is unknown")]
pub(crate) struct RobotWithoutDeclaration {
    /// Address of the component.
    pub target: String,
    pub at: Span,
    pub reason: ProgramError,
}

impl Finding for RobotWithoutDeclaration {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, self.reason.to_string());
        if self.target.starts_with("robot://") {
            diagnostic.help(
                "`asmotion component list` shows the components on the broker with their robots",
            )
        } else {
            diagnostic.help(
                "write `robot://ROBOT/Component`, with the name that the robot is started with",
            )
        }
    }
}
