use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Duplicate process name
///
/// A process is identified by its name.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.Laser]
/// implementation = { process = "laser" }
/// publish = { scan = "sensor_msgs/LaserScan" }
///
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Map"] },
///   { name = "robot", components = ["Laser"] },
/// ]
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
/// services = { maps = "nav/MapService" }
///
/// [components.Laser]
/// implementation = { process = "laser" }
/// publish = { scan = "sensor_msgs/LaserScan" }
///
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Map"] },
///   { name = "driver", components = ["Laser"] },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C072, error)]
#[error("duplicate process `{name}`")]
pub(crate) struct DuplicateProcess {
    pub name: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicateProcess {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "declared again here")
            .label(self.first, "first declared here")
            .help("rename one of them, or list all components in one")
    }
}
