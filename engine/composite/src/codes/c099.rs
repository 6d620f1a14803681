use crate::nearest::Suggest;
use crate::nearest::nearest_name;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown reply
///
/// `keep` names the reply of a call, and `@name` refers to it later. No call keeps a reply under this
/// name.
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
/// GET_MAP = { call = "maps.getMap", with = { name = "office" }, keep = "map", ok = "MAP_OK", failed = "FAILED", timeout = "FAILED", event = "reply" }
/// STOP = { publish = "map", value = "@mpa" }
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
#[code(C099, error)]
#[error("unknown input or reply `@{name}`")]
pub(crate) struct UnknownKept {
    pub name: String,
    pub at: Span,
    pub known: Vec<String>,
    /// The specification has a function of this name.
    pub is_function: bool,
}

impl Finding for UnknownKept {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { name, .. } = self;
        if self.is_function {
            return diagnostic
                .label(self.at, "neither an input nor kept from a reply")
                .help(format!(
                    "write `\"@({name})\"` for the value of the function of the specification"
                ));
        }
        let nearest = nearest_name(name, self.known.iter().map(String::as_str));
        diagnostic
            .label(self.at, "neither an input nor kept from a reply")
            .help("keep the reply of a call with `keep = \"name\"`; write an at sign as `@@`")
            .suggest(self.at, &nearest)
    }
}
