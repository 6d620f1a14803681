use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Input that several machines provide
///
/// In a system of several specifications, an input reads the function with its name of the other machine that has one. If several
/// machines have such a function, it is not known which one is meant.
///
/// ```text wrong
/// asmotion verify left.asm right.asm watch.asm
///
/// // left.asm and right.asm                    // watch.asm
/// signature:                                   signature:
///   out isOpen: Boolean                          monitored isOpen: Boolean
/// ```
///
/// An input with a parameter reads the machine of this name, and a machine has another name with `NAME=FILE`:
///
/// ```text corrected
/// asmotion verify LEFT=left.asm RIGHT=right.asm watch.asm
///
/// // left.asm and right.asm                    // watch.asm
/// signature:                                   signature:
///   out isOpen: Boolean                          enum domain Door = {LEFT | RIGHT}
///                                                monitored isOpen: Door -> Boolean
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M007, error)]
#[error("several machines provide `{function}`: `{}`", machines.join("`, `"))]
pub(crate) struct AmbiguousConnection {
    pub function: String,
    pub machines: Vec<String>,
    /// `true` if the input has parameters, so that none is free for the name of the machine.
    pub has_parameters: bool,
    pub at: Span,
}

impl Finding for AmbiguousConnection {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let function = &self.function;
        let help = if self.has_parameters {
            format!("rename `{function}` in all of these machines but one")
        } else {
            format!(
                "declare `{function}` with a parameter whose values are the names of the machines, or rename a function"
            )
        };
        diagnostic
            .label(
                self.at,
                "this input does not name the machine that it reads",
            )
            .help(help)
    }
}
