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
/// Corrected:
///
/// ```asm corrected
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
#[error("circular import of `{path}`")]
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
                .label(self.at, "imports its own file")
                .help("remove this import");
        }
        let mut finding = diagnostic.label(self.at, "closes the cycle");
        for (path, import) in &self.chain {
            if let Some(import) = import.filter(|import| *import != self.at) {
                finding = finding.label(import, format!("imported by `{path}`"));
            }
        }
        finding.help("move the shared declarations into a third module and import that")
    }
}
