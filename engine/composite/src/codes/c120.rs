use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong direction of a mapped port
///
/// `oneway`, `taken` and `done` write to an input of the target; `last` and `all` read an output of it.
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
///   { operation = "status.get", port = "Arm.commands", mode = "last" },
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
#[code(C120, error)]
#[error("`mode = \"{mode}\"` needs an {wanted} of the target, but `{port}` is an {found}")]
pub(crate) struct WrongPortDirection {
    pub mode: &'static str,
    pub wanted: &'static str,
    pub found: &'static str,
    pub port: String,
    pub at: Span,
    pub declared: Option<Span>,
}

impl Finding for WrongPortDirection {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            declared, found, ..
        } = self;
        let diagnostic = diagnostic
                    .label(self.at, "named here")
                    .help("use `oneway`, `taken` and `done` with an input of the target, `last` and `all` with an output");
        match declared {
            Some(declared) => diagnostic.label(*declared, format!("an {found}")),
            None => diagnostic,
        }
    }
}
