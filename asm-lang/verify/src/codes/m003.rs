use crate::formula::{FormulaProblem, NoFormula};
use crate::operator::Logic;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Property that is no temporal formula
///
/// A property consists of conditions, to which the operators of one temporal logic and the connectives `not`, `and`, `or`, `implies`,
/// `iff`, `=`, `if` and quantifiers are applied, and functions that are defined in this way. Temporal operators cannot be arguments of
/// other functions, and those of CTL cannot be mixed with those of LTL.
///
/// An invariant is about each state on its own and has no temporal operators: in place of `invariant inv over isOn: ag(isOn)`, write
/// `CTLSPEC ag(isOn)`, or `invariant inv over isOn: isOn`, which says the same. Neither have assumptions (`INVAR`, `--assume`), fairness
/// constraints (`JUSTICE`, `COMPASSION`), `--possible` and `--end`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// import LTLLibrary
/// signature:
///   controlled isOn: Boolean
/// definitions:
///   CTLSPEC ag(f(isOn))
///   main rule r_Main = isOn := not isOn
/// default init s0:
///   function isOn = false
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// signature:
///   controlled isOn: Boolean
/// definitions:
///   CTLSPEC ag(af(isOn))
///   main rule r_Main = isOn := not isOn
/// default init s0:
///   function isOn = false
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M003, error)]
#[error("this is no temporal formula: {}", reason(&problem.problem))]
pub(crate) struct NoTemporalFormula {
    pub problem: NoFormula,
}

fn reason(problem: &FormulaProblem) -> String {
    match problem {
        FormulaProblem::Nested => {
            "a temporal operator is inside a term that is no connective".to_owned()
        }
        FormulaProblem::Mixed { operator, expected } => {
            let expected = match expected {
                Logic::Ctl => "CTL",
                Logic::Ltl => "LTL",
            };
            format!("`{operator}` is no operator of {expected}")
        }
        FormulaProblem::Range => {
            "the range of a quantifier over temporal formulas is no finite domain".to_owned()
        }
        FormulaProblem::Count => "the number of steps is no number".to_owned(),
        FormulaProblem::Invariant(_) => "an invariant is about one state".to_owned(),
        FormulaProblem::Condition => "this condition is about one state".to_owned(),
    }
}

impl Finding for NoTemporalFormula {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let help = match &self.problem.problem {
            FormulaProblem::Nested => {
                "apply temporal operators to conditions, and connect them with `and`, `or`, `not`, `implies`"
            }
            FormulaProblem::Mixed {
                expected: Logic::Ctl,
                ..
            } => "use `ax`, `ag`, `af`, `au`, `ex`, `eg`, `ef`, `eu`, or declare an LTLSPEC",
            FormulaProblem::Mixed {
                expected: Logic::Ltl,
                ..
            } => "use `x`, `g`, `f`, `u`, `v` and the operators of the past, or declare a CTLSPEC",
            FormulaProblem::Range => "quantify over an enumeration, or a domain of integers",
            FormulaProblem::Count => "write a literal, as in `exN(p, 3n)`",
            FormulaProblem::Condition => "write a condition without temporal operators",
            FormulaProblem::Invariant(Logic::Ctl) => "declare a CTLSPEC in place of the invariant",
            FormulaProblem::Invariant(Logic::Ltl) => "declare an LTLSPEC in place of the invariant",
        };
        diagnostic.label(self.problem.at, "here").help(help)
    }
}
