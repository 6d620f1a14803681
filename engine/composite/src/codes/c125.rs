use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid condition on a message
///
/// The conditions of `refresh`, `fault` and `idle`, and the lists of `lengths`, must refer to fields that the message has, of a
/// suitable type.
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
/// services = { sending = "arm/Sending", status = "arm/Status" }
/// references = { notifying = { interface = "arm/Notifying", optional = true } }
/// map = [
///   { operation = "sending.set", port = "Arm.commands", mode = "oneway" },
///   { operation = "status.get", port = "Arm.status", mode = "last" },
/// ]
/// notify = { reference = "notifying", refresh = "status.new", fault = "status.child_frame_id > 0" }
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
/// references = { notifying = { interface = "arm/Notifying", optional = true } }
/// map = [
///   { operation = "sending.set", port = "Arm.commands", mode = "oneway" },
///   { operation = "status.get", port = "Arm.status", mode = "last" },
/// ]
/// notify = { reference = "notifying", refresh = "status.new", fault = "status.child_frame_id == \"lost\"" }
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
#[code(C125, error)]
#[error("{reason}")]
pub(crate) struct InvalidCondition {
    pub reason: String,
    pub found: String,
    /// The way out.
    pub help: &'static str,
    pub at: Span,
    pub declared: Option<Span>,
}

impl Finding for InvalidCondition {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            found,
            help,
            declared,
            ..
        } = self;
        let diagnostic = diagnostic.label(self.at, found).help(*help);
        match declared {
            Some(declared) => diagnostic.label(*declared, "described here"),
            None => diagnostic,
        }
    }
}
