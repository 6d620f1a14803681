use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Port of another component
///
/// A proxy offers the ports of its target as services. The port belongs to another component.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Arm]
/// implementation = { process = "arm" }
/// ports.in = { commands = "geometry_msgs/Twist" }
/// ports.out = { status = "nav_msgs/Odometry" }
///
/// [components.Other]
/// implementation = { process = "other" }
/// ports.out = { status = "nav_msgs/Odometry" }
///
/// [components.Proxy]
/// implementation = { builtin = "port-proxy", target = "Arm" }
/// services = { sending = "arm/Sending", status = "arm/Status" }
/// map = [
///   { operation = "sending.set", port = "Arm.commands", mode = "oneway" },
///   { operation = "status.get", port = "Arm.status", mode = "last" },
///   { operation = "status.get", port = "Other.status", mode = "last" },
/// ]
///
/// [[connections]]
/// from = "Proxy.commands"
/// to = "Arm.commands"
///
/// [[connections]]
/// from = "Arm.status"
/// to = "Proxy.status"
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
/// [components.Arm]
/// implementation = { process = "arm" }
/// ports.in = { commands = "geometry_msgs/Twist" }
/// ports.out = { status = "nav_msgs/Odometry" }
///
/// [components.Other]
/// implementation = { process = "other" }
/// ports.out = { status = "nav_msgs/Odometry" }
///
/// [components.Proxy]
/// implementation = { builtin = "port-proxy", target = "Arm" }
/// services = { sending = "arm/Sending", status = "arm/Status" }
/// map = [
///   { operation = "sending.set", port = "Arm.commands", mode = "oneway" },
///   { operation = "status.get", port = "Arm.status", mode = "last" },
/// ]
///
/// [[connections]]
/// from = "Proxy.commands"
/// to = "Arm.commands"
///
/// [[connections]]
/// from = "Arm.status"
/// to = "Proxy.status"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C121, error)]
#[error("`{port}` is not a port of target `{target}`")]
pub(crate) struct PortOfOtherComponent {
    pub port: String,
    pub target: String,
    pub at: Span,
    pub target_at: Span,
}

impl Finding for PortOfOtherComponent {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "port of another component")
            .label(self.target_at, "target set here")
            .help("name a port of the target, or add a proxy for the other component")
    }
}
