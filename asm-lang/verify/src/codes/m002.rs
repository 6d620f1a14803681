use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_lang::Specification;

/// Too many alternatives in a state
///
/// Verification executes each step with every combination of the inputs that it reads and the choices that it makes. A step that reads
/// seventeen truth values has 2^17 of them, which is the limit.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Cell subsetof Integer
///   monitored occupied: Cell -> Boolean
///   controlled isFree: Boolean
/// definitions:
///   domain Cell = {1:40}
///   main rule r_Main = isFree := (forall $c in Cell with occupied($c) or not occupied($c))
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   monitored occupied: Boolean
///   controlled isFree: Boolean
/// definitions:
///   main rule r_Main = isFree := not occupied
/// ```
///
/// `asmotion verify --values` with fewer values, or smaller domains, reduce the number of combinations, too.
#[derive(Debug, thiserror::Error, Coded)]
#[code(M002, error)]
#[error("in one state, the inputs and choices of a step have more than {limit} combinations")]
pub(crate) struct TooManyAlternatives {
    pub limit: u64,
    pub at: Span,
}

impl Finding for TooManyAlternatives {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "in this rule or the rules that it calls").help(
            "use smaller domains, read fewer inputs in a step, or select values with `--values FUNCTION=…`; a specification on its own can be tried with `--engine symbolic`",
        )
    }
}

impl TooManyAlternatives {
    pub fn of(specification: &Specification) -> Self {
        Self {
            limit: crate::decisions::MAX_EXECUTIONS,
            at: super::main_rule(specification),
        }
    }
}
