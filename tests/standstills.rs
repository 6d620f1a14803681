//! Standstills: of a process that reads a message queue, and of the reader of a run's output.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use asmotion_ros_domain::{CycloneNode, TopicPolicies, domain};
use asmotion_ros_master::Master;
use asmotion_skip::PYTHON;
use serde_json::{Value, json};

use crate::processes::{run_any, through, tool};

/// Time for everything on a loaded machine.
const LONG: Duration = Duration::from_secs(60);

/// A specification that shows each number it reads.
const DRIVER: &str = "asm driver
import StandardLibrary
signature:
	monitored command: Integer
	monitored lost: Integer
	controlled number: Integer
	controlled missed: Integer
definitions:
	main rule r_Main =
		par
			if command > 0 then number := command endif
			if lost > 0 then missed := missed + lost endif
		endpar
default init s0:
	function number = 0
	function missed = 0
";

/// A specification with a step in each millisecond.
const CHATTER: &str = "asm chatter
import StandardLibrary
signature:
	controlled n: Integer
	controlled about: String
definitions:
	main rule r_Main = par n := n + 1 about := \"TEXT\" + toString(n) endpar
default init s0:
	function n = 0
	function about = \"\"
";

fn write(folder: &Path, name: &str, specification: &str, composite: &str) -> PathBuf {
    std::fs::write(folder.join(format!("{name}.asm")), specification).unwrap();
    let path = folder.join(format!("{name}.composite.toml"));
    std::fs::write(&path, composite).unwrap();
    path
}

/// A process that is killed at the end of the test.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The updates of a location according to the output of a run.
fn updates(lines: &[Value], location: &str) -> Vec<u64> {
    let all = lines
        .iter()
        .filter_map(|line| line["step"]["updates"].as_array());
    let of_location = all
        .flatten()
        .filter(|update| update["location"] == location);
    let after = of_location.map(|update| update["after"].as_str().unwrap().parse().unwrap());
    after.collect()
}

#[test]
fn commands_that_waited_in_a_queue_for_a_stopped_driver_are_discarded_and_counted() {
    if Command::new("python3").arg("--version").output().is_err() {
        PYTHON.skip();
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let queue = format!("/asmotion-standstill-{}", std::process::id());
    let composite = format!(
        r#"schema = "composite/1"
[composite]
name = "driven"
[components.Driver]
implementation = {{ asm = "driver.asm" }}
activity = {{ period_ms = 5 }}
ports.in = {{ command = "builtin_interfaces/Time" }}
[components.Driver.bind.monitored]
command = {{ topic = "command", receive = "all", field = "sec", none = 0 }}
lost    = {{ lost = "command" }}
[[connections]]
from = "mqueue:{queue}"
to = "Driver.command"
policy = {{ type = "buffer", size = 100, max_age_ms = 500, on_stale = "no_data" }}
"#
    );
    let composite = write(folder.path(), "driver", DRIVER, &composite);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/standstills/commander.py");
    let mut command = run_any(&composite);
    command.args(["--clock", "wall"]).stderr(Stdio::null());
    let mut driver = Killed(command.spawn().unwrap());
    let mut commander = Command::new("python3");
    let commander = commander.arg(script).arg(&queue).stdin(Stdio::null());
    let _commander = Killed(commander.spawn().unwrap());
    let mut lines = BufReader::new(driver.0.stdout.take().unwrap()).lines();
    let mut read: Vec<Value> = Vec::new();
    let mut until = |read: &mut Vec<Value>, count: usize| {
        let begun = Instant::now();
        while updates(read, "number").len() < count {
            assert!(begun.elapsed() < LONG, "{read:?}");
            let line = lines.next().unwrap().unwrap();
            read.push(serde_json::from_str(&line).unwrap());
        }
    };
    let signal = |signal: &str, driver: &Killed| {
        let pid = driver.0.id().to_string();
        let status = Command::new("kill").args([signal, &pid]).status();
        assert!(status.unwrap().success());
    };
    until(&mut read, 10);
    signal("-STOP", &driver);
    std::thread::sleep(Duration::from_secs(3));
    signal("-CONT", &driver);
    let known = updates(&read, "number").len();
    until(&mut read, known + 30);
    // a command each 100 ms, and a queue of 10, which is full after a second: 10 waited for at least 2 s
    let numbers = updates(&read, "number");
    let gap = |pair: &[u64]| pair[1] - pair[0] - 1;
    let missing = numbers.windows(2).map(gap).max().unwrap();
    assert!((8..=12).contains(&missing), "{numbers:?}");
    let missed = updates(&read, "missed").last().copied();
    assert_eq!(
        missed,
        Some(numbers.windows(2).map(gap).sum()),
        "{numbers:?}"
    );
    let reasons = read.iter().filter(|line| line["type"] == "dropped");
    let mut reasons = reasons.filter_map(|line| line["reason"].as_str());
    assert!(reasons.any(|reason| reason.contains("the limit is 500ms")));
}

/// A specification that reads numbers, at most half a second old, from a component of the composite.
struct Fed {
    run: Killed,
    lines: std::io::Lines<BufReader<std::process::ChildStdout>>,
    read: Vec<Value>,
}

impl Fed {
    /// Starts a composite with these tables and the component `Source`, whose output `command` the specification reads.
    fn start(folder: &Path, source: &str, change: impl FnOnce(&mut Command)) -> Self {
        let composite = format!(
            r#"schema = "composite/1"
[composite]
name = "fed"
{source}
[components.Driver]
implementation = {{ asm = "driver.asm" }}
activity = {{ period_ms = 0 }}
ports.in = {{ command = "std_msgs/Int32" }}
[components.Driver.bind.monitored]
command = {{ topic = "command", receive = "all", field = "data", none = 0 }}
lost    = {{ lost = "command" }}
[[connections]]
from = "Source.command"
to = "Driver.command"
policy = {{ type = "buffer", size = 100, max_age_ms = 500, on_stale = "no_data" }}
"#
        );
        let composite = write(folder, "driver", DRIVER, &composite);
        let mut command = run_any(&composite);
        command.args(["--clock", "wall"]).stderr(Stdio::null());
        change(&mut command);
        let mut run = Killed(command.spawn().unwrap());
        let lines = BufReader::new(run.0.stdout.take().unwrap()).lines();
        let read = Vec::new();
        Self { run, lines, read }
    }

    /// Reads until there is a number that is at least this one. Returns all numbers so far.
    fn until(&mut self, number: u64) -> Vec<u64> {
        let begun = Instant::now();
        loop {
            let numbers = updates(&self.read, "number");
            if numbers.last().is_some_and(|last| *last >= number) {
                return numbers;
            }
            assert!(begun.elapsed() < LONG, "{numbers:?}");
            let line = self.lines.next().unwrap().unwrap();
            self.read.push(serde_json::from_str(&line).unwrap());
        }
    }

    /// The number of messages that the specification knows to be lost.
    fn missed(&self) -> u64 {
        updates(&self.read, "missed").last().copied().unwrap_or(0)
    }

    fn signal(&self, signal: &str) {
        let pid = self.run.0.id().to_string();
        let status = Command::new("kill").args([signal, &pid]).status();
        assert!(status.unwrap().success());
    }
}

/// Sends numbers to a process that is stopped in between, and checks that it uses only those that are new when it goes on.
fn assert_nothing_old(fed: &mut Fed, mut send: impl FnMut(u64)) {
    for number in 1..=3 {
        send(number);
        assert_eq!(fed.until(number).last(), Some(&number));
    }
    fed.signal("-STOP");
    std::thread::sleep(Duration::from_millis(500));
    for number in 4..=8 {
        send(number);
    }
    std::thread::sleep(Duration::from_secs(3));
    fed.signal("-CONT");
    // what waited is there at once, and this is sent later
    std::thread::sleep(Duration::from_millis(500));
    send(9);
    assert_eq!(fed.until(9), [1, 2, 3, 9]);
    send(10);
    fed.until(10);
    assert_eq!(fed.missed(), 5);
}

#[test]
fn what_waited_at_a_bridge_to_ros_1_during_a_standstill_is_discarded_and_counted() {
    let Some(master) = Master::start() else {
        return;
    };
    let source = r#"[bridges.ros]
kind = "ros1"
master = "${ROS_MASTER_URI}"
[components.Source]
implementation = { builtin = "ros-bridge", bridge = "ros" }
activity = { period_ms = 0 }
ports.out = { command = "std_msgs/Int32" }
map = [{ from = "command", ros = "/command", type = "std_msgs/Int32", direction = "from_ros" }]"#;
    let folder = tempfile::tempdir().unwrap();
    let mut fed = Fed::start(folder.path(), source, |command| {
        command.env("ROS_MASTER_URI", master.uri());
    });
    let mut operator = master.rospy("/operator");
    let (topic, kind) = ("/command", "std_msgs/Int32");
    operator.advertise(topic, kind, 1);
    assert_nothing_old(&mut fed, |number| {
        operator.publish(topic, kind, json!({ "data": number }));
    });
}

/// RustDDS ends its threads when a wait of theirs is interrupted, so the bridge joins again by itself.
#[test]
fn a_bridge_to_ros_2_joins_again_after_a_standstill() {
    let Some(python) = asmotion_ros_domain::python() else {
        return;
    };
    let source = r#"[bridges.ros]
kind = "ros2"
[components.Source]
implementation = { builtin = "ros-bridge", bridge = "ros" }
activity = { period_ms = 0 }
ports.out = { command = "std_msgs/Int32" }
ports.in = { limit = "std_msgs/Int32" }
map = [
  { from = "command", ros = "/command", type = "std_msgs/Int32", direction = "from_ros" },
  { from = "limit", ros = "/limit", type = "std_msgs/Int32", direction = "to_ros", qos = { depth = 1, durability = "transient_local" } },
]
[components.Limit]
implementation = { asm = "limit.asm" }
activity = { period_ms = 20 }
ports.out = { limit = "std_msgs/Int32" }
[components.Limit.bind.out]
limit = { topic = "limit", field = "data", publish = "on_update" }
[[connections]]
from = "Limit.limit"
to = "Source.limit""#;
    let limit = "asm limit
import StandardLibrary
signature:
	controlled said: Boolean
	out limit: Integer
definitions:
	main rule r_Main = if not said then par said := true limit := 7 endpar endif
default init s0:
	function said = false
";
    let (folder, domain) = (tempfile::tempdir().unwrap(), domain());
    std::fs::write(folder.path().join("limit.asm"), limit).unwrap();
    let mut fed = Fed::start(folder.path(), source, |command| {
        command
            .env("ROS_DOMAIN_ID", domain.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env_remove("ROS_LOCALHOST_ONLY");
    });
    let kind = "std_msgs/Int32";
    let mut operator = CycloneNode::start(&python, domain, "operator");
    operator.subscribe("/limit", kind, TopicPolicies::latched(1));
    assert_eq!(operator.message("/limit"), json!({"data": 7}));
    operator.advertise("/command", kind, TopicPolicies::default(), 1);
    for number in 1..=3 {
        operator.publish("/command", &json!({ "data": number }));
        assert_eq!(fed.until(number).last(), Some(&number));
    }
    fed.signal("-STOP");
    std::thread::sleep(Duration::from_secs(1));
    fed.signal("-CONT");
    // what is sent before it has joined again does not come
    operator.stream("/command", &json!({"data": 0}), ("data", 4), 10);
    let numbers = fed.until(4);
    assert!(numbers.is_sorted_by(|one, next| one < next), "{numbers:?}");
    // a latched message reaches subscribers that come after the standstill
    let mut late = CycloneNode::start(&python, domain, "late");
    late.subscribe("/limit", kind, TopicPolicies::latched(1));
    assert_eq!(late.message("/limit"), json!({"data": 7}));
}

#[test]
fn what_a_program_kept_for_a_process_that_stood_still_is_discarded_and_counted() {
    if Command::new("python3").arg("--version").output().is_err() {
        PYTHON.skip();
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let script = root.join("tests/standstills/feeder.py");
    let source = format!(
        "[components.Source]
implementation = {{ process = [\"python3\", {script:?}] }}
activity = {{ period_ms = 0 }}
ports.out = {{ command = \"std_msgs/Int32\" }}"
    );
    let folder = tempfile::tempdir().unwrap();
    let mut fed = Fed::start(folder.path(), &source, |command| {
        command.env("PYTHONPATH", root.join("python"));
        command.env("PYTHONDONTWRITEBYTECODE", "1");
    });
    let before = *fed.until(10).last().unwrap();
    fed.signal("-STOP");
    std::thread::sleep(Duration::from_secs(3));
    fed.signal("-CONT");
    let numbers = fed.until(before + 60);
    let gap = |pair: &[u64]| pair[1] - pair[0] - 1;
    // a number each 100 ms: those of three seconds
    let missing = numbers.windows(2).map(gap).max().unwrap();
    assert!((20..=45).contains(&missing), "{numbers:?}");
    assert_eq!(fed.missed(), numbers.windows(2).map(gap).sum::<u64>());
}

/// What nobody read is not shown as new, and what is missing is said.
#[test]
fn an_echo_whose_output_nobody_reads_shows_the_age_of_what_waited() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
    let composite = r#"schema = "composite/1"
[composite]
name = "talkative"
[components.Chatter]
implementation = { asm = "chatter.asm" }
activity = { period_ms = 20 }
publish = { about = "std_msgs/String" }
[components.Chatter.bind.out]
said = { topic = "about", publish = "every_step" }
"#;
    let specification = CHATTER
        .replace("TEXT", &"many words ".repeat(2000))
        .replace("controlled about", "out said")
        .replace("function about", "function said")
        .replace("about :=", "said :=");
    let composite = write(folder.path(), "chatter", &specification, composite);
    let mut command = through(run_any(&composite), &broker, &vhost, None);
    let run = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let _run = Killed(run.unwrap());
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let mut echo = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let echo = echo
        .args(["topic", "echo", "talkative.about"])
        .env("ASMOTION_BUS", url)
        .env("ASMOTION_PASSWORD", broker.password())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut echo = Killed(echo.spawn().unwrap());
    let mut lines = BufReader::new(echo.0.stdout.take().unwrap()).lines();
    let mut age = || {
        let line: Value = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
        line["age_s"].as_f64()
    };
    // the first message is new, and the pipe has room for three
    assert_eq!(age(), None);
    std::thread::sleep(Duration::from_secs(4));
    let ages: Vec<f64> = (0..100).filter_map(|_| age()).collect();
    let oldest = ages.iter().copied().fold(0.0, f64::max);
    assert!((2.0..10.0).contains(&oldest), "{ages:?}");
    let begun = Instant::now();
    while age().is_some() {
        assert!(begun.elapsed() < LONG);
    }
}

#[test]
fn a_run_whose_output_nobody_reads_goes_on_and_says_what_is_missing() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
    let composite = r#"schema = "composite/1"
[composite]
name = "talkative"
[components.Chatter]
implementation = { asm = "chatter.asm" }
activity = { period_ms = 2 }
"#;
    let specification = CHATTER.replace("TEXT", &"many words ".repeat(300));
    let composite = write(folder.path(), "chatter", &specification, composite);
    let mut command = through(run_any(&composite), &broker, &vhost, None);
    let mut child = command.stderr(Stdio::null()).spawn().unwrap();
    let mut output = child.stdout.take().unwrap();
    let run = Killed(child);
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    // the pipe is full after 64 KiB, and what waits in the process after some seconds
    std::thread::sleep(Duration::from_secs(8));
    let (code, out, err) = tool(&broker, &url, &["component", "list"]);
    assert!(out.contains("Chatter"), "{out}{err}");
    assert_eq!(code, Some(0), "{out}{err}");
    let (code, out, err) = tool(&broker, &url, &["component", "stop", "Chatter"]);
    assert_eq!(code, Some(0), "{out}{err}");
    let pid = run.0.id().to_string();
    let text = std::thread::spawn(move || {
        let mut text = String::new();
        output.read_to_string(&mut text).unwrap();
        text
    });
    std::thread::sleep(Duration::from_secs(1));
    let status = Command::new("kill").args(["-INT", &pid]).status();
    assert!(status.unwrap().success());
    let text = text.join().unwrap();
    let lines: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let lost = lines.iter().filter(|line| line["type"] == "lost_output");
    let lost: u64 = lost.map(|line| line["count"].as_u64().unwrap()).sum();
    let steps = lines.iter().filter(|line| line["type"] == "step").count() as u64;
    let summary = lines.last().unwrap();
    assert_eq!(summary["type"], "summary");
    // reports of overruns are lost as well
    let missing = summary["steps"].as_u64().unwrap() - steps;
    assert!(missing > 0 && lost >= missing, "{steps}, {lost}: {summary}");
    drop(run);
}

#[test]
fn a_run_ends_without_a_reader_of_its_output() {
    let folder = tempfile::tempdir().unwrap();
    let composite = r#"schema = "composite/1"
[composite]
name = "talkative"
[components.Chatter]
implementation = { asm = "chatter.asm" }
activity = { period_ms = 2 }
"#;
    let specification = CHATTER.replace("TEXT", &"many words ".repeat(300));
    let composite = write(folder.path(), "chatter", &specification, composite);
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(&composite);
    command.args(["--json", "--for", "1", "--clock", "wall"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut run = Killed(command.spawn().unwrap());
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = run.0.try_wait().unwrap() {
            break status;
        }
        assert!(begun.elapsed() < LONG, "still running");
        std::thread::sleep(Duration::from_millis(50));
    };
    assert_eq!(status.code(), Some(2));
    let mut problem = String::new();
    run.0
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut problem)
        .unwrap();
    assert!(problem.contains("nobody read the last"), "{problem}");
}
