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

/// Turns two functions on and off together, and a third one by itself; moves on with one of two velocities.
const TOGETHER: &str = "asm together
import StandardLibrary
signature:
	domain Lamp subsetof Integer
	controlled n: Integer
	out isOn: Boolean
	out isWarm: Boolean
	out lamp: Lamp -> Boolean
	out speed: Real
	out turn: Real
definitions:
	domain Lamp = {1 : 3}
	main rule r_Main = par
		n := (n + 1) mod 4
		isOn := (n < 2)
		isWarm := (n < 2)
		if n = 0 then par lamp(1) := true lamp(3) := true endpar endif
		if n = 2 then lamp(3) := false endif
		if n = 0 then par speed := 1.0 turn := 2.0 endpar endif
		if n = 2 then speed := 3.0 endif
	endpar
default init s0:
	function n = 0
	function isOn = false
	function isWarm = false
	function lamp($l in Lamp) = false
	function speed = 0.0
	function turn = 0.0
";

/// Reads the fields that were written together.
const TOGETHER_READER: &str = "asm together_reader
import StandardLibrary
signature:
	monitored isOn: Boolean
	monitored isWarm: Boolean
	monitored first: Boolean
	monitored third: Boolean
	monitored speed: Real
	monitored turn: Real
	monitored arrived: Boolean
	controlled on: Boolean
	controlled warm: Boolean
	controlled lamps: Boolean
	controlled half: Boolean
	controlled messages: Integer
	controlled v: Real
	controlled w: Real
definitions:
	invariant inv_together over on, warm: on = warm
	main rule r_Main = par
		if isDef(isOn) then on := isOn endif
		if isDef(isWarm) then warm := isWarm endif
		if first and third then lamps := true endif
		if first and not third then half := true endif
		if isDef(speed) then v := speed endif
		if isDef(turn) then w := turn endif
		if arrived then messages := messages + 1 endif
	endpar
default init s0:
	function on = false
	function warm = false
	function lamps = false
	function half = false
	function messages = 0
	function v = 0.0
	function w = 0.0
";

const TOGETHER_COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "together"
types = "types.toml"
[components.Writer]
implementation = { asm = "together.asm" }
activity = { period_ms = 100 }
publish = { lights = "test/Lights", twist = "geometry_msgs/Twist" }
[components.Writer.bind.out]
isOn = { topic = "lights", field = "on" }
speed = { topic = "twist", field = "linear.x" }
"lamp($l)" = { topic = "lights", field = "lamp.n$l" }
isWarm = { topic = "lights", field = "warm" }
turn = { topic = "twist", field = "angular.z" }
[components.Reader]
implementation = { asm = "together_reader.asm" }
activity = { period_ms = 50 }
subscribe = { lights = "test/Lights", twist = "geometry_msgs/Twist" }
[components.Reader.bind.monitored]
isOn = { topic = "lights", field = "on" }
isWarm = { topic = "lights", field = "warm" }
first = { topic = "lights", field = "lamp.n1", none = false }
third = { topic = "lights", field = "lamp.n3", none = false }
speed = { topic = "twist", field = "linear.x" }
turn = { topic = "twist", field = "angular.z" }
arrived = { topic = "twist", edge = true }
"#;

const TOGETHER_TYPES: &str = r#"schema = "composite-types/1"
[type."test/Lights"]
fields = { on = "bool", warm = "bool", lamp = "test/Lamps" }
[type."test/Lamps"]
fields = { n1 = "bool", n2 = "bool", n3 = "bool" }
"#;

const TOGETHER_MISSION: &str = r#"schema = "mission/1"
composite = "together.composite.toml"
limit_s = 1
[[expect]]
doc = "the fields of a message belong to one step"
never = "Reader.on and not Reader.warm"
[[expect]]
doc = "elements of a pattern too"
eventually = "Reader.lamps"
[[expect]]
doc = "what a step does not update keeps its value"
eventually = "Reader.half and Reader.v = 3.0 and Reader.w = 2.0"
[[expect]]
doc = "no velocity has the other one missing"
never = "Reader.v > 0.0 and Reader.w = 0.0"
[[expect]]
doc = "one message for a step"
eventually = "Reader.messages = 2"
[[expect]]
never = "Reader.messages > 5"
"#;

#[test]
fn out_functions_that_are_fields_of_a_topic_are_sent_in_one_message() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("together.asm", TOGETHER),
        ("together_reader.asm", TOGETHER_READER),
        ("types.toml", TOGETHER_TYPES),
        ("together.composite.toml", TOGETHER_COMPOSITE),
        ("together.mission.toml", TOGETHER_MISSION),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let asmotion = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        let output = command.args(args).current_dir(folder.path()).output();
        let output = output.unwrap();
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(output.status.success(), "{text}");
    };
    asmotion(&["check", "together.composite.toml"]);
    asmotion(&["test", "together.mission.toml"]);
}

/// As `TOGETHER`, with values that can be listed.
const PAIR: &str = "asm pair
import StandardLibrary
signature:
	controlled isOff: Boolean
	out isOn: Boolean
	out isWarm: Boolean
definitions:
	main rule r_Main = par
		isOff := not isOff
		isOn := isOff
		isWarm := isOff
	endpar
default init s0:
	function isOff = true
	function isOn = false
	function isWarm = false
";

const PAIR_READER: &str = "asm pair_reader
import StandardLibrary
signature:
	monitored isOn: Boolean
	monitored isWarm: Boolean
	controlled on: Boolean
	controlled warm: Boolean
definitions:
	invariant inv_together over on, warm: on = warm
	main rule r_Main = par
		if isDef(isOn) then on := isOn endif
		if isDef(isWarm) then warm := isWarm endif
	endpar
default init s0:
	function on = false
	function warm = false
";

const PAIR_COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "pair"
types = "types.toml"
[components.Writer]
implementation = { asm = "pair.asm" }
activity = { period_ms = 100 }
publish = { lights = "test/Lights" }
[components.Writer.bind.out]
isOn = { topic = "lights", field = "on" }
isWarm = { topic = "lights", field = "warm" }
[components.Reader]
implementation = { asm = "pair_reader.asm" }
activity = { period_ms = 50 }
subscribe = { lights = "test/Lights" }
[components.Reader.bind.monitored]
isOn = { topic = "lights", field = "on" }
isWarm = { topic = "lights", field = "warm" }
"#;

#[test]
fn fields_that_are_sent_in_one_message_are_verified_as_one() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("pair.asm", PAIR),
        ("pair_reader.asm", PAIR_READER),
        ("types.toml", TOGETHER_TYPES),
        ("pair.composite.toml", PAIR_COMPOSITE),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let verify = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.args(["verify", "pair.composite.toml", "--component", "Reader"]);
        let output = command.current_dir(folder.path()).output().unwrap();
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        (output.status.code(), text)
    };
    let (code, text) = verify();
    assert_eq!(code, Some(0), "{text}");
    // each value in a message of its own is another robot
    let apart = PAIR.replace("isWarm := isOff", "if isOff then isWarm := isOff endif");
    std::fs::write(folder.path().join("pair.asm"), apart).unwrap();
    let (code, text) = verify();
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("inv_together"), "{text}");
}
