use crate::hidden::HiddenName;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Import of a name that is not exported
///
/// A module exports only the names in its `export` clause.
///
/// ```asm wrong
/// asm example
/// import other(limit)
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1
/// //--- other.asm
/// module other
/// export start
/// signature:
///   static limit: Integer
///   static start: Integer
/// definitions:
///   function limit = 9
///   function start = 0
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import other(limit)
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := limit
/// //--- other.asm
/// module other
/// export start, limit
/// signature:
///   static limit: Integer
///   static start: Integer
/// definitions:
///   function limit = 9
///   function start = 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A015, error)]
#[error("`{module}` does not export `{name}`")]
pub(crate) struct NotExported {
    pub module: Arc<str>,
    pub name: Arc<str>,
    pub at: Span,
    /// The declaration in the module; `None` if there is none.
    pub hidden: Option<HiddenName>,
}

impl Finding for NotExported {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "imported here");
        match &self.hidden {
            Some(hidden) => hidden.suggest(diagnostic),
            None => diagnostic.help("declare it in the module, or remove it here"),
        }
    }
}
