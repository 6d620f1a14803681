use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// A name of a library that is not imported
///
/// Operators, `isDef`, `first`, timers and many other functions are declared in libraries, which a
/// specification imports. It is said once for each library, at the first name.
///
/// ```asm wrong
/// asm example
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if isDef(n) then n := n + 1 endif
/// ```
///
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if isDef(n) then n := n + 1 endif
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A036, error)]
#[error("`{name}` is known only with `import {library}`")]
pub(crate) struct NotImported {
    pub name: Arc<str>,
    pub library: &'static str,
    pub at: Span,
}

impl Finding for NotImported {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { library, .. } = self;
        diagnostic
            .label(
                self.at,
                format!("declared by `{library}`, which this file does not import"),
            )
            .help(format!(
                "write `import {library}` behind the name of the specification"
            ))
    }
}
