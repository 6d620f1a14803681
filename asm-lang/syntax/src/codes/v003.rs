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
/// Mended:
///
/// ```avalla mended
/// scenario example
/// load example.asm
///
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V003, error)]
pub(crate) enum UnknownCommand {
    #[error("`{word}` is no command of a scenario")]
    Misspelt {
        word: String,
        at: Span,
        similar: Option<&'static str>,
    },
    #[error("a command is wanted here")]
    Missing { at: Span },
}

impl Finding for UnknownCommand {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self {
            Self::Misspelt { at, similar, .. } => {
                let finding = diagnostic.label(*at, "not understood");
                match similar {
                    Some(similar) => finding.guess(
                        format!("did you mean `{similar}`?"),
                        *at,
                        (*similar).to_owned(),
                    ),
                    None => finding.help(
                        "the commands are `set`, `check`, `step`, `step until`, `exec`, `pick`, `begin … end` and `execblock`",
                    ),
                }
            }
            Self::Missing { at } => diagnostic
                .label(*at, "not the beginning of a command")
                .help("every command begins with a word: `set`, `check`, `step`, …"),
        }
    }
}
