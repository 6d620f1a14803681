use crate::nearest::Nearest;
use crate::nearest::Suggest;
use crate::wording::label_or_outside;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, did_you_mean};

/// Unknown composite property
///
/// `${properties.name}` and `--set name=value` refer to the properties declared under `[properties]`.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [properties]
/// folder = { type = "string", default = "maps" }
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// properties = { source = "${properties.foldr}" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [properties]
/// folder = { type = "string", default = "maps" }
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// properties = { source = "${properties.folder}" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C013, error)]
#[error("unknown property `{name}` of the composite")]
pub(crate) struct UnknownSetting {
    pub name: String,
    pub at: Option<Span>,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownSetting {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { at, nearest, .. } = self;
        let diagnostic = label_or_outside(diagnostic, *at, "not declared");
        match (at, nearest) {
            (Some(at), nearest) => diagnostic.suggest(*at, nearest),
            (None, Some(nearest)) => diagnostic.help(did_you_mean(&nearest.name)),
            (None, None) => diagnostic.help("declare it in `[properties]` of the composite"),
        }
    }
}
