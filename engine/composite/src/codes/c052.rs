use crate::nearest::Suggest;
use crate::nearest::nearest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Rename of an unknown topic
///
/// `rename` maps a name in the component to a topic. The component neither publishes nor subscribes
/// under this name.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Laser]
/// implementation = { process = "laser" }
/// publish = { scan = "sensor_msgs/LaserScan" }
/// rename = { scn = "laser" }
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
/// [components.Laser]
/// implementation = { process = "laser" }
/// publish = { scan = "sensor_msgs/LaserScan" }
/// rename = { scan = "laser" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C052, error)]
#[error("cannot rename `{name}`: `{component}` neither subscribes nor publishes it")]
pub(crate) struct UnknownRename {
    pub component: String,
    pub name: String,
    pub at: Span,
    pub known: Vec<(String, Span)>,
}

impl Finding for UnknownRename {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { name, at, .. } = self;
        let all = self
            .known
            .iter()
            .map(|(name, at)| (name.as_str(), Some(*at)));
        diagnostic
            .label(*at, "not a topic of the component")
            .suggest_or(
                *at,
                &nearest(name, all),
                "write the name in the component on the left, and the topic on the right",
            )
    }
}
