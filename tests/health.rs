//! A specification that reacts to the state of the bus: it orders a safe stop when the broker is gone, and continues
//! when it is back.

use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

const CAREFUL: &str = "
asm careful
import StandardLibrary
import CommonBehavior
signature:
	enum domain Mode = {STARTING | GOING | HALTED | RESUMED}
	enum domain Command = {GO | HALT}
	monitored broker: String
	controlled mode: Mode
	controlled reachable: Boolean
	out command: Command
definitions:
	main rule r_Main =
		par
			reachable := communicatorStatus(communicator) = AVAILABLE
			if broker = \"UP\" then
				par
					if mode = STARTING then mode := GOING endif
					if mode = HALTED then mode := RESUMED endif
					if mode != GOING then command := GO endif
				endpar
			else
				if mode = GOING then
					par mode := HALTED command := HALT endpar
				endif
			endif
		endpar
default init s0:
	function mode = STARTING
	function reachable = true
";

const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "careful"

[components.Coordinator]
implementation = { asm = "careful.asm", main = "r_Main" }
task = { id = "coordinator", period_ms = 20 }
subscribe = { bus = "bus/Health" }
ports.out = { command = "std_msgs/String" }
[components.Coordinator.bind.monitored]
broker = { topic = "bus", receive = "last", field = "state", none = "UP" }
[components.Coordinator.bind.out]
command = { topic = "command" }

[[connections]]
from = "Coordinator.command"
to = "topic:command"
policy = { type = "data" }
"#;

fn write(folder: &Path) -> std::path::PathBuf {
    std::fs::write(folder.join("careful.asm"), CAREFUL).unwrap();
    let composite = folder.join("careful.composite.toml");
    std::fs::write(&composite, COMPOSITE).unwrap();
    composite
}

fn run(composite: &Path, until: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite);
    command.args(["--json", "--for", "60", "--until", until]);
    command
}

/// The updates in a line of the run's output: location and value.
fn updates(line: &str) -> Vec<(String, String)> {
    let line: Value = serde_json::from_str(line).unwrap();
    let updates = line["step"]["updates"].as_array().into_iter().flatten();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    updates
        .map(|update| (text(&update["location"]), text(&update["after"])))
        .filter(|(location, _)| ["mode", "reachable", "command"].contains(&location.as_str()))
        .collect()
}

#[test]
fn without_a_broker_the_bus_is_up() {
    let folder = tempfile::tempdir().unwrap();
    let composite = write(folder.path());
    let output = run(&composite, "mode=GOING").output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
}

#[test]
fn it_stops_when_the_broker_dies_and_goes_on_when_it_is_back() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut command = run(&write(folder.path()), "mode=RESUMED");
    command.args(["--bus", &vhost.url()]).stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut all: Vec<(String, String)> = Vec::new();
    let has = |all: &[(String, String)], location: &str, value: &str| {
        let last = all.iter().rfind(|(known, _)| known == location);
        last.is_some_and(|(_, known)| known == value)
    };
    for line in lines {
        let updates = updates(&line.unwrap());
        let to = |mode: &str| updates.contains(&("mode".to_owned(), mode.to_owned()));
        if to("GOING") {
            broker.kill().unwrap();
        }
        if to("HALTED") {
            broker.revive().unwrap();
        }
        // a broker that has just started may be slow again on a loaded machine
        if !(has(&all, "mode", "RESUMED") && has(&all, "reachable", "true")) {
            all.extend(updates);
        }
    }
    assert_eq!(child.wait().unwrap().code(), Some(0), "{all:?}");
    let of = |name: &str| -> Vec<&str> {
        let these = all.iter().filter(|(location, _)| location == name);
        let mut values: Vec<_> = these.map(|(_, value)| value.as_str()).collect();
        values.dedup();
        values
    };
    assert_eq!(of("mode"), ["GOING", "HALTED", "RESUMED"]);
    assert_eq!(of("command"), ["GO", "HALT", "GO"]);
    assert_eq!(of("reachable"), ["true", "false", "true"]);
}
