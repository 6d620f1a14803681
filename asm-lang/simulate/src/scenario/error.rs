//! What may be wrong with a scenario, given its specification.

use asmotion_diagnostics::{Diagnostic, Span};
use std::sync::Arc;

#[derive(Debug, thiserror::Error)]
pub(super) enum PlanError {
    #[error("there is no block `{name}`")]
    NoBlock {
        name: String,
        at: Span,
        scenario: Option<String>,
        similar: Option<Arc<str>>,
    },

    #[error("the scenario `{name}` cannot be read")]
    NoScenario { name: String, at: Span },

    #[error("the block `{name}` runs itself")]
    Circle { name: String, at: Span },

    #[error("no `choose` binds `{variable}`")]
    NoChoice {
        variable: String,
        rule: Option<String>,
        at: Span,
        similar: Option<Arc<str>>,
    },

    #[error("there is no rule `{name}`")]
    NoRule {
        name: String,
        at: Span,
        similar: Option<Arc<str>>,
    },

    #[error("`undef` cannot be picked")]
    PicksUndef { at: Span },

    #[error("blocks run blocks, more than {limit} deep")]
    TooDeep { at: Span, limit: usize },

    #[error("the scenario becomes too long")]
    TooLong { at: Span, limit: usize },

    #[error("the specification `{name}` has no main rule")]
    NoMain { name: String, at: Span },
}

impl PlanError {
    pub fn diagnostic(&self) -> Diagnostic {
        let error = |code| Diagnostic::error(code, self);
        match self {
            Self::NoBlock {
                at,
                scenario,
                similar,
                ..
            } => {
                let place = match scenario {
                    Some(scenario) => format!("not in the scenario `{scenario}`"),
                    None => "not in this scenario".to_owned(),
                };
                meant(error("V011").label(*at, place), *at, similar)
                    .help("declare it with `begin name … end`; `execblock scenario:block` runs one of another file")
            }
            Self::NoScenario { at, .. } => error("V012")
                .label(*at, "there is no such file beside this one")
                .help("write the name of the file without `.avalla`"),
            Self::Circle { at, .. } => error("V013")
                .label(*at, "here, directly or over other blocks")
                .help("blocks run once; write the commands out where they repeat"),
            Self::NoChoice {
                at, rule, similar, ..
            } => {
                let place = match rule {
                    Some(rule) => format!("no `choose` of `{rule}` does"),
                    None => "no rule of the specification does".to_owned(),
                };
                meant(error("V014").label(*at, place), *at, similar)
                    .help("name a variable that stands behind `choose`")
            }
            Self::NoRule { at, similar, .. } => {
                meant(error("V015").label(*at, "not declared"), *at, similar)
                    .help("name the rule in which the `choose` stands")
            }
            Self::PicksUndef { at } => error("V016")
                .label(*at, "no candidate")
                .help("pick an element of the range, or leave the pick out"),
            Self::TooDeep { at, .. } => error("V019")
                .label(*at, "one more here")
                .help("run the blocks one after the other instead"),
            Self::TooLong { at, limit } => error("V017")
                .label(
                    *at,
                    format!("it has more than {limit} commands from here on"),
                )
                .help("let blocks run each other less often"),
            Self::NoMain { at, .. } => error("V018")
                .label(*at, "a module runs nothing by itself")
                .help("load a specification with a main rule that imports it"),
        }
    }
}

/// Offers a similar name, if there is one.
fn meant(finding: Diagnostic, at: Span, similar: &Option<Arc<str>>) -> Diagnostic {
    match similar {
        Some(name) => finding.guess(format!("did you mean `{name}`?"), at, name.to_string()),
        None => finding,
    }
}
