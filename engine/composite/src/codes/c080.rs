use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Circular inclusion
///
/// A composite cannot contain itself. Move what both files need to a third file.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Inner]
/// implementation = { composite = "example.toml" }
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
/// [components.Inner]
/// implementation = { rust = "nav::MapServer" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C080, error)]
pub(crate) enum CircularInclusion {
    #[error("circular inclusion of `{path}`: {}", chain.join(" → "))]
    Composite {
        path: String,
        chain: Vec<String>,
        places: Vec<Span>,
    },
    #[error("`{path}` is its own base")]
    Layer { path: String, at: Span },
}

impl Finding for CircularInclusion {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self {
            Self::Composite { places, .. } => {
                let diagnostic =
                    diagnostic.help("remove one of these components, or move it to a third file");
                let mut places = places.iter().rev();
                let diagnostic = match places.next() {
                    Some(last) => diagnostic.label(*last, "closes the cycle"),
                    None => diagnostic,
                };
                places.rev().fold(diagnostic, |diagnostic, place| {
                    diagnostic.label(*place, "included here")
                })
            }
            Self::Layer { at, .. } => diagnostic
                .label(*at, "closes the cycle")
                .help("name the file with the common part as `base`"),
        }
    }
}
