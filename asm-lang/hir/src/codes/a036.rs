use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Library not imported
///
/// Operators, `isDef`, `first`, timers and many other functions are declared in libraries that a
/// specification must import. This is reported once per library, at the first such name.
///
/// ```asm wrong
/// asm example
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if isDef(n) then n := n + 1 endif
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
///   main rule r_Main = if isDef(n) then n := n + 1 endif
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A036, error)]
#[error("`{name}` needs `import {library}`")]
pub(crate) struct NotImported {
    pub name: Arc<str>,
    pub library: &'static str,
    pub at: Span,
    /// Name of the file, after which the import belongs; `None` outside of files.
    pub heading: Option<Span>,
}

impl Finding for NotImported {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { library, .. } = self;
        let diagnostic = diagnostic.label(
            self.at,
            format!("declared in `{library}`, which is not imported"),
        );
        let Some(heading) = self.heading else {
            return diagnostic.help(format!(
                "write `import {library}` after the name of the specification"
            ));
        };
        let behind = Span {
            start: heading.end,
            ..heading
        };
        let (title, text) = ("import the library", format!("\nimport {library}"));
        match *library {
            "StandardLibrary" => diagnostic.fix(title, behind, text),
            // other libraries declare common words, which may be meant differently
            _ => diagnostic.guess(title, behind, text),
        }
    }
}
