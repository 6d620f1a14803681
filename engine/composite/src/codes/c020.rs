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
/// Mended:
///
/// ```toml mended
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
#[error("there is no {what} `{name}`")]
pub(crate) struct UnknownName {
    pub what: &'static str,
    pub name: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { what, nearest, .. } = self;
        diagnostic
            .label(self.at, "not known here")
            .suggest_or(self.at, nearest, way_out(what))
    }
}

/// What to do about a name that nothing has.
fn way_out(what: &str) -> String {
    match what {
        "component" => "a component is written as `[components.Name]`".to_owned(),
        "profile" => "a profile is what a component takes part in: `profile = \"sim\"`".to_owned(),
        "topic" => "a topic is what a component subscribes or publishes".to_owned(),
        "broker" => "a broker is written as `[brokers.name]`".to_owned(),
        "gateway" => "a gateway is written as `[gateways.name]`".to_owned(),
        "bridge" => "a bridge is written as `[bridges.name]`".to_owned(),
        "input" => "an input stands under `subscribe` or `ports.in`".to_owned(),
        "output" => "an output stands under `publish` or `ports.out`".to_owned(),
        "reference" => "a reference stands under `references`".to_owned(),
        "service" => "a service stands under `services`".to_owned(),
        other => format!("name a {other} that there is"),
    }
}
