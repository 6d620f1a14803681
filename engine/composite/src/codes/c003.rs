use crate::nearest::Nearest;
use crate::nearest::Suggest;
use crate::wording::enumerate;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown key
///
/// An unknown key would have no effect, so it is an error rather than being ignored.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// task = { perod_ms = 50 }
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
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// task = { period_ms = 50 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C003, error)]
#[error("unknown key `{key}` in {of}")]
pub(crate) struct UnknownKey {
    pub key: String,
    pub of: &'static str,
    pub at: Span,
    pub known: Vec<&'static str>,
    pub nearest: Option<Nearest>,
    /// What to write instead, if the key is a known mistake.
    pub instead: Option<String>,
}

impl Finding for UnknownKey {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { known, nearest, .. } = self;
        let keys = match &self.instead {
            Some(instead) => format!("write `{instead}`"),
            None => format!("the keys are {}", enumerate(known)),
        };
        diagnostic
            .label(self.at, "unknown key")
            .suggest_or(self.at, nearest, keys)
    }
}
