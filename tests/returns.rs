//! What a driver receives first after its commander, the driver itself, the broker or the link comes back: nothing that is
//! older than its connection allows, nothing twice, and a count of what is missing.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use asmotion_broker::{Line, TestBroker, Vhost};
use serde_json::Value;

use crate::processes::{queues, run_any, tool};
use crate::stranger::python;

/// Time for everything to come back on a loaded machine.
const LONG: Duration = Duration::from_secs(60);
/// Age in ms that no command may have that the driver reads: the limit of its connection, and the time from freezing the inputs
/// of a step to the step on a loaded machine.
const OLDEST: u64 = 500 + 200;
/// Duration of an interruption, in which commands get much older than that.
const INTERRUPTION: Duration = Duration::from_secs(4);

const DRIVER: &str = "asm driver
import StandardLibrary
signature:
	monitored command: Integer
	monitored given: Integer
	monitored lost: Integer
	controlled number: Integer
	controlled at: Integer
	controlled missed: Integer
definitions:
	main rule r_Main =
		par
			if command > 0 then par number := command at := given endpar endif
			if lost > 0 then missed := missed + lost endif
		endpar
default init s0:
	function number = 0
	function at = 0
	function missed = 0
";

const COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "driven"
[components.Driver]
implementation = { asm = "driver.asm" }
activity = { period_ms = 5 }
subscribe = { command = "builtin_interfaces/Time" }
[components.Driver.bind.monitored]
command = { topic = "command", receive = "all", field = "sec", none = 0 }
given   = { topic = "command", receive = "all", field = "nanosec", none = 0 }
lost    = { lost = "command" }
[[connections]]
from = "topic:command"
to = "Driver.command"
policy = { type = "buffer", size = 1000, max_age_ms = 500, on_stale = "no_data" }
[[promote]]
topic = "command"
as = "command"
"#;

/// A command that the driver has read.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Received {
    number: u64,
    /// Its age in the step that read it, in ms.
    age: u64,
}

/// A line of output about a step that has read a command. All times are in ms.
#[derive(Clone, Copy)]
struct StepLine {
    number: u64,
    /// Time at which the command was given, modulo 2³².
    given: u64,
    /// Time of the step since the start of the run.
    step: u64,
    /// Time at which the line was read. A line that waits in a driver that is stopped is read much later than the step was made.
    read: u64,
}

/// A driver, and what it has received.
struct Driver {
    child: Child,
    steps: Arc<Mutex<Vec<StepLine>>>,
    lines: Arc<Mutex<Vec<Value>>>,
    reader: Option<std::thread::JoinHandle<()>>,
}

fn milliseconds() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    now.as_millis() as u64
}

impl Driver {
    fn start(folder: &Path, broker: &TestBroker, url: &str) -> Self {
        std::fs::write(folder.join("driver.asm"), DRIVER).unwrap();
        let composite = folder.join("driven.composite.toml");
        std::fs::write(&composite, COMPOSITE).unwrap();
        let mut command = run_any(&composite);
        command.args(["--bus", url]).stderr(Stdio::null());
        command.env("ASMOTION_PASSWORD", broker.password());
        let mut child = command.spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let (steps, told) = (
            Arc::<Mutex<Vec<_>>>::default(),
            Arc::<Mutex<Vec<_>>>::default(),
        );
        let (to, all) = (Arc::clone(&steps), Arc::clone(&told));
        let reader = std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let line: Value = serde_json::from_str(&line).unwrap();
                to.lock().unwrap().extend(command_of(&line));
                all.lock().unwrap().push(line);
            }
        });
        Self {
            child,
            steps,
            lines: told,
            reader: Some(reader),
        }
    }

    fn received(&self) -> Vec<Received> {
        let steps = self.steps.lock().unwrap();
        // the start of the run, as the line says that was passed on fastest
        let start = steps.iter().map(|it| it.read - it.step).min();
        let received = |it: &StepLine| {
            let age = (start.unwrap() + it.step) as i64 - it.given as i64;
            let age = age.rem_euclid(1 << 32) as u64;
            Received {
                number: it.number,
                // clocks are read in whole milliseconds: one that was given just now may seem to come from the future
                age: if age > 1 << 31 { 0 } else { age },
            }
        };
        steps.iter().map(received).collect()
    }

    fn signal(&self, signal: &str) {
        let pid = self.child.id().to_string();
        let sent = Command::new("kill").args([signal, &pid]).status();
        assert!(sent.unwrap().success());
    }

    /// Waits until it has received so many commands after the first `known`.
    #[track_caller]
    fn wait_for(&self, count: usize, known: usize) {
        let until = Instant::now() + LONG;
        while self.received().len() < known + count {
            assert!(Instant::now() < until, "no commands: {:?}", self.received());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The lines of its output about messages that it has not received.
    fn told_of_losses(&self) -> Vec<Value> {
        let lines = self.lines.lock().unwrap();
        let about = lines
            .iter()
            .filter(|line| line["type"] == "dropped" || line["type"] == "summary");
        about.cloned().collect()
    }

    /// Ends it like Ctrl-C. Returns the number of commands that it reports as lost.
    fn end(&mut self) -> u64 {
        self.signal("-INT");
        self.child.wait().unwrap();
        self.reader.take().unwrap().join().unwrap();
        let lines = self.lines.lock().unwrap();
        let summary = lines.last().unwrap();
        assert_eq!(summary["type"], "summary", "{summary}");
        let lost = summary["lost"].as_array().unwrap().iter();
        lost.map(|input| input["count"].as_u64().unwrap()).sum()
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The command that a step has read.
fn command_of(line: &Value) -> Option<StepLine> {
    let updates = line["step"]["updates"].as_array()?;
    let value = |location| {
        let update = updates
            .iter()
            .find(|update| update["location"] == location)?;
        update["after"].as_str()?.parse::<u64>().ok()
    };
    Some(StepLine {
        number: value("number")?,
        given: value("at")?,
        step: (line["t"].as_f64()? * 1e3) as u64,
        read: milliseconds(),
    })
}

/// The number of lost commands that a step has counted.
fn missed_of(line: &Value) -> Option<u64> {
    let mut updates = line["step"]["updates"].as_array()?.iter();
    let update = updates.find(|update| update["location"] == "missed")?;
    update["after"].as_str()?.parse().ok()
}

/// A foreign program that gives commands.
struct Commander(Child);

impl Commander {
    fn start(python: &Path, url: &str, first: u64, form: &str) -> Self {
        let peer = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/returns/peer.py");
        let mut command = Command::new(python);
        command
            .arg(peer)
            .args(["give", url, "driven.command", &first.to_string(), form]);
        let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        Self(child.unwrap())
    }
}

impl Drop for Commander {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Checks that no command is old, doubled or out of order.
#[track_caller]
fn assert_good(received: &[Received]) {
    let numbers: Vec<_> = received.iter().map(|it| it.number).collect();
    assert!(numbers.is_sorted_by(|one, next| one < next), "{received:?}");
    let oldest = received.iter().map(|it| it.age).max();
    assert!(
        oldest.is_some_and(|age| age <= OLDEST),
        "{oldest:?} ms: {received:?}"
    );
}

/// Number of commands missing between the first and the last.
fn missing(received: &[Received]) -> u64 {
    let (first, last) = (
        received.first().unwrap().number,
        received.last().unwrap().number,
    );
    last - first + 1 - received.len() as u64
}

/// Ends a driver, and checks that no command of a commander with this form of messages is old, and that those that waited are
/// counted. A message of the form "plain" cannot be recognized when it comes again, so that it can be counted twice, and one that
/// its commander gave up because it was too old is not known to be missing.
#[track_caller]
fn assert_waiting_were_discarded(driver: &mut Driver, form: &str) {
    let lost = driver.end();
    let received = driver.received();
    assert_good(&received);
    // of about 200; a loaded machine slows the commander down
    assert!(missing(&received) > 10, "{form}: {received:?}");
    match form {
        // it gives up at most one, which it holds when the broker goes down
        "plain" => assert!(lost + 1 >= missing(&received), "{lost}: {received:?}"),
        _ => assert_eq!(
            lost,
            missing(&received),
            "{:?} {received:?}",
            driver.told_of_losses()
        ),
    }
}

fn url(broker: &TestBroker, vhost: &Vhost<'_>, port: u16) -> String {
    format!("amqp://{}@127.0.0.1:{port}/{}", broker.user(), vhost.name())
}

/// A driver and its commander, whose commands arrive; the commander's link is not the driver's.
fn driven(
    broker: &TestBroker,
    vhost: &Vhost<'_>,
    folder: &Path,
    port: u16,
    form: &str,
) -> Option<(Driver, Commander)> {
    let python = python()?;
    let driver = Driver::start(folder, broker, &url(broker, vhost, port));
    queues(vhost, "robots.services.driven.control.");
    let commander = Commander::start(python, &vhost.url(), 1, form);
    driver.wait_for(10, 0);
    Some((driver, commander))
}

#[test]
fn commands_after_the_commander_is_killed_and_starts_again_are_new_ones() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
    let port = broker.address().port();
    let Some((mut driver, commander)) = driven(&broker, &vhost, folder.path(), port, "full") else {
        return;
    };
    drop(commander);
    std::thread::sleep(Duration::from_secs(1));
    let before = driver.received();
    assert_eq!(missing(&before), 0);
    let _commander = Commander::start(python().unwrap(), &vhost.url(), 100_001, "full");
    driver.wait_for(10, before.len());
    let received = driver.received();
    assert_good(&received);
    // its first command is among them
    assert_eq!(received[before.len()].number, 100_001);
    assert_eq!(driver.end(), 0);
}

/// The queue of the driver that was killed collects commands: they are discarded when it starts again, and their number is
/// in the story, in `--json`, in `component info` and known to the specification.
#[test]
fn commands_after_the_driver_is_killed_and_starts_again_are_new_ones_and_the_others_are_counted() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
    let url = url(&broker, &vhost, broker.address().port());
    let port = broker.address().port();
    let Some((mut driver, _commander)) = driven(&broker, &vhost, folder.path(), port, "full")
    else {
        return;
    };
    for down in [INTERRUPTION, Duration::ZERO] {
        let last = driver.received().last().unwrap().number;
        drop(driver);
        std::thread::sleep(down);
        driver = Driver::start(folder.path(), &broker, &url);
        driver.wait_for(20, 0);
        let (_, info, err) = tool(&broker, &url, &["component", "info", "driven.Driver"]);
        let received = driver.received();
        assert_good(&received);
        let (lost, first) = (driver.end(), received[0].number);
        assert_eq!(missing(&received), 0, "{received:?}");
        // a few were in the old driver, and it may have acknowledged them or not
        let down = first - last - 1;
        assert!(lost.abs_diff(down) <= 10, "{lost} of {last} to {first}");
        let lines = driver.lines.lock().unwrap();
        let dropped = lines.iter().filter(|line| line["type"] == "dropped");
        let dropped: Vec<_> = dropped.collect();
        assert!(dropped.len() <= 1, "{dropped:?}");
        if lost > 0 {
            assert_eq!(dropped[0]["total"], lost, "{dropped:?}");
            let reason = dropped[0]["reason"].as_str().unwrap();
            assert!(reason.contains("earlier run of this process"), "{reason}");
            let counted = format!("{lost} messages lost");
            assert!(info.contains(&counted), "{counted}: {info}{err}");
            let missed = lines.iter().filter_map(missed_of).next_back();
            assert_eq!(missed, Some(lost));
        }
        drop(lines);
        driver = Driver::start(folder.path(), &broker, &url);
        driver.wait_for(10, 0);
    }
    // one that ended in order leaves no queue
    assert_eq!(driver.end(), 0);
}

/// A driver that did not run for a while: commands wait at the broker, and in the sockets of the driver's connection.
#[test]
fn commands_that_waited_for_a_stopped_driver_are_discarded_and_counted() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    for form in ["full", "plain"] {
        let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
        let port = broker.address().port();
        let Some((mut driver, _commander)) = driven(&broker, &vhost, folder.path(), port, form)
        else {
            return;
        };
        driver.signal("-STOP");
        std::thread::sleep(INTERRUPTION);
        driver.signal("-CONT");
        let known = driver.received().len();
        driver.wait_for(50, known);
        assert_waiting_were_discarded(&mut driver, form);
    }
}

/// A radio link that fails for a while: shorter than it takes to give up the connection, and longer.
#[test]
fn commands_that_waited_for_the_link_are_discarded_and_counted() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    for (form, seconds) in [("full", 3), ("full", 8), ("plain", 3), ("plain", 8)] {
        let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
        let line = Line::to(broker.address()).unwrap();
        let Some((mut driver, _commander)) =
            driven(&broker, &vhost, folder.path(), line.port(), form)
        else {
            return;
        };
        line.cut(true);
        std::thread::sleep(Duration::from_secs(seconds));
        let known = driver.received().len();
        line.cut(false);
        driver.wait_for(50, known);
        assert_waiting_were_discarded(&mut driver, form);
    }
}

/// The broker ends in order and starts again, or is killed, while the driver does not run and commands wait.
#[test]
fn commands_that_waited_at_a_broker_that_was_down_are_discarded_and_counted() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    for (form, kill) in [("full", false), ("full", true), ("plain", true)] {
        let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
        let port = broker.address().port();
        let Some((mut driver, _commander)) = driven(&broker, &vhost, folder.path(), port, form)
        else {
            return;
        };
        driver.signal("-STOP");
        std::thread::sleep(Duration::from_secs(1));
        if kill {
            broker.kill().unwrap();
            broker.revive().unwrap();
        } else {
            broker.stop_app().unwrap();
            broker.start_app().unwrap();
        }
        std::thread::sleep(INTERRUPTION);
        driver.signal("-CONT");
        let known = driver.received().len();
        driver.wait_for(50, known);
        assert_waiting_were_discarded(&mut driver, form);
    }
}
