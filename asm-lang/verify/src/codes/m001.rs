use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_lang::{FaultKind, Machine, Specification, StepFault};

/// Input without finitely many values
///
/// Verification executes each step with every value of the inputs that it reads. The values of `Integer`, `Real` or `String` cannot
/// be enumerated, nor can those of a domain with more than 4096 elements. A step that reads such an input can only be verified
/// with selected values.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   monitored distance: Integer
///   controlled isNear: Boolean
/// definitions:
///   main rule r_Main = isNear := distance < 10
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   domain Distance subsetof Integer
///   monitored distance: Distance
///   controlled isNear: Boolean
/// definitions:
///   domain Distance = {0:20}
///   main rule r_Main = isNear := distance < 10
/// ```
///
/// Instead of a smaller domain, `asmotion verify --values distance=0,9,10` selects values for one verification. Properties are then
/// verified for these values only.
#[derive(Debug, thiserror::Error, Coded)]
#[code(M001, error)]
#[error("the values of `{location}` cannot be enumerated")]
pub(crate) struct InputWithoutRange {
    pub location: String,
    pub function: String,
    pub at: Span,
}

impl Finding for InputWithoutRange {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "read here").help(format!(
            "declare a finite domain as its codomain, or select values with `--values {}=…`",
            self.function
        ))
    }
}

impl InputWithoutRange {
    /// Describes the fault of a step or a condition that reads the input.
    pub fn of(specification: &Specification, machine: &Machine, fault: &StepFault) -> Self {
        let mut found = Self {
            location: "an input".to_owned(),
            function: "FUNCTION".to_owned(),
            at: specification.span(fault.origin),
        };
        if let FaultKind::Input { slot, .. } = fault.kind {
            let program = machine.program();
            let function = machine
                .state()
                .function(program, slot)
                .or(program.dense_function(slot));
            let name = function.and_then(|id| program.symbols.functions.get(id.0 as usize));
            if let Some(name) = name {
                found.function = name.to_string();
                found.location = name.to_string();
            }
        }
        found
    }
}
