use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Undeclared name
///
/// The composite refers to a component, topic, broker, profile or process that is declared nowhere.
///
/// ```toml wrong
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
/// from = "Joystik.twist"
/// to = "Rover.twist"
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
#[code(C020, error)]
#[error("unknown {what} `{name}`")]
pub(crate) struct UnknownName {
    pub what: &'static str,
    pub name: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
    /// Place in the composite that leaves this component of its base out.
    pub left_out: Option<Span>,
}

impl Finding for UnknownName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            what,
            nearest,
            name,
            ..
        } = self;
        if let Some(left_out) = self.left_out {
            return diagnostic
                .label(self.at, "still named here")
                .label(left_out, "left out here")
                .help(format!(
                    "leave out what belongs to it, too: `deploy.processes.{name}`, or `connections` and `wires` by their ends, as in `connections.{name}.port`"
                ));
        }
        diagnostic
            .label(self.at, "not declared")
            .suggest_or(self.at, nearest, way_out(what))
    }
}

/// Help text for a name without a similar declared name.
fn way_out(what: &str) -> String {
    match what {
        "component" => "declare a component with `[components.Name]`".to_owned(),
        "profile" => "declare a profile with `profile = \"sim\"` in a component".to_owned(),
        "topic" => "declare a topic under `subscribe` or `publish` of a component".to_owned(),
        "broker" => "declare a broker with `[brokers.name]`".to_owned(),
        "gateway" => "declare a gateway with `[gateways.name]`".to_owned(),
        "bridge" => "declare a bridge with `[bridges.name]`".to_owned(),
        "input" => "declare an input under `subscribe` or `ports.in`".to_owned(),
        "output" => "declare an output under `publish` or `ports.out`".to_owned(),
        "reference" => "declare a reference under `references`".to_owned(),
        "service" => "declare a service under `services`".to_owned(),
        other => format!("name an existing {other}"),
    }
}
