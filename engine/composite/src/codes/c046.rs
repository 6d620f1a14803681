use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Input not mentioned in the composite
///
/// The component has an input that the composite neither connects nor lists. The component runs, but
/// receives nothing there.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Follower]
/// implementation = { rust = "nav::TrajectoryFollower" }
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
/// [components.Follower]
/// implementation = { rust = "nav::TrajectoryFollower" }
/// subscribe = { path = "nav_msgs/Path", odom = "nav_msgs/Odometry", scan = "sensor_msgs/LaserScan", permit = "std_msgs/Bool" }
///
/// [[promote]]
/// topic = "path"
/// as = "path"
///
/// [[promote]]
/// topic = "odom"
/// as = "odom"
///
/// [[promote]]
/// topic = "scan"
/// as = "scan"
///
/// [[promote]]
/// topic = "permit"
/// as = "permit"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C046, warning)]
#[error("input `{port}` of `{component}` is neither listed nor connected")]
pub(crate) struct OpenInput {
    pub component: String,
    pub port: String,
    pub kind: String,
    pub at: Span,
}

impl Finding for OpenInput {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            component,
            port,
            kind,
            ..
        } = self;
        diagnostic
            .label(self.at, "never receives a message there")
            .help(format!(
                "connect an output of type `{kind}` to `{component}.{port}`"
            ))
    }
}
