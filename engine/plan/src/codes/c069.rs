use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wire to the robot itself
///
/// A wire to another robot names that robot in its `url`. The name of a robot is that of its composite, unless it is started with
/// `--robot`: a wire with this name calls a service of its own system, over the broker, if the option is omitted. `asmotion run`
/// refuses it then. A wire to a service of its own composite has a `service`.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [brokers.main]
/// url = "amqp://guest:guest@localhost:5672"
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// binding = "amqp"
/// url = "robot://example/Map.maps"
/// timeout_ms = 500
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
/// [brokers.main]
/// url = "amqp://guest:guest@localhost:5672"
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// binding = "amqp"
/// url = "robot://depot/Map.maps"
/// timeout_ms = 500
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C069, warning)]
#[error("the wire of `{reference}` leads to `{robot}`, the name of its own robot")]
pub(crate) struct OwnRobot {
    pub reference: String,
    pub robot: String,
    pub service: String,
    pub at: Span,
}

impl Finding for OwnRobot {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { service, .. } = self;
        diagnostic
            .label(self.at, "the name of this composite")
            .help(format!(
                "write `service = \"{service}\"` for a service of this composite, or start the robot under another name with `--robot`"
            ))
    }
}
