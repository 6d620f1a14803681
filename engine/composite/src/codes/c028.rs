use crate::named::NamedAt;
use crate::nearest::{Nearest, Suggest, nearest};
use crate::wording::has;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown component property
///
/// A component in this build declares its properties with types, ranges and units. It has none of this
/// name.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// properties = { sorce = "maps" }
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
/// properties = { source = "maps" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C028, error)]
#[error("unknown property `{name}` of `{component}`", component = self.component(), name = self.name())]
pub(crate) enum UnknownProperty {
    /// Set in a composite file.
    OfComponent {
        component: String,
        name: String,
        at: Span,
        made_of: Span,
        known: Vec<NamedAt>,
    },
    /// Set in a property file.
    InFile {
        component: String,
        name: String,
        at: Span,
        nearest: Option<Nearest>,
        known: Vec<String>,
    },
}

impl UnknownProperty {
    fn component(&self) -> &str {
        match self {
            Self::OfComponent { component, .. } | Self::InFile { component, .. } => component,
        }
    }

    fn name(&self) -> &str {
        match self {
            Self::OfComponent { name, .. } | Self::InFile { name, .. } => name,
        }
    }
}

impl Finding for UnknownProperty {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self {
            Self::OfComponent {
                name,
                at,
                made_of,
                known,
                ..
            } => {
                let names = known.iter().map(|it| it.text.as_str());
                let all = known.iter().map(|it| (it.text.as_str(), it.at));
                diagnostic
                    .label(*at, "not declared")
                    .label(*made_of, "component implemented here")
                    .suggest_or(*at, &nearest(name, all), has("property", names))
            }
            Self::InFile {
                at, nearest, known, ..
            } => {
                let has = if known.is_empty() {
                    "it has none".to_owned()
                } else {
                    format!("it has `{}`", known.join("`, `"))
                };
                diagnostic
                    .label(*at, "not declared")
                    .suggest_or(*at, nearest, has)
            }
        }
    }
}
