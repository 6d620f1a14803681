use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong type of argument
///
/// The arguments of a call must match the request type of the operation.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Command = {NOTHING | GET_MAP | STOP}
///   enum domain Reply = {NONE | MAP_OK | FAILED}
///   monitored estop: Boolean
///   monitored reply: Reply
///   controlled tries: Integer
///   out command: Command
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
/// subscribe = { estop = "std_msgs/Bool", event = "nav/Event" }
/// publish = { map = "nav_msgs/OccupancyGrid" }
/// references = { maps = "nav/MapService" }
///
/// [components.Coordinator.bind.monitored]
/// estop = { topic = "estop" }
/// reply = { topic = "event", map = "code", none = "NONE" }
///
/// [components.Coordinator.bind.out.command]
/// GET_MAP = { call = "maps.getMap", with = { name = 5 }, keep = "map", ok = "MAP_OK", failed = "FAILED", timeout = "FAILED", event = "reply" }
/// STOP = { publish = "map", value = "@map" }
///
/// [[promote]]
/// topic = "estop"
/// as = "estop"
///
/// [[promote]]
/// topic = "event"
/// as = "event"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "Coordinator.maps"
/// service = "Map.maps"
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
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { estop = "std_msgs/Bool", event = "nav/Event" }
/// publish = { map = "nav_msgs/OccupancyGrid" }
/// references = { maps = "nav/MapService" }
///
/// [components.Coordinator.bind.monitored]
/// estop = { topic = "estop" }
/// reply = { topic = "event", map = "code", none = "NONE" }
///
/// [components.Coordinator.bind.out.command]
/// GET_MAP = { call = "maps.getMap", with = { name = "office" }, keep = "map", ok = "MAP_OK", failed = "FAILED", timeout = "FAILED", event = "reply" }
/// STOP = { publish = "map", value = "@map" }
///
/// [[promote]]
/// topic = "estop"
/// as = "estop"
///
/// [[promote]]
/// topic = "event"
/// as = "event"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "Coordinator.maps"
/// service = "Map.maps"
/// timeout_ms = 1000
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C100, error)]
#[error("mismatched types: `{what}` takes `{wanted}`, but {given} is {found}")]
pub(crate) struct WrongArgument {
    pub what: String,
    pub wanted: String,
    pub given: String,
    pub found: String,
    pub at: Span,
}

impl Finding for WrongArgument {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "has another type")
            .help(if self.given == "this" {
                "write a value of this type"
            } else {
                "select a part of a message with `@name.field`"
            })
    }
}
