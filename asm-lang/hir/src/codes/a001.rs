use crate::hidden::HiddenName;
use crate::suggest::with_similar;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Fix, Span};
use std::sync::Arc;

/// Unknown function
///
/// The function is declared neither in this file nor in its imports, or the module that declares it
/// does not export it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled speed: Integer
/// definitions:
///   main rule r_Main = sped := 1
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled speed: Integer
/// definitions:
///   main rule r_Main = speed := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A001, error)]
#[error("unknown function `{name}`")]
pub(crate) struct UnknownFunction {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<(Arc<str>, Span)>,
    pub hidden: Option<HiddenName>,
}

impl Finding for UnknownFunction {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { similar, .. } = self;
        if let Some(hidden) = &self.hidden {
            return hidden.explain(diagnostic, self.at);
        }
        let finding = diagnostic.label(self.at, "not declared in this file or its imports");
        let mut elsewhere = ELSEWHERE.iter();
        if let Some((_, function)) = elsewhere.find(|(name, _)| *name == &*self.name) {
            let title = format!("did you mean `{function}`?");
            return finding.with_fix(Fix::maybe(title, self.at, *function));
        }
        let help = if UNDEFINED.contains(&&*self.name) {
            "write `undef` for the undefined value, and `isDef(…)` or `isUndef(…)` to test for it"
        } else if TEMPORAL.contains(&&*self.name) {
            return finding.help("`import CTLLibrary` declares the operators of temporal logic");
        } else {
            "declare it in the signature, or import the module that declares it"
        };
        with_similar(finding, self.at, similar, help)
    }
}

/// Names of library functions in other languages, and in AsmetaL.
const ELSEWHERE: [(&str, &str); 6] = [
    ("rest", "tail"),
    ("cdr", "tail"),
    ("car", "first"),
    ("head", "first"),
    ("len", "length"),
    ("card", "size"),
];

/// Operators of `CTLLibrary`. Those of `LTLLibrary` have one letter, and more likely mean something else.
const TEMPORAL: [&str; 10] = ["ag", "af", "ax", "au", "aw", "eg", "ef", "ex", "eu", "ew"];

/// The undefined value in other languages.
const UNDEFINED: [&str; 4] = ["null", "nil", "none", "undefined"];
