//! Standstills: of a process that reads a message queue, and of the reader of a run's output.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use asmotion_skip::PYTHON;
use serde_json::Value;

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
