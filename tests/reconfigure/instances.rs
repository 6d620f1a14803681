//! C18: the number of instances of a component changes while it runs, its properties are watched, and all of it is recorded.

use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::processes::{Running, queues, run_any, through, tool};

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(60);

/// Counts its steps, and the messages that it receives. Each fiftieth step violates a property.
const COUNT: &str = "asm count
import StandardLibrary
import CTLLibrary
signature:
	controlled n: Integer
	monitored told: Integer
	controlled got: Integer
	out shown: Integer
definitions:
	CTLSPEC ag(n mod 50 != 0)
	CTLSPEC ag(ef(n > 100))
	main rule r_Main =
		par
			n := n + 1
			shown := n
			if told != 0 then got := got + 1 endif
		endpar
default init s0:
	function n = 0
	function got = 0
	function shown = 0
";

const HEAD: &str = "asm head
import StandardLibrary
signature:
	out n: Integer
definitions:
	main rule r_Main = n := n + 1
default init s0:
	function n = 0
";

const CREW: &str = r#"
schema = "composite/1"
[composite]
name = "crew"
[properties]
robots = { type = "i64", default = 2, min = 1, max = 50 }
[components.Rover]
for = "$r in 1..${properties.robots}"
implementation = { asm = "count.asm" }
task = { period_ms = 20 }
publish = { "shown$r" = "builtin_interfaces/Time" }
subscribe = { tick = "builtin_interfaces/Time" }
bind.monitored.told = { topic = "tick", receive = "all", field = "sec", none = 0 }
bind.out.shown = { topic = "shown$r", field = "sec", publish = "on_update" }
[components.Head]
implementation = { asm = "head.asm" }
task = { period_ms = 100 }
publish = { tick = "builtin_interfaces/Time" }
bind.out.n = { topic = "tick", field = "sec", publish = "on_update" }
"#;

/// Writes the version with this many rovers, whose specification has the function `laps` in addition if it is the second one.
fn write(folder: &Path, robots: usize, is_second: bool) {
    let composite = CREW.replace("default = 2", &format!("default = {robots}"));
    let count = if is_second {
        COUNT.replace(
            "controlled got: Integer",
            "controlled got: Integer\n\tcontrolled laps: Integer",
        )
    } else {
        COUNT.to_owned()
    };
    for (name, text) in [
        ("crew.composite.toml", &*composite),
        ("count.asm", &count),
        ("head.asm", HEAD),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

/// The coordinators of a recording, as `asmotion replay --json` has them.
fn replayed(file: &str) -> (Option<i32>, Vec<Value>) {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = command.args(["replay", file, "--json"]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let objects = text.lines().map(|line| serde_json::from_str(line).unwrap());
    let objects = objects.filter(|object: &Value| object["type"] == "coordinator");
    (output.status.code(), objects.collect())
}

#[test]
fn c18_instances_are_added_replaced_and_removed_watched_and_recorded() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crew.composite.toml");
    let composite = path.to_str().unwrap();
    let file = folder.path().join("crew.mcap").display().to_string();
    write(folder.path(), 2, false);
    let mut command = through(run_any(&path), &broker, &vhost, None);
    command.args(["--record", &file]).stdout(Stdio::null());
    let running = Running::start(&mut command);
    queues(&vhost, "robots.services.crew.control.crew");
    let becomes = |robots, is_second, expected: &str| {
        write(folder.path(), robots, is_second);
        let (code, out, err) = tool(&broker, &url, &["reconfigure", composite]);
        assert_eq!((code, &*out), (Some(0), expected), "{err}");
    };
    // the property is violated again and again: more often while it is waited for
    let violates = |component: &str| {
        let until = Instant::now() + LONG;
        loop {
            let (_, out, err) = tool(&broker, &url, &["component", "info", component]);
            if out.contains("  violated    ag(n mod 50 != 0) by ") {
                assert!(out.contains("  unwatched   ag(ef(n > 100)): "), "{out}");
                return;
            }
            assert!(Instant::now() < until, "{component}: {out}{err}");
        }
    };
    violates("Rover2");
    becomes(3, false, "crew: `Rover3` is added and runs `count.asm`\n");
    violates("Rover3");
    let second = "crew: `Rover1` runs another version of `count.asm`\n\
                  crew: `Rover2` runs another version of `count.asm`\n\
                  crew: `Rover3` runs another version of `count.asm`\n\
                  crew: `laps` begins with its initial value (3 components)\n";
    becomes(3, true, second);
    violates("Rover3");
    becomes(2, true, "crew: `Rover3` is removed\n");
    becomes(3, true, "crew: `Rover3` is added and runs `count.asm`\n");
    violates("Rover3");
    let output = running.interrupt();
    // it was stopped
    assert_eq!(output.status.code(), Some(1), "{output:?}");

    let (code, coordinators) = replayed(&file);
    let results: Vec<_> = coordinators
        .iter()
        .map(|it| (&it["component"], &it["result"], &it["machines"]))
        .collect();
    let equal = Value::from("equal");
    let expected = [("Head", 1), ("Rover1", 2), ("Rover2", 2), ("Rover3", 3)]
        .map(|(name, machines)| (Value::from(name), Value::from(machines)));
    let expected: Vec<_> = expected
        .iter()
        .map(|(name, it)| (name, &equal, it))
        .collect();
    assert_eq!(results, expected, "{coordinators:?}");
    assert_eq!(code, Some(0));
}
