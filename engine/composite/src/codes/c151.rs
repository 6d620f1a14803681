use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

use crate::wording::joined;

/// No single provider of an interface
///
/// A wire with `interface` leads to the component of the composite that provides a service with this interface. There is
/// none, or there are several that can run together.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Planner]
/// implementation = { process = "planner" }
/// references = { maps = "nav/MapService" }
///
/// [components.Floor]
/// implementation = { process = "floor" }
/// services = { maps = "nav/MapService" }
///
/// [components.Yard]
/// implementation = { process = "yard" }
/// services = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "Planner.maps"
/// interface = "nav/MapService"
/// timeout_ms = 1000
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
/// [components.Planner]
/// implementation = { process = "planner" }
/// references = { maps = "nav/MapService" }
///
/// [components.Floor]
/// implementation = { process = "floor" }
/// services = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "Planner.maps"
/// interface = "nav/MapService"
/// timeout_ms = 1000
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C151, error)]
#[error("{} of `{reference}`", subject(interface, providers))]
pub(crate) struct NoSingleProvider {
    pub interface: String,
    pub reference: String,
    /// The services with the interface; none or several.
    pub providers: Vec<String>,
    pub at: Span,
}

fn subject(interface: &str, providers: &[String]) -> String {
    let names: Vec<&str> = providers.iter().map(String::as_str).collect();
    match names.as_slice() {
        [] => format!("no component provides the interface `{interface}`"),
        names => format!(
            "{} provide the interface `{interface}`",
            joined(names, "and")
        ),
    }
}

impl Finding for NoSingleProvider {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self.providers.first() {
            Some(first) => diagnostic
                .label(self.at, "ambiguous")
                .help(format!("name the service, as in `service = \"{first}\"`")),
            None => diagnostic
                .label(
                    self.at,
                    "not provided by another component of this composite",
                )
                .help("add a component that provides it, or name a service"),
        }
    }
}
