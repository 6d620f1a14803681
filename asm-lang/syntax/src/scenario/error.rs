//! What may be wrong with the text of a scenario.

use asmotion_diagnostics::{Diagnostic, Span};

/// The code of a command without `;`, which is a warning that can be mended.
pub(crate) const UNENDED: &str = "V005";

#[derive(Debug, thiserror::Error)]
pub(super) enum ScenarioError {
    #[error("a scenario begins with `scenario` and its name")]
    NoHead { at: Span },

    #[error("a scenario says which specification it is about")]
    NoLoad { at: Span },

    #[error("`{word}` is no command of a scenario")]
    UnknownCommand {
        word: String,
        at: Span,
        similar: Option<&'static str>,
    },

    #[error("a command is wanted here")]
    NoCommand { at: Span },

    #[error("`{command}` wants {wanted}")]
    Incomplete {
        command: &'static str,
        wanted: &'static str,
        form: &'static str,
        at: Span,
    },

    #[error("`;` is missing at the end of a command")]
    Unended {
        command: Span,
        /// What stands behind it.
        next: Span,
        /// Where the `;` belongs.
        end: Span,
    },

    #[error("the block `{name}` does not end")]
    OpenBlock { name: String, at: Span },

    #[error("`end` ends nothing")]
    StrayEnd { at: Span },

    #[error("two blocks are called `{name}`")]
    DoubleBlock { name: String, at: Span, first: Span },

    #[error("`{word}` stands at the beginning of a scenario")]
    Late { word: &'static str, at: Span },

    #[error("blocks nest too deep")]
    TooDeep { at: Span },
}

impl ScenarioError {
    pub(super) fn diagnostic(&self) -> Diagnostic {
        let error = |code| Diagnostic::error(code, self);
        match self {
            Self::NoHead { at } => error("V001")
                .label(*at, "not `scenario`")
                .help("begin with `scenario name` and `load specification.asm`"),
            Self::NoLoad { at } => error("V002")
                .label(*at, "`load` is missing here")
                .help("write `load specification.asm`; the path is relative to the scenario"),
            Self::UnknownCommand { at, similar, .. } => {
                let finding = error("V003").label(*at, "not understood");
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
            Self::NoCommand { at } => error("V003")
                .label(*at, "not the beginning of a command")
                .help("every command begins with a word: `set`, `check`, `step`, …"),
            Self::Incomplete {
                form, at, wanted, ..
            } => error("V004")
                .label(*at, format!("{wanted} should follow"))
                .help(format!("write `{form}`")),
            Self::Unended { command, next, end } => Diagnostic::warning(UNENDED, self)
                .label(*next, "the command ends before this")
                .label(*command, "it begins here")
                .fix("end it with `;`", *end, ";"),
            Self::OpenBlock { at, .. } => error("V006")
                .label(*at, "begins here, and goes on to the end of the scenario")
                .help("write `end` behind its last command"),
            Self::StrayEnd { at } => error("V007")
                .label(*at, "no block is open here")
                .help("leave it out, or write `begin name` before the block"),
            Self::DoubleBlock { at, first, .. } => Diagnostic::warning("V008", self)
                .label(*at, "this one cannot be called by its name")
                .label(*first, "this one is")
                .help("give one of them another name"),
            Self::Late { at, .. } => error("V009")
                .label(*at, "not here")
                .help("move it before the first command"),
            Self::TooDeep { at } => error("V010")
                .label(*at, "one more begins here")
                .help("end blocks before others begin; `execblock` runs them anywhere"),
        }
    }
}
