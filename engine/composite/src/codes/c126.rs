use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// End of motion unknown
///
/// With `mode = "done"` an operation replies when the motion has ended. `notify.idle` must say how that
/// is detected.
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
/// map = [
///   { operation = "sending.set", port = "Arm.commands", mode = "done" },
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
///   { operation = "sending.set", port = "Arm.commands", mode = "taken" },
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
#[code(C126, error)]
#[error("`mode = \"done\"` needs `notify.idle` for `{port}`")]
pub(crate) struct NoIdleNotification {
    pub port: String,
    pub at: Span,
    pub idle: Option<Span>,
}

impl Finding for NoIdleNotification {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { port, idle, .. } = self;
        let diagnostic = diagnostic.label(self.at, "never replies").help(format!(
            "write `notify.idle` with `of = \"{port}.…\"`, or use `mode = \"taken\"`"
        ));
        match idle {
            Some(idle) => diagnostic.label(*idle, "names another port"),
            None => diagnostic,
        }
    }
}
