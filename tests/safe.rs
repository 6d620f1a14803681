//! The safe value of an output is the last one that others receive, however a process ends: stopped, by a signal, by a fault.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use asmotion_broker::{TestBroker, Vhost};
use serde_json::Value;

use crate::hostile::Peer;
use crate::processes::{Running, queues, tool};
use crate::stranger::python;

/// Gives a permission in every step. Its last step fails, because nothing writes `input`.
const KEEPER: &str = "asm keeper
import StandardLibrary
signature:
	monitored input: Boolean
	controlled n: Integer
	out permit: Boolean
definitions:
	main rule r_Main = par n := n + 1 permit := true if n >= STEPS then if input then skip endif endif endpar
default init s0:
	function n = 0
";

const COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "kept"
[components.Keeper]
implementation = { asm = "keeper.asm" }
activity = { period_ms = 20 }
publish = { permit = "std_msgs/Bool" }
lifecycle = { safe = { permit = { data = false } } }
[components.Keeper.bind.out]
permit = { topic = "permit", field = "data", publish = "every_step" }
[deploy]
processes = [{ name = "near", components = ["Keeper"] }]
"#;

/// The composite, whose component fails in its step number `steps`.
fn composite(folder: &Path, steps: u64) -> PathBuf {
    let keeper = KEEPER.replace("STEPS", &steps.to_string());
    std::fs::write(folder.join("keeper.asm"), keeper).unwrap();
    let composite = folder.join("kept.composite.toml");
    std::fs::write(&composite, COMPOSITE).unwrap();
    composite
}

/// `asmotion run` or `asmotion up` of the composite.
fn start(command: &str, composite: &Path, broker: &TestBroker, vhost: &Vhost<'_>) -> Running {
    let mut process = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    process.arg(command).arg(composite);
    process.args(["--bus", &vhost.url()]);
    process.env("ASMOTION_PASSWORD", broker.password());
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    process.env("PYTHONPATH", package);
    process.env("PYTHONDONTWRITEBYTECODE", "1");
    // no pipe, which a process that outlives `up` would keep open
    process.stdout(Stdio::null()).stderr(Stdio::null());
    Running::start(&mut process)
}

/// The permissions that a stranger hears.
fn permissions(heard: &[Value]) -> Vec<bool> {
    let given = heard.iter().map(|message| &message["content"]["data"]);
    given.map(|it| it.as_bool().unwrap()).collect()
}

/// Waits for permissions after the first `known`.
#[track_caller]
fn is_permitted(peer: &Peer, known: usize) {
    peer.wait_for("kept.permit", |heard| {
        permissions(heard.get(known..).unwrap_or_default()).contains(&true)
    });
}

/// Checks that the last permission is withdrawn. Returns the number of messages.
#[track_caller]
fn is_withdrawn(peer: &Peer) -> usize {
    let withdrawn = |heard: &[Value]| permissions(heard).last() == Some(&false);
    peer.wait_for("kept.permit", withdrawn);
    std::thread::sleep(Duration::from_millis(300));
    let heard = peer.heard("kept.permit");
    assert!(withdrawn(&heard), "{heard:?}");
    heard.len()
}

#[test]
fn the_last_message_of_a_process_that_a_signal_ends_is_the_safe_one() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = composite(folder.path(), u64::MAX >> 1);
    let peer = Peer::start(python, &vhost.url(), &["kept.permit"]);
    let mut known = 0;
    for command in ["run", "up"] {
        for signal in ["-INT", "-TERM", "-HUP"] {
            let process = start(command, &composite, &broker, &vhost);
            is_permitted(&peer, known);
            process.signal(signal);
            process.end();
            let heard = peer.heard("kept.permit");
            assert!(permissions(&heard[known..]).contains(&true));
            known = is_withdrawn(&peer);
        }
    }
}

#[test]
fn the_last_message_of_a_component_that_is_stopped_is_the_safe_one() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = composite(folder.path(), u64::MAX >> 1);
    let peer = Peer::start(python, &vhost.url(), &["kept.permit"]);
    let process = start("run", &composite, &broker, &vhost);
    queues(&vhost, "robots.services.kept.control.");
    is_permitted(&peer, 0);
    let url = vhost.url();
    let order = |order| {
        let (code, _, said) = tool(&broker, &url, &["component", order, "Keeper"]);
        assert_eq!(code, Some(0), "{said}");
    };
    order("stop");
    let known = is_withdrawn(&peer);
    order("start");
    is_permitted(&peer, known);
    process.interrupt();
}

#[test]
fn the_last_message_of_a_component_that_fails_is_the_safe_one() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = composite(folder.path(), 100);
    let peer = Peer::start(python, &vhost.url(), &["kept.permit"]);
    let process = start("run", &composite, &broker, &vhost);
    is_permitted(&peer, 0);
    assert_eq!(process.end().status.code(), Some(3));
    is_withdrawn(&peer);
}

/// A program that gives a permission in every cycle, and fails in the one of this number.
const PROGRAM: &str = r#"
import asmotion

@asmotion.message("std_msgs/Bool")
class Permission:
    data: bool = False

class Keeper(asmotion.Component):
    """Gives a permission."""
    permit = asmotion.Out(Permission, "whether to move", safe=Permission(False))

    def __init__(self):
        self.cycles = 0

    def update(self, cycle):
        self.cycles += 1
        self.permit.write(Permission(True))
        if self.cycles == FAILS:
            raise RuntimeError("broken")

asmotion.run(Keeper)
"#;

/// The composite with the program, which fails in its cycle number `fails`.
fn composite_of_program(folder: &Path, fails: &str) -> PathBuf {
    let program = PROGRAM.replace("FAILS", fails);
    std::fs::write(folder.join("keeper.py"), program).unwrap();
    let text = r#"schema = "composite/1"
[composite]
name = "kept"
[components.Keeper]
implementation = { process = ["python3", "keeper.py"] }
activity = { period_ms = 20 }
publish = { permit = "std_msgs/Bool" }
[[promote]]
topic = "permit"
as = "permit"
"#;
    let composite = folder.join("kept.composite.toml");
    std::fs::write(&composite, text).unwrap();
    composite
}

#[test]
fn the_last_message_of_a_program_is_the_safe_one_however_it_ends() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let peer = Peer::start(python, &vhost.url(), &["kept.permit"]);
    let mut known = 0;
    let composite = composite_of_program(folder.path(), "-1");
    for signal in ["-INT", "-TERM", "-HUP"] {
        let process = start("run", &composite, &broker, &vhost);
        is_permitted(&peer, known);
        process.signal(signal);
        process.end();
        known = is_withdrawn(&peer);
    }
    let process = start("run", &composite, &broker, &vhost);
    is_permitted(&peer, known);
    queues(&vhost, "robots.services.kept.control.");
    let (code, _, said) = tool(&broker, &vhost.url(), &["component", "stop", "Keeper"]);
    assert_eq!(code, Some(0), "{said}");
    known = is_withdrawn(&peer);
    process.interrupt();
    let composite = composite_of_program(folder.path(), "50");
    let process = start("run", &composite, &broker, &vhost);
    is_permitted(&peer, known);
    is_withdrawn(&peer);
    process.interrupt();
}

/// Writes its cycles, and when it stops how many there were; then the engine adds the safe value.
const COUNTER: &str = r#"
import asmotion
from asmotion import i64

@asmotion.message("test/Count")
class Count:
    cycles: i64 = 0
    last: i64 = 0

class Counter(asmotion.Component):
    """Counts."""
    count = asmotion.Out(Count, "cycles so far")

    def __init__(self):
        self.cycles = 0

    def update(self, cycle):
        self.cycles += 1
        self.count.write(Count(self.cycles, 0))

    def stop(self, cycle):
        self.count.write(Count(self.cycles, 1))

asmotion.run(Counter)
"#;

#[test]
fn a_program_has_a_last_cycle_in_which_it_writes() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("counter.py"), COUNTER).unwrap();
    let composite = folder.path().join("counted.composite.toml");
    let text = r#"schema = "composite/1"
[composite]
name = "counted"
[components.Counter]
implementation = { process = ["python3", "counter.py"] }
activity = { period_ms = 100 }
"#;
    std::fs::write(&composite, text).unwrap();
    let table = folder.path().join("count.csv");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(&composite).args(["--for", "1"]);
    command
        .args(["--ports", "Counter.count", "--record"])
        .arg(&table);
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    command.env("PYTHONPATH", package);
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = std::fs::read_to_string(&table).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|row| row.split(',').collect()).collect();
    let of = |row: &[&str], name: &str| {
        let at = rows[0].iter().position(|column| column.ends_with(name));
        row[at.unwrap()].to_owned()
    };
    let [.., before, last] = &*rows else {
        panic!("{text}");
    };
    assert_eq!(
        (of(before, "last"), of(last, "last")),
        ("0".into(), "1".into()),
        "{text}"
    );
    assert_eq!(of(before, "cycles"), of(last, "cycles"), "{text}");
}
