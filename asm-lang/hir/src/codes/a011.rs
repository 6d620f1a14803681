use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Circular import
///
/// A file cannot import itself, directly or through other files. Move what both files need to a third
/// module.
///
/// ```asm wrong
/// asm example
/// import other
/// signature:
/// definitions:
///   main rule r_Main = skip
/// //--- other.asm
/// module other
/// import example
/// export *
/// signature:
/// definitions:
/// ```
///
/// Mended:
///
/// ```asm mended
/// asm example
/// import other
/// signature:
/// definitions:
///   main rule r_Main = skip
/// //--- other.asm
/// module other
/// export *
/// signature:
/// definitions:
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A011, error)]
#[error("`{path}` imports itself")]
pub(crate) struct ImportCycle {
    pub path: String,
    pub at: Span,
    /// The files of the cycle, each with the import that leads to the next one.
    pub chain: Vec<(String, Option<Span>)>,
}

impl Finding for ImportCycle {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        if self.chain.len() < 2 {
            return diagnostic
                .label(self.at, "this is the file itself")
                .help("drop this import: a file knows its own names");
        }
        let mut finding = diagnostic.label(self.at, "this import closes the circle");
        for (path, import) in &self.chain {
            if let Some(import) = import.filter(|import| *import != self.at) {
                finding = finding.label(import, format!("`{path}` imports this"));
            }
        }
        finding.help("move what both files need into a third module and import that")
    }
}
