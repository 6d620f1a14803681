use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown field type
///
/// A field is a number, a string, a Boolean, a time, or has a type that the build or a type file
/// describes. `name[]` is a list, `name[5]` an array.
///
/// ```toml wrong
/// schema = "composite-types/1"
///
/// [type."arm/Status"]
/// fields = { stamp = "time", position = "f46[5]" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite-types/1"
///
/// [type."arm/Status"]
/// fields = { stamp = "time", position = "f64[5]" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C110, error)]
#[error("unknown type `{name}`")]
pub(crate) struct UnknownType {
    pub name: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownType {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        diagnostic
            .label(
                self.at,
                "neither described in a file of `types` nor known to this build",
            )
            .suggest_or(
                self.at,
                nearest,
                "write a type such as `f64`, `u16[5]`, `string`, `time` or `geometry_msgs/Pose[]`",
            )
    }
}
