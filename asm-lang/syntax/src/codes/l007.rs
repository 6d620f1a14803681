use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Number with an exponent
///
/// AsmetaL has no exponents. Write out all digits.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled x: Real
/// definitions:
///   main rule r_Main = x := 1.5e3
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled x: Real
/// definitions:
///   main rule r_Main = x := 1500.0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L007, error)]
#[error("numbers cannot have an exponent")]
pub(crate) struct ExponentInNumber {
    pub number: String,
    pub at: Span,
}

impl Finding for ExponentInNumber {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { number, .. } = self;
        exponent(diagnostic, number, self.at)
    }
}

fn exponent(found: Diagnostic, number: &str, at: Span) -> Diagnostic {
    let found = found.label(at, "exponent not supported");
    let plain = number
        .parse::<f64>()
        .map(|value| format!("{value:?}"))
        .unwrap_or_default();
    if plain.is_empty() || plain.contains(['e', 'i', 'N']) {
        found.help("write all digits")
    } else {
        found.fix("write all digits", at, plain)
    }
}
