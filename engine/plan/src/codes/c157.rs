use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Change lost before the start
///
/// Processes start in any order, and a message that is published before its reader has started does not reach it. A value that
/// a specification publishes only when it changes (`publish = "on_change"`) may therefore never reach a reader in another process.
/// With `init = true`, a connection keeps the last message for readers that start later.
///
/// ```asm
/// asm example
/// signature:
///   out command: Boolean
/// definitions:
///   main rule r_Main = command := true
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [brokers.main]
/// url = "amqp://guest:guest@localhost"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// publish = { command = "std_msgs/Bool" }
/// bind.out.command = { topic = "command", publish = "on_change" }
///
/// [components.Driver]
/// implementation = { process = "driver" }
/// subscribe = { command = "std_msgs/Bool" }
///
/// [deploy]
/// processes = [
///   { name = "station", components = ["Coordinator"] },
///   { name = "onboard", components = ["Driver"] },
/// ]
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
/// url = "amqp://guest:guest@localhost"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// ports.out = { command = "std_msgs/Bool" }
/// bind.out.command = { topic = "command", publish = "on_change" }
///
/// [components.Driver]
/// implementation = { process = "driver" }
/// subscribe = { command = "std_msgs/Bool" }
///
/// [[connections]]
/// from = "Coordinator.command"
/// to = "topic:command"
/// policy = { type = "data", init = true }
///
/// [deploy]
/// processes = [
///   { name = "station", components = ["Coordinator"] },
///   { name = "onboard", components = ["Driver"] },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C157, warning)]
#[error("a change of `{output}` is lost if `{reader}` starts later")]
pub(crate) struct ChangeLost {
    pub output: String,
    pub reader: String,
    /// Name of the reader's process.
    pub process: String,
    pub at: Span,
}

impl Finding for ChangeLost {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let label = format!("published once, but read in process `{}`", self.process);
        diagnostic
            .label(self.at, label)
            .help("set `init = true` in the policy of a connection between them, or write `publish = \"every_step\"`")
    }
}
