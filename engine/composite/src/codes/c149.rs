use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

use crate::wording::joined;

/// Literal that no binding yields
///
/// The specification compares an input with this literal, but neither the outcomes of calls nor the constants that the
/// composite binds the function to yield it, and nothing in the specification does. A rule that waits for it waits
/// for ever.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Event = {PLANNED | NO_PATH}
///   enum domain Action = {PLAN | HALT}
///   monitored event: Event
///   out action: Action
/// definitions:
///   main rule r_Main = if event = NO_PATH then action := HALT else action := PLAN endif
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
/// references.planner = { interface = "planner.Planner" }
/// publish = { halt = "std_msgs/Bool" }
///
/// [components.Coordinator.bind.out.action]
/// PLAN = { call = "planner.plan", ok = "PLANNED", event = "event" }
/// HALT = { publish = "halt", value = { data = true } }
///
/// [[promote]]
/// reference = "Coordinator.planner"
/// as = "planner"
///
/// [[promote]]
/// topic = "halt"
/// as = "halt"
/// ```
///
/// Corrected, with a literal for the fault:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// references.planner = { interface = "planner.Planner" }
/// publish = { halt = "std_msgs/Bool" }
///
/// [components.Coordinator.bind.out.action]
/// PLAN = { call = "planner.plan", ok = "PLANNED", failed = "NO_PATH", event = "event" }
/// HALT = { publish = "halt", value = { data = true } }
///
/// [[promote]]
/// reference = "Coordinator.planner"
/// as = "planner"
///
/// [[promote]]
/// topic = "halt"
/// as = "halt"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C149, warning)]
#[error("no binding of `{function}` yields `{literal}`")]
pub(crate) struct LiteralWithoutSource {
    pub literal: String,
    pub function: String,
    /// The literals that its bindings yield.
    pub yields: Vec<String>,
    /// Place of the first binding.
    pub at: Span,
    /// Location of the first comparison.
    pub compared: Span,
}

impl Finding for LiteralWithoutSource {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let yields: Vec<&str> = self.yields.iter().map(String::as_str).collect();
        diagnostic
            .label(self.at, format!("yields {}", joined(&yields, "and")))
            .label(self.compared, "compared with it here")
            .help(format!(
                "name `{}` for an outcome of a call, or remove what depends on it",
                self.literal
            ))
    }
}
