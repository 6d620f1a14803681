//! `asmotion up`: all processes of a composite on one machine are restarted as often as the composite says.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(30);

const WORKER: &str = "asm worker
import StandardLibrary
signature:
	controlled n: Integer
definitions:
	main rule r_Main = n := n + 1
default init s0:
	function n = 0
";

/// One process on this machine, one on another.
const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "workers"
[components.Worker]
implementation = { asm = "worker.asm" }
task = { period_ms = 20 }
[components.Other]
implementation = { asm = "worker.asm" }
task = { period_ms = 20 }
[deploy]
restart = { policy = "on_failure", max = 2, window_s = 600, backoff_ms = [20] }
processes = [
  { name = "near", host = "desk", components = ["Worker"] },
  { name = "far", host = "robot", components = ["Other"] },
]
"#;

fn up(folder: &Path, arguments: &[&str]) -> Command {
    std::fs::write(folder.join("worker.asm"), WORKER).unwrap();
    let composite = folder.join("workers.composite.toml");
    std::fs::write(&composite, COMPOSITE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("up").arg(composite).args(arguments);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

/// The next line that contains these words.
#[track_caller]
fn said(lines: &Receiver<String>, words: &str) -> String {
    let (mut before, until) = (Vec::new(), Instant::now() + LONG);
    // processes talk all the time
    while let Ok(line) = lines.recv_timeout(until.saturating_duration_since(Instant::now())) {
        if line.contains(words) {
            return line;
        }
        before.push(line);
    }
    panic!("`{words}` is not said: {before:#?}");
}

fn signal(signal: &str, id: &str) {
    let status = Command::new("kill").args([signal, id]).status().unwrap();
    assert!(status.success());
}

#[test]
fn what_is_killed_is_started_again_until_it_was_too_often() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let mut command = up(folder.path(), &["--host", "desk", "--bus", &url]);
    command.env("ASMOTION_PASSWORD", broker.password());
    let mut running = command.spawn().unwrap();
    let lines = lines_of(&mut running);
    said(&lines, "far, which runs on `robot`");
    for count in ["restart 1", "restart 2", "too many restarts"] {
        let started = said(&lines, "Started near, process ");
        let (_, id) = started.rsplit_once(' ').unwrap();
        signal("-KILL", id);
        let line = said(&lines, count);
        assert!(
            line.contains("near") && line.contains("signal: 9"),
            "{line}"
        );
    }
    said(&lines, "near, 2 restarts");
    assert_eq!(running.wait().unwrap().code(), Some(1));
}

/// What a supervisor prints on standard error, line by line.
fn lines_of(running: &mut Child) -> Receiver<String> {
    let stderr = BufReader::new(running.stderr.take().unwrap());
    let (send, lines) = channel();
    std::thread::spawn(move || {
        for line in stderr.lines().map_while(Result::ok) {
            let _ = send.send(line);
        }
    });
    lines
}

#[test]
fn what_was_started_in_a_wrong_way_is_not_started_again() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let arguments = ["--host", "desk", "--bus", &url, "--set", "Nobody.speed=1"];
    let mut command = up(folder.path(), &arguments);
    command.env("ASMOTION_PASSWORD", broker.password());
    let mut running = command.spawn().unwrap();
    let lines = lines_of(&mut running);
    said(&lines, "`Nobody`");
    let line = said(&lines, "is not restarted");
    assert!(line.contains("`near` ended (exit status: 2)"), "{line}");
    said(&lines, "near, 0 restarts");
    assert_eq!(running.wait().unwrap().code(), Some(1));
}

#[test]
fn a_broker_that_comes_late_is_awaited() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    broker.kill().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let mut command = up(folder.path(), &["--host", "desk", "--bus", &url]);
    command.env("ASMOTION_PASSWORD", broker.password());
    let mut running = command.spawn().unwrap();
    let lines = lines_of(&mut running);
    let line = said(&lines, "waiting for the broker at ");
    assert!(line.contains("at most 29"), "{line}");
    broker.revive().unwrap();
    // it runs, without a restart
    let until = Instant::now() + LONG;
    loop {
        let tool = Command::new(env!("CARGO_BIN_EXE_asmotion"))
            .args(["component", "list", "--bus", &url])
            .env("ASMOTION_PASSWORD", broker.password())
            .output()
            .unwrap();
        if String::from_utf8_lossy(&tool.stdout).contains("Worker") {
            break;
        }
        assert!(Instant::now() < until, "{tool:?}");
    }
    signal("-TERM", &running.id().to_string());
    said(&lines, "near, 0 restarts");
    assert!(running.wait().unwrap().success());
}

#[test]
fn each_process_has_a_dashboard_also_after_a_restart() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let arguments = ["--host", "desk", "--bus", &url, "--dashboard"];
    let mut command = up(folder.path(), &arguments);
    command.env("ASMOTION_PASSWORD", broker.password());
    let mut running = Supervised(command.spawn().unwrap());
    let stderr = BufReader::new(running.0.stderr.take().unwrap());
    let (send, lines) = channel();
    std::thread::spawn(move || {
        for line in stderr.lines().map_while(Result::ok) {
            let _ = send.send(line);
        }
    });
    for _ in 0..2 {
        let started = said(&lines, "Started near, process ");
        let opened = said(&lines, "Dashboard near ");
        let (_, url) = opened.rsplit_once("http://").unwrap();
        let address = url.trim_end_matches('/');
        let mut stream = TcpStream::connect(address).unwrap();
        let request =
            format!("GET /api/system HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).unwrap();
        let mut response = String::new();
        stream.read_to_string(&mut response).unwrap();
        assert!(response.contains("\"Worker\""), "{response}");
        assert!(!response.contains("\"Other\""), "{response}");
        let (_, id) = started.rsplit_once(' ').unwrap();
        signal("-KILL", id);
    }
}

#[test]
fn it_ends_its_processes_when_it_is_told_to_end() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let mut command = up(folder.path(), &["--host", "robot", "--bus", &url]);
    command.env("ASMOTION_PASSWORD", broker.password());
    let running = command.spawn().unwrap();
    crate::processes::queues(&vhost, "robots.services.workers.control.far");
    signal("-TERM", &running.id().to_string());
    let output = running.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("far, 0 restarts"), "{said}");
}

#[test]
fn its_processes_end_in_order_when_it_is_killed() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut command = up(folder.path(), &["--host", "desk", "--bus", &vhost.url()]);
    let mut running = command.spawn().unwrap();
    let stderr = BufReader::new(running.stderr.take().unwrap());
    let started = stderr
        .lines()
        .map_while(Result::ok)
        .find_map(|line| Some(line.split_once("Started near, process ")?.1.to_owned()));
    let process = started.expect("a process");
    let queue = "robots.services.workers.control.near";
    crate::processes::queues(&vhost, queue);
    running.kill().unwrap();
    running.wait().unwrap();
    let until = Instant::now() + LONG;
    let is_there = || Path::new("/proc").join(&process).exists();
    while is_there() {
        assert!(Instant::now() < until, "process {process} runs on");
        std::thread::sleep(Duration::from_millis(20));
    }
    // a second one can start at once
    let mut command = up(folder.path(), &["--host", "desk", "--bus", &vhost.url()]);
    let again = Supervised(command.spawn().unwrap());
    crate::processes::queues(&vhost, queue);
    drop(again);
}

/// `asmotion up` of a test that may fail: told to end, so that it ends its processes.
struct Supervised(Child);

impl Drop for Supervised {
    fn drop(&mut self) {
        if let Ok(None) = self.0.try_wait() {
            signal("-TERM", &self.0.id().to_string());
            let _ = self.0.wait();
        }
    }
}

/// A process of a worker, and of a map server that fails in its first cycle, since its map cannot be read.
fn failing(folder: &Path, lifecycle: &str) {
    let server = format!(
        r#"[components.Maps]
implementation = {{ rust = "nav::MapServer" }}
activity = {{ period_ms = 20 }}
services = {{ maps = "nav/MapService" }}
properties = {{ source = ".", place = "hall" }}
lifecycle = {{ {lifecycle} }}
[deploy]"#
    );
    std::fs::write(folder.join("hall.geojson"), "{").unwrap();
    let text = COMPOSITE.replace("[deploy]", &server);
    let text = text.replace("[\"Worker\"]", "[\"Worker\", \"Maps\"]");
    std::fs::write(folder.join("workers.composite.toml"), text).unwrap();
}

#[test]
fn a_component_that_fails_is_isolated_or_reset_or_ends_its_process_as_the_composite_says() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    for (lifecycle, faults, ends) in [
        ("on_exception = \"stop\"", 1, false),
        ("on_exception = \"reset\", max_resets = 3", 4, false),
        ("on_exception = \"escalate\"", 1, true),
    ] {
        let vhost = broker.vhost().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let mut command = up(folder.path(), &["--host", "desk", "--bus", &vhost.url()]);
        failing(folder.path(), lifecycle);
        let mut running = Supervised(command.spawn().unwrap());
        let stderr = BufReader::new(running.0.stderr.take().unwrap());
        let (send, lines) = channel();
        let reader = std::thread::spawn(move || {
            for line in stderr.lines().map_while(Result::ok) {
                let _ = send.send(line);
            }
        });
        for _ in 0..faults {
            let line = said(&lines, "fault of Maps");
            assert!(line.starts_with("near | "), "{line}");
        }
        if ends {
            said(&lines, "restart 1");
        } else {
            let state = |component: &str| {
                let arguments = ["component", "info", component];
                crate::processes::tool(&broker, &vhost.url(), &arguments).1
            };
            crate::processes::queues(&vhost, "robots.services.workers.control.near");
            assert!(state("Maps").starts_with("Maps: Exception"), "{lifecycle}");
            assert!(
                state("Worker").starts_with("Worker: Running"),
                "{lifecycle}"
            );
        }
        signal("-TERM", &running.0.id().to_string());
        let code = running.0.wait().unwrap().code();
        reader.join().unwrap();
        let later: Vec<String> = lines.try_iter().collect();
        if !ends {
            assert_eq!(code, Some(0), "{later:?}");
            let again = |line: &String| line.contains("estart 1") || line.contains("fault of");
            assert!(!later.iter().any(again), "{later:?}");
        }
    }
}

#[test]
fn a_machine_without_processes_and_processes_without_a_broker_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str]| {
        let output = up(folder.path(), arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let said = refused(&["--host", "moon", "--bus", "amqp://h"]);
    assert!(
        said.contains("no process runs on `moon`, but on `desk`, `robot`"),
        "{said}"
    );
    let said = refused(&["--host", "desk"]);
    assert!(said.contains("communicate over a broker"), "{said}");
    assert!(
        said.contains("with `asmotion run`") && !said.contains("--process"),
        "{said}"
    );
}
