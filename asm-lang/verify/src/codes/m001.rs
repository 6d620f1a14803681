use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_lang::{FaultKind, Machine, Specification, StepFault};

/// Input without finitely many values
///
/// Verification executes each step with every value of the inputs that it reads. The values of `Integer`, `Real` or `String` cannot
/// be enumerated, nor can those of a domain with more than 4096 elements. If such an input is only compared with constants, with
/// locations that have few values or with inputs that have few values, one value for each region between them stands for all others,
/// and the output lists these values. A specification that stores or sends the value of such an input, computes with it or compares
/// it with another one can only be verified with selected values.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   monitored distance: Integer
///   controlled isNear: Boolean
///   controlled last: Integer
/// definitions:
///   main rule r_Main = par
///     isNear := distance < 10
///     last := distance
///   endpar
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
///   controlled last: Distance
/// definitions:
///   domain Distance = {0:20}
///   main rule r_Main = par
///     isNear := distance < 10
///     last := distance
///   endpar
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
    /// Place where it is read.
    pub at: Span,
    /// Place where its value matters, and how.
    pub needed: Option<(Span, String)>,
}

impl Finding for InputWithoutRange {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = match &self.needed {
            Some((place, usage)) if *place == self.at => diagnostic.label(*place, usage),
            Some((place, usage)) => diagnostic.label(*place, usage).label(self.at, "read here"),
            None => diagnostic.label(self.at, "read here"),
        };
        let diagnostic = diagnostic.note(
            "an input that is only compared with constants, or with what has few values, needs no finite domain",
        );
        diagnostic.help(format!(
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
            needed: None,
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
