use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Component in no process
///
/// If `[deploy]` lists processes, every component must be assigned to one of them.
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
/// processes = [{ name = "robot", components = ["Map"] }]
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
/// processes = [{ name = "robot", components = ["Map", "Laser"] }]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C071, error)]
#[error("`{component}` is not placed in a process")]
pub(crate) struct PlacedNowhere {
    pub component: String,
    pub at: Span,
    pub deploy: Span,
}

impl Finding for PlacedNowhere {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { component, .. } = self;
        diagnostic
            .label(self.at, "declared here")
            .label(self.deploy, format!("no process contains `{component}`"))
            .help("add it to the `components` of a process")
    }
}
