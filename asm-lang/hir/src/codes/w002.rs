use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// File name differs from the specification
///
/// AsmetaS requires `asm counter` to be in `counter.asm`. asmotion does not, and `asmotion check --fix`
/// renames the specification after its file.
///
/// ```asm wrong
/// asm counter
/// import StandardLibrary
/// signature:
/// definitions:
///   main rule r_Main = skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
/// definitions:
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W002, warning)]
#[error("file `{stem}` contains specification `{name}`")]
pub(crate) struct FileNameDiffers {
    pub name: Arc<str>,
    pub stem: String,
    pub at: Span,
}

impl Finding for FileNameDiffers {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { name, stem, .. } = self;
        let found = diagnostic
            .label(self.at, "differs from the file name")
            .help(format!(
                "or rename the file to `{name}.asm`; the reference tools require equal names"
            ));
        if is_word(stem) {
            found.fix("rename the specification", self.at, stem.clone())
        } else {
            found
        }
    }
}

/// Returns `true` if a file name is a valid name of a specification.
fn is_word(stem: &str) -> bool {
    let mut letters = stem.chars();
    let first = letters.next();
    first.is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}
