use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

use crate::wording::joined;

/// Proxied operation without a port
///
/// A port-proxy maps the operations that `map` does not list to the ports of its target: an operation with an argument
/// and no result writes an input, one with a result and no argument reads an output. The types determine the port. No
/// port of the target fits this operation, or several do and none of them has its name.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Arm]
/// implementation = { process = "arm" }
/// ports.in = { left = "std_msgs/Float64", right = "std_msgs/Float64" }
///
/// [components.Proxy]
/// implementation = { builtin = "port-proxy", target = "Arm" }
/// services = { settingPeriod = "youbot/SettingPeriod" }
///
/// [[promote]]
/// service = "Proxy.settingPeriod"
/// as = "settingPeriod"
///
/// [[promote]]
/// port = "Arm.left"
/// as = "left"
///
/// [[promote]]
/// port = "Arm.right"
/// as = "right"
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
/// [components.Arm]
/// implementation = { process = "arm" }
/// ports.in = { left = "std_msgs/Float64", right = "std_msgs/Float64" }
///
/// [components.Proxy]
/// implementation = { builtin = "port-proxy", target = "Arm" }
/// services = { settingPeriod = "youbot/SettingPeriod" }
/// map = [{ operation = "settingPeriod.setPeriod", port = "Arm.left", mode = "oneway" }]
///
/// [[promote]]
/// service = "Proxy.settingPeriod"
/// as = "settingPeriod"
///
/// [[promote]]
/// port = "Arm.right"
/// as = "right"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C150, error)]
#[error("{} of `{target}` {} `{operation}`", subject(ports), verb(ports))]
pub(crate) struct UnmappedOperation {
    pub operation: String,
    pub target: String,
    /// The ports that fit; empty or several.
    pub ports: Vec<String>,
    /// Place of the service.
    pub at: Span,
    /// Place of the target.
    pub target_at: Span,
}

fn subject(ports: &[String]) -> String {
    let names: Vec<&str> = ports.iter().map(String::as_str).collect();
    match names.as_slice() {
        [] => "no port".to_owned(),
        names => format!("ports {}", joined(names, "and")),
    }
}

fn verb(ports: &[String]) -> &'static str {
    match ports {
        [] => "fits",
        [_, ..] => "fit",
    }
}

impl Finding for UnmappedOperation {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic
            .label(self.at, "has an operation that `map` does not list")
            .label(self.target_at, "its target");
        match self.ports.first() {
            Some(port) => diagnostic.help(format!(
                "add `{{ operation = \"{}\", port = \"{}.{port}\", mode = \"…\" }}` to `map`",
                self.operation, self.target
            )),
            None => diagnostic.help(
                "list an interface whose operations fit the ports, or map the operation to a part of a message with `field`",
            ),
        }
    }
}
