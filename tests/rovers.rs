//! Instances of two elements: rovers, each with a driver.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::processes::{Running, queues};

const ROVERS: &str = r#"
schema = "composite/1"
[composite]
name = "rovers"
[components.Rover]
for = "$n in 1..3"
implementation = { asm = "rover.asm" }
task = { period_ms = 100 }
subscribe = { arrived = "std_msgs/Bool" }
publish = { go = "std_msgs/Bool" }
rename = { arrived = "r$n/arrived", go = "r$n/go" }
bind.monitored = { arrived = { topic = "arrived", map = "data", none = false } }
bind.out = { go = { topic = "go", field = "data" } }
[components.Driver]
for = [{ n = 1, p = 100 }, { n = 2, p = 100 }, { n = 3, p = THIRD }]
implementation = { asm = "driver.asm" }
task = { period_ms = "$p" }
subscribe = { asked = "std_msgs/Bool" }
publish = { there = "std_msgs/Bool" }
rename = { asked = "r$n/go", there = "r$n/arrived" }
bind.monitored = { asked = { topic = "asked", map = "data", none = false } }
bind.out = { there = { topic = "there", field = "data" } }
"#;

const ROVER: &str = "asm rover
import StandardLibrary
import CTLLibrary
signature:
	enum domain Mode = {IDLE | DRIVING | STOPPED}
	controlled mode: Mode
	monitored arrived: Boolean
	out go: Boolean
definitions:
	CTLSPEC ag(mode != STOPPED)
	main rule r_Main =
		if arrived then mode := STOPPED
		else par mode := DRIVING go := true endpar endif
default init s0:
	function mode = IDLE
	function go = false
";

const DRIVER: &str = "asm driver
import StandardLibrary
signature:
	monitored asked: Boolean
	out there: Boolean
definitions:
	main rule r_Main = if asked then there := true endif
default init s0:
	function there = false
";

/// Writes the composite, with this period of the third driver in ms and a change of its text. Returns its path.
pub(super) fn write(folder: &Path, third: &str, change: impl FnOnce(String) -> String) -> PathBuf {
    std::fs::write(folder.join("rover.asm"), ROVER).unwrap();
    std::fs::write(folder.join("driver.asm"), DRIVER).unwrap();
    let path = folder.join("rovers.composite.toml");
    std::fs::write(&path, change(ROVERS.replace("THIRD", third))).unwrap();
    path
}

/// Instances share the bindings of their element; each still has topics of its own on the broker.
#[test]
fn instances_in_several_processes_reach_their_partners() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = write(folder.path(), "100", |text| {
        text + r#"
[deploy]
processes = [
  { name = "rovers", components = ["Rover1", "Rover2", "Rover3"] },
  { name = "drivers", components = ["Driver1", "Driver3"] },
  { name = "other", components = ["Driver2"] },
]
"#
    });
    let process = |name, seconds| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.arg("run").arg(&composite);
        command.args(["--bus", &vhost.url(), "--process", name]);
        command.args(["--json", "--for", seconds]);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let rovers = |seconds| {
        let mut command = process("rovers", seconds);
        let command = command.args(["--until", "mode=STOPPED"]);
        let output = command.stdout(Stdio::piped()).output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stdout).unwrap(),
        )
    };
    let _drivers = Running::start(&mut process("drivers", "600"));
    queues(&vhost, "robots.services.rovers.control.drivers");
    // the second rover has no driver yet
    let (code, summary) = rovers("4");
    assert_eq!(code, Some(1), "{summary}");
    let states = |of: [&str; 3]| {
        let robots = ["Rover1", "Rover2", "Rover3"].iter().zip(of);
        let shown = robots.map(|(component, state)| {
            format!(r#"{{"component":"{component}","state":"{state}"}}"#)
        });
        shown.collect::<Vec<_>>().join(",")
    };
    let expected = states(["STOPPED", "DRIVING", "STOPPED"]);
    assert!(summary.contains(&expected), "{summary}");
    let _other = Running::start(&mut process("other", "600"));
    let (code, summary) = rovers("60");
    assert_eq!(code, Some(0), "{summary}");
    assert!(summary.contains(&states(["STOPPED"; 3])), "{summary}");
}
