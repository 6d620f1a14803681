use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `stale_ms` or `timer` without a period
///
/// A component without a period runs only when a message arrives. It cannot notice that messages have
/// stopped, or that a timer has elapsed.
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
/// notify = { reference = "notifying", refresh = "status.new", stale_ms = 1000 }
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
/// activity = { period_ms = 20 }
/// services = { sending = "arm/Sending", status = "arm/Status" }
/// references = { notifying = { interface = "arm/Notifying", optional = true } }
/// map = [
///   { operation = "sending.set", port = "Arm.commands", mode = "oneway" },
///   { operation = "status.get", port = "Arm.status", mode = "last" },
/// ]
/// notify = { reference = "notifying", refresh = "status.new", stale_ms = 1000 }
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
#[code(C127, warning)]
#[error("`{key}` needs a period, but `{component}` runs only when a message arrives")]
pub(crate) struct StaleWithoutPeriod {
    pub key: &'static str,
    pub component: String,
    pub at: Span,
    pub declared: Span,
}

impl Finding for StaleWithoutPeriod {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "the time is never checked")
            .label(self.declared, "runs only when a message arrives")
            .help("add `activity = { period_ms = 20 }`")
    }
}
