use crate::signature::ParameterInfo;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Variable over a domain without listed elements
///
/// A binding with a variable stands for one binding for each element of the domain, so the elements must be known
/// before the run: those of an enumeration, of an interval such as `{1 : 4}`, of Boolean, or the constants of an
/// abstract domain; at least one, and at most 4096.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Robot = {ROB1 | ROB2}
///   monitored wants: Robot -> Boolean
///   monitored level: Integer -> Integer
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
/// subscribe = { "ROB1/wants" = "std_msgs/Bool", "ROB2/wants" = "std_msgs/Bool", "level" = "std_msgs/Int32" }
///
/// [components.Coordinator.bind.monitored]
/// "wants($r)" = { topic = "$r/wants" }
/// "level($n)" = { topic = "level" }
///
/// [[promote]]
/// topic = "ROB1/wants"
/// as = "ROB1/wants"
///
/// [[promote]]
/// topic = "ROB2/wants"
/// as = "ROB2/wants"
///
/// [[promote]]
/// topic = "level"
/// as = "level"
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
/// subscribe = { "ROB1/wants" = "std_msgs/Bool", "ROB2/wants" = "std_msgs/Bool", "level" = "std_msgs/Int32" }
///
/// [components.Coordinator.bind.monitored]
/// "wants($r)" = { topic = "$r/wants" }
/// "level(1)" = { topic = "level" }
///
/// [[promote]]
/// topic = "ROB1/wants"
/// as = "ROB1/wants"
///
/// [[promote]]
/// topic = "ROB2/wants"
/// as = "ROB2/wants"
///
/// [[promote]]
/// topic = "level"
/// as = "level"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C141, error)]
#[error("`${variable}` cannot stand for the elements of `{}`", parameter.name)]
pub(crate) struct UnlistedDomain {
    pub variable: String,
    pub parameter: ParameterInfo,
    pub at: Span,
    pub declared: Span,
}

impl Finding for UnlistedDomain {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let reason = match &self.parameter.elements {
            Some(elements) if elements.is_empty() => "has no elements before the run",
            Some(_) => "gives too many locations together with the other variables",
            None => "is not finite, too large, or not known before the run",
        };
        diagnostic
            .label(self.at, "bound here")
            .label(self.declared, format!("`{}` {reason}", self.parameter.name))
            .help("bind single locations such as `\"level(1)\"`, or use a domain with listed elements")
    }
}
