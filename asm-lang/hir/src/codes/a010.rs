use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Import not found
///
/// A name that the missing file may declare has no finding of its own: a note lists these names.
///
/// The path is relative to the folder of the importing file, and `.asm` may be omitted. The standard
/// libraries are part of asmotion: any path that ends in their name finds them.
///
/// ```asm wrong
/// asm example
/// import shapes/sqare
/// signature:
/// definitions:
///   main rule r_Main = skip
/// //--- shapes/square.asm
/// module square
/// export *
/// signature:
/// definitions:
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import shapes/square
/// signature:
/// definitions:
///   main rule r_Main = skip
/// //--- shapes/square.asm
/// module square
/// export *
/// signature:
/// definitions:
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A010, error)]
#[error("import `{path}` not found")]
pub(crate) struct ImportNotFound {
    pub path: String,
    pub at: Span,
}

impl Finding for ImportNotFound {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { path, .. } = self;
        diagnostic
            .label(self.at, "no such file")
            .note("paths are relative to the folder of the importing file; `.asm` may be omitted")
            .help(format!(
                "correct the path, or create `{path}.asm`",
                path = path.trim_end_matches(".asm")
            ))
    }
}
