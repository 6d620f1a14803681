//! A message with a part of its fields has the initial values of the others for every reader, whoever writes it.

use std::process::Command;

/// Reads two fields of a twist, publishes a copy of one of them, and notes that a twist without rotation arrived.
const READER: &str = "asm reader
import StandardLibrary
signature:
	monitored v: Real
	monitored w: Real
	monitored drives: Boolean
	controlled vKept: Real
	controlled wKept: Real
	controlled hasDriven: Boolean
	out copy: Boolean
definitions:
	main rule r_Main = par
		if isDef(v) then vKept := v endif
		if isDef(w) then wKept := w endif
		if isDef(w) then copy := true endif
		if drives then hasDriven := true endif
	endpar
default init s0:
	function vKept = 7.0
	function wKept = 7.0
	function hasDriven = false
";

/// Reads the copy of the twist.
const COPY_READER: &str = "asm copy_reader
import StandardLibrary
signature:
	monitored w: Real
	controlled wKept: Real
definitions:
	main rule r_Main = if isDef(w) then wKept := w endif
default init s0:
	function wKept = 7.0
";

/// Drives and turns in its second step, and only drives in its eighth.
const WRITER: &str = "asm writer
import StandardLibrary
signature:
	enum domain Command = {TURN | DRIVE}
	controlled n: Integer
	out command: Command
definitions:
	main rule r_Main = par
		n := n + 1
		if n = 2 then command := TURN endif
		if n = 8 then command := DRIVE endif
	endpar
default init s0:
	function n = 0
";

const COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "omitted"
[components.Writer]
implementation = { asm = "writer.asm" }
activity = { period_ms = 100 }
publish = { twist = "geometry_msgs/Twist" }
lifecycle = { safe = { twist = { linear = { x = 0.5 } } } }
[components.Writer.bind.out]
command.TURN = { publish = "twist", value = { linear = { x = 1.0 }, angular = { z = 2.0 } } }
command.DRIVE = { publish = "twist", value = { linear = { x = 3.0 } } }
[components.Reader]
implementation = { asm = "reader.asm" }
activity = { period_ms = 50 }
subscribe = { twist = "geometry_msgs/Twist" }
publish = { copied = "geometry_msgs/Twist" }
[components.Reader.bind.monitored]
v = { topic = "twist", field = "linear.x" }
w = { topic = "twist", field = "angular.z" }
drives = { topic = "twist", edge = true, where = { angular = { z = 0.0 } } }
[components.Reader.bind.out]
copy.true = { publish = "copied", value = { angular = { z = "@twist.angular.z" } } }
[components.CopyReader]
implementation = { asm = "copy_reader.asm" }
activity = { period_ms = 50 }
subscribe = { copied = "geometry_msgs/Twist" }
[components.CopyReader.bind.monitored]
w = { topic = "copied", field = "angular.z" }
"#;

const MISSION: &str = r#"schema = "mission/1"
composite = "omitted.composite.toml"
limit_s = 4
[[at]]
time_s = 1.5
write = "Reader.twist"
value = { angular = { z = 4.0 } }
[[at]]
time_s = 2.5
stop = "Writer"
[[expect]]
doc = "the writer gives both"
eventually = "Reader.vKept = 1.0 and Reader.wKept = 2.0"
[[expect]]
doc = "the writer omits the rotation"
after = "Reader.vKept = 3.0"
until = "Reader.wKept = 4.0"
always = "Reader.wKept = 0.0 and Reader.hasDriven"
within_s = 0.1
[[expect]]
doc = "the mission omits the translation"
after = "Reader.wKept = 4.0"
until = "state(Writer) = Stopped"
always = "Reader.vKept = 0.0"
within_s = 0.1
[[expect]]
doc = "the safe sample omits the rotation"
after = "state(Writer) = Stopped"
always = "Reader.vKept = 0.5 and Reader.wKept = 0.0"
within_s = 0.1
[[expect]]
doc = "contents made from the message have its initial values"
after = "Reader.vKept = 3.0"
until = "Reader.wKept = 4.0"
always = "CopyReader.wKept = 0.0"
within_s = 0.2
"#;

#[test]
fn a_specification_reads_initial_values() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("reader.asm", READER),
        ("copy_reader.asm", COPY_READER),
        ("writer.asm", WRITER),
        ("omitted.composite.toml", COMPOSITE),
        ("omitted.mission.toml", MISSION),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(["test", "omitted.mission.toml"]);
    let output = command.current_dir(folder.path()).output().unwrap();
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(output.status.success(), "{text}");
}
