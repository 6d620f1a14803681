use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown command
///
/// The commands of a scenario are `set`, `check`, `step`, `step until`, `exec`, `pick`, `begin … end`
/// and `execblock`.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   monitored wish: Integer
///   controlled n: Integer
/// definitions:
///   main rule r_Main = choose $x in {1 : 3} with $x != wish do n := $x
/// ```
///
/// ```avalla wrong
/// scenario example
/// load example.asm
///
/// stepp
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V003, error)]
pub(crate) enum UnknownCommand {
    #[error("unknown command `{word}`")]
    Misspelt {
        word: String,
        at: Span,
        similar: Option<&'static str>,
    },
    #[error("expected a command")]
    Missing { at: Span },
}

impl Finding for UnknownCommand {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self {
            Self::Misspelt { at, similar, .. } => {
                diagnostic.label(*at, "not a command").did_you_mean_or(*at, *similar, "the commands are `set`, `check`, `step`, `step until`, `exec`, `pick`, `begin … end` and `execblock`")
            }
            Self::Missing { at } => diagnostic
                .label(*at, "not the start of a command")
                .help("start with a word such as `set`, `check` or `step`"),
        }
    }
}
