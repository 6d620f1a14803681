use crate::edits::all_sure;
use asmotion_diagnostics::{Coded, Diagnostic, Edit, Finding, Fix, Span};

/// `let` without brackets
///
/// The bindings of a `let` are enclosed in brackets, and variables begin with `$`:
/// `let ($x = 1, $y = 2) in … endlet`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = let $x = 1 in n := $x endlet
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = let ($x = 1) in n := $x endlet
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L065, error)]
#[error("bindings of `let` without brackets")]
pub(crate) struct UnbracketedLet {
    /// The first name.
    pub at: Span,
    /// The bindings up to their `in`; `None` if it was not found.
    pub bindings: Option<Span>,
    /// `true` if the first name lacks its `$`.
    pub unmarked: bool,
    /// The names that lack their `$`, with their uses; empty if it is not certain which names are uses.
    pub names: Vec<Span>,
}

impl Finding for UnbracketedLet {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "expected `(` before this");
        let Some(bindings) = self.bindings else {
            return diagnostic.help("write `let ($x = term) in … endlet`");
        };
        let Span { start, end, .. } = bindings;
        let insert = |at, text: &str| Edit {
            span: Span {
                start: at,
                end: at,
                ..bindings
            },
            text: text.to_owned(),
        };
        if let [first, others @ ..] = &self.names[..] {
            let mut edits = vec![insert(first.start, "($")];
            let (binders, uses): (Vec<&Span>, Vec<&Span>) =
                others.iter().partition(|it| it.start < end);
            edits.extend(binders.iter().map(|name| insert(name.start, "$")));
            edits.push(insert(end, ")"));
            edits.extend(uses.iter().map(|name| insert(name.start, "$")));
            return diagnostic.with_fix(all_sure("write brackets and `$`", &edits));
        }
        if self.unmarked {
            // the uses of the variable lack their `$`, too
            let fix = Fix::maybe("write brackets and `$`", insert(start, "").span, "($");
            return diagnostic.with_fix(fix.and(insert(end, "").span, ")"));
        }
        let edits = [insert(start, "("), insert(end, ")")];
        diagnostic.with_fix(all_sure("put the bindings in brackets", &edits))
    }
}
