use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Comprehension without a term
///
/// A comprehension ends with `:` and the term for its elements: `{ $x in D | guard : $x }`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled big: Powerset(Integer)
/// definitions:
///   main rule r_Main = big := {$x in {1 : 9} | $x > 5}
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled big: Powerset(Integer)
/// definitions:
///   main rule r_Main = big := {$x in {1 : 9} | $x > 5 : $x}
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L066, error)]
#[error("comprehension without a term for its elements")]
pub(crate) struct MissingElement {
    /// The closing bracket.
    pub at: Span,
    pub opened: Span,
    /// The only variable; `None` if there are several.
    pub variable: Option<String>,
    /// The place behind the last token before the closing bracket.
    pub behind: Span,
}

impl Finding for MissingElement {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic
            .label(self.at, "expected `:` and a term before this")
            .label(self.opened, "comprehension begins here");
        match &self.variable {
            Some(variable) => diagnostic.fix(
                format!("collect the values of `{variable}`"),
                self.behind,
                format!(" : {variable}"),
            ),
            None => diagnostic.help("write `: term` with the element for these variables"),
        }
    }
}
