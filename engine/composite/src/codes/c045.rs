use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unconnected input
///
/// The composite lists this input, but nothing is connected to it, so it never receives a message.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
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
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C045, error)]
#[error("unconnected input `{component}.{port}`")]
pub(crate) struct UnconnectedInput {
    pub component: String,
    pub port: String,
    pub kind: String,
    pub nested: bool,
    pub at: Span,
}

impl Finding for UnconnectedInput {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            component,
            port,
            kind,
            nested,
            ..
        } = self;
        let or = if *nested {
            ""
        } else {
            ", or move it to `subscribe`"
        };
        let help = format!("connect an output of type `{kind}` to `{component}.{port}`{or}");
        diagnostic
            .label(self.at, "never receives a message")
            .help(help)
    }
}
