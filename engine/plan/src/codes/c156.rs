use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Queue needed
///
/// A `data` connection keeps the newest message only, and is the default. The specification reads every message of the input, because each is an
/// event of its own (`receive = "all"`) or is for one of several locations (`key`): of the messages between two steps, it would
/// see the last.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Robot = {ROB1 | ROB2}
///   monitored down: Robot -> Boolean
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
/// [components.Monitor]
/// implementation = { process = "monitor" }
/// ports.out = { status = "nav/Event" }
/// activity = { period_ms = 50 }
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// ports.in = { status = "nav/Event" }
///
/// [components.Coordinator.bind.monitored]
/// "down($r)" = { topic = "status", key = { r = "code" }, edge = true }
///
/// [[connections]]
/// from = "Monitor.status"
/// to = "Coordinator.status"
/// policy = { type = "data" }
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
/// [components.Monitor]
/// implementation = { process = "monitor" }
/// ports.out = { status = "nav/Event" }
/// activity = { period_ms = 50 }
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// ports.in = { status = "nav/Event" }
///
/// [components.Coordinator.bind.monitored]
/// "down($r)" = { topic = "status", key = { r = "code" }, edge = true }
///
/// [[connections]]
/// from = "Monitor.status"
/// to = "Coordinator.status"
/// policy = { type = "circular_buffer", size = 64 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C156, warning)]
#[error("`{function}` reads every message of `{to}`, but the connection keeps the last one")]
pub(crate) struct QueueNeeded {
    pub function: String,
    pub to: String,
    pub at: Span,
}

impl Finding for QueueNeeded {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "messages between two steps replace each other")
            .help("write `policy = { type = \"circular_buffer\", size = 64 }`")
    }
}
