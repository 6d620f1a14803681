use crate::nearest::nearest_name;
use crate::signature::ParameterInfo;
use crate::wording::enumerate;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown element of a bound location
///
/// The arguments of a bound location are elements of the domains of its function.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Robot = {ROB1 | ROB2}
///   monitored wants: Robot -> Boolean
///   controlled tries: Integer
/// definitions:
///   main rule r_Main = skip
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { "ROB1/wants" = "std_msgs/Bool", "ROB2/wants" = "std_msgs/Bool" }
///
/// [components.Coordinator.bind.monitored]
/// "wants(ROB1)" = { topic = "ROB1/wants" }
/// "wants(ROB3)" = { topic = "ROB2/wants" }
///
/// [[promote]]
/// topic = "ROB1/wants"
/// as = "ROB1/wants"
///
/// [[promote]]
/// topic = "ROB2/wants"
/// as = "ROB2/wants"
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
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { "ROB1/wants" = "std_msgs/Bool", "ROB2/wants" = "std_msgs/Bool" }
///
/// [components.Coordinator.bind.monitored]
/// "wants(ROB1)" = { topic = "ROB1/wants" }
/// "wants(ROB2)" = { topic = "ROB2/wants" }
///
/// [[promote]]
/// topic = "ROB1/wants"
/// as = "ROB1/wants"
///
/// [[promote]]
/// topic = "ROB2/wants"
/// as = "ROB2/wants"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C140, error)]
#[error("`{}` has no element `{element}`", parameter.name)]
pub(crate) struct UnknownElement {
    pub element: String,
    pub parameter: ParameterInfo,
    pub at: Span,
    pub declared: Span,
}

/// Limit for the elements that the help lists.
const LISTED: usize = 8;

impl Finding for UnknownElement {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic
            .label(self.at, "bound here")
            .label(self.declared, "declared here");
        let Some(elements) = &self.parameter.elements else {
            return diagnostic
                .help("write an integer; the elements of other domains have no names");
        };
        let nearest = nearest_name(&self.element, elements.iter().map(String::as_str));
        if let Some(nearest) = nearest {
            return diagnostic.help(format!("did you mean `{}`?", nearest.name));
        }
        let names: Vec<&str> = elements.iter().take(LISTED).map(String::as_str).collect();
        let more = if elements.len() > LISTED { ", …" } else { "" };
        diagnostic.help(format!("write {}{more}", enumerate(&names)))
    }
}
