use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Property that cannot compare machines
///
/// In a system, a property from the command line may be about several machines, each named before its functions, as in
/// `courier.jobs <= dispatcher.finished`. It can read their controlled, out, shared and monitored functions. It cannot read derived
/// and static functions, inputs without a finite domain, elements that `extend` creates, or functions whose domains have the same
/// name or the same literals but different elements.
///
/// ```text wrong
/// asmotion verify --together courier.asm dispatcher.asm --property "courier.isIdle implies dispatcher.finished = 0"
///
/// // courier.asm
///   derived isIdle: Boolean
/// definitions:
///   function isIdle = mode = ASKING
/// ```
///
/// ```text corrected
/// asmotion verify --together courier.asm dispatcher.asm --property "courier.mode = ASKING implies dispatcher.finished = 0"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M012, error)]
#[error("`{text}` is about several machines and cannot be resolved: {reason}")]
pub(crate) struct SeveralMachines {
    pub text: String,
    pub reason: String,
    /// The function that cannot be read, or the whole text.
    pub at: Span,
}

impl Finding for SeveralMachines {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "here")
            .help("or verify a further specification that observes the machines: its monitored functions read those of the same names")
    }
}
