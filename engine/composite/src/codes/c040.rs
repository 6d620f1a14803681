use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong direction of a connection
///
/// A connection goes from an output to an input.
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
/// from = "Rover.twist"
/// to = "Joystick.twist"
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
#[code(C040, error)]
#[error("`{end}` is an {is}, so a connection cannot {use_} it")]
pub(crate) struct WrongDirection {
    pub end: String,
    pub is: &'static str,
    pub use_: &'static str,
    pub at: Span,
    pub declared: Option<Span>,
}

impl Finding for WrongDirection {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            is, use_, declared, ..
        } = self;
        let diagnostic = diagnostic
            .label(self.at, format!("cannot {use_} an {is}"))
            .help("connect `from` an output `to` an input");
        match declared {
            Some(declared) => diagnostic.label(*declared, "declared here"),
            None => diagnostic,
        }
    }
}
