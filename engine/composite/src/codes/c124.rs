use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Operation does not match its port
///
/// Arguments are converted to a message, and a message to a result, by field names, or through the only
/// field of the right shape. No field may be lost, and none may be missing.
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
/// [components.Proxy]
/// implementation = { builtin = "port-proxy", target = "Arm" }
/// services = { sending = "nav/MapService", status = "arm/Status" }
/// map = [
///   { operation = "sending.getMap", port = "Arm.commands", mode = "oneway" },
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
#[code(C124, error)]
#[error("mismatched types: {what} of `{operation}` is not {wanted}")]
pub(crate) struct ShapeMismatch {
    pub what: &'static str,
    pub operation: String,
    pub wanted: String,
    pub here: String,
    pub there: String,
    pub at: Span,
    pub declared: Option<Span>,
}

impl Finding for ShapeMismatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            here,
            there,
            declared,
            ..
        } = self;
        let diagnostic = diagnostic
            .label(self.at, here)
            .help("use the same field names in both, or select a part of the message with `field`");
        match declared {
            Some(declared) => diagnostic.label(*declared, there),
            None => diagnostic,
        }
    }
}
