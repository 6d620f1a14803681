//! Missions during faults of a real broker and of processes: the robot stays safe, and nothing is lost or done twice.

use std::io::{BufRead, BufReader, Lines};
use std::path::Path;
use std::process::{Child, ChildStdout, Command};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use asmotion::BrokerSettings;
use asmotion::mission::{Mission, MissionBrokers, MissionClock, MissionEnd, MissionOutcome};
use asmotion_broker::{TestBroker, Vhost};
use asmotion_component::Time;
use asmotion_messages::Odometry;
use asmotion_runtime::Event;
use serde_json::Value;

use crate::processes::{
    Running, expected, navigation, over, queues, run_any, three_processes, wait_until_present,
};

/// Age limit of the connection from topic `permit`, in s: the time for which the rover drives without a new permission.
const LIMIT: f64 = 0.5;
/// Time in s for braking at 0.5 m/s² or more from at most 0.5 m/s, with a margin for a loaded machine.
const BRAKING: f64 = 1.5;
/// Speed in m/s below which the rover counts as standing.
const STANDS: f64 = 0.01;

/// A process whose standard output is read while it runs.
pub(super) struct Heard {
    child: Child,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Heard {
    pub(super) fn start(command: &mut Command) -> Self {
        let mut child = command.spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        Self { child, lines }
    }

    /// Reads lines until one satisfies the predicate. Returns `None` at the end of the output.
    pub(super) fn until(
        &mut self,
        told: &mut Vec<Value>,
        predicate: impl Fn(&Value) -> bool,
    ) -> Option<Value> {
        for line in self.lines.by_ref() {
            let line: Value = serde_json::from_str(&line.unwrap()).unwrap();
            told.push(line.clone());
            if predicate(&line) {
                return Some(line);
            }
        }
        None
    }
}

impl Heard {
    /// Sends it a signal, for example `-STOP`.
    pub(super) fn signal(&self, signal: &str) {
        let pid = self.child.id().to_string();
        let status = Command::new("kill").args([signal, &pid]).status();
        assert!(status.unwrap().success());
    }
}

impl Drop for Heard {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The modes entered according to a line of the run's output.
pub(super) fn entered(line: &Value) -> Vec<String> {
    let updates = line["step"]["updates"].as_array().into_iter().flatten();
    let modes = updates.filter(|update| update["location"] == "mode");
    modes
        .map(|update| update["after"].as_str().unwrap().to_owned())
        .collect()
}

pub(super) fn enters(mode: &'static str) -> impl Fn(&Value) -> bool {
    move |line| entered(line).iter().any(|entered| entered == mode)
}

/// The number of calls of a service.
fn calls(told: &[Value], operation: &str) -> usize {
    let called = |line: &&Value| line["type"] == "call" && line["operation"] == operation;
    told.iter().filter(called).count()
}

/// The record of the process on board; times are in s of its own clock.
#[derive(Default)]
struct Record {
    /// Times at which a permission to drive arrived.
    permits: Vec<f64>,
    /// Times and measured speeds of the rover.
    speeds: Vec<(f64, f64)>,
    /// Number of paths ordered by the coordinator.
    plans: usize,
    /// Events published by the follower.
    events: Vec<String>,
}

impl Record {
    fn note(&mut self, at: Time, event: &Event<'_>) {
        match event {
            Event::Injected { target: place, .. } if *place == "TrajectoryFollower.permit" => {
                self.permits.push(at.seconds())
            }
            Event::Injected { target: place, .. } if *place == "TrajectoryAdapter.path" => {
                self.plans += 1
            }
            Event::Published {
                component: "RoverDriver",
                port: "odom",
                sample,
                ..
            } => {
                let odometry = sample.downcast_ref::<Odometry>().unwrap();
                let speed = odometry.twist.twist.linear.x.abs();
                self.speeds.push((at.seconds(), speed));
            }
            Event::Published {
                component: "TrajectoryFollower",
                port: "event",
                sample,
                ..
            } => {
                let event = sample.downcast_ref::<asmotion_messages::Event>().unwrap();
                self.events.push(event.code.clone());
            }
            Event::Cycle { .. }
            | Event::Published { .. }
            | Event::Injected { .. }
            | Event::Called { .. }
            | Event::Answered { .. }
            | Event::Replied { .. }
            | Event::LifeCycle { .. }
            | Event::Fault { .. }
            | Event::Overrun { .. }
            | Event::Late { .. }
            | Event::Denied { .. }
            | Event::Dropped { .. }
            | Event::Property { .. }
            | Event::Report { .. }
            | Event::Lost { .. } => {}
        }
    }

    /// The longest interval without a permission: start and end.
    fn silence(&self) -> (f64, f64) {
        let pairs = self.permits.windows(2).map(|pair| (pair[0], pair[1]));
        pairs
            .max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))
            .unwrap()
    }

    fn moves_between(&self, (from, to): (f64, f64)) -> impl Iterator<Item = f64> {
        let within = move |at: f64| at >= from && at <= to;
        let moving = move |(at, speed): &(f64, f64)| within(*at) && *speed > STANDS;
        self.speeds
            .iter()
            .copied()
            .filter(move |it| moving(it))
            .map(|(at, _)| at)
    }
}

/// The process on board, run in a thread of the test, which can observe it.
struct Onboard {
    record: Arc<Mutex<Record>>,
    stop: Arc<AtomicBool>,
    thread: std::thread::JoinHandle<MissionEnd>,
}

impl Onboard {
    fn start(vhost: &Vhost<'_>) -> Self {
        let composite = navigation().join("navigation.composite.toml");
        let mut mission = Mission::new(composite.display().to_string());
        mission.process = Some("onboard".to_owned());
        let settings = asmotion_amqp::AmqpSettings::parse(&vhost.url()).unwrap();
        mission.brokers = MissionBrokers::One(BrokerSettings::Amqp(Box::new(settings)));
        mission.clock = MissionClock::Wall;
        let record = Arc::<Mutex<Record>>::default();
        let (recorder, stop) = (Arc::clone(&record), Arc::<AtomicBool>::default());
        let stopping = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let hear = move |at: Time, event: &Event<'_>, _: Option<&str>| {
                recorder.lock().unwrap().note(at, event);
            };
            mission.run(|_, _| (), hear, &stopping).unwrap()
        });
        wait_until_present(vhost, "onboard");
        Self {
            record,
            stop,
            thread,
        }
    }

    fn end(self) -> Record {
        self.stop.store(true, Ordering::Relaxed);
        assert_eq!(self.thread.join().unwrap().outcome, MissionOutcome::Stopped);
        std::mem::take(&mut *self.record.lock().unwrap())
    }
}

/// Runs a mission in two processes, in the middle of which `harm` is done to the broker. Checks that the coordinator
/// goes through the same modes as without it and that nothing is done twice; returns the record on board.
fn through(broker: &TestBroker, vhost: &Vhost<'_>, harm: impl FnOnce(&TestBroker)) -> Record {
    let composite = navigation().join("navigation.composite.toml");
    let onboard = Onboard::start(vhost);
    let mut supervisor = Heard::start(&mut over(&composite, broker, vhost, Some("supervisor")));
    let mut events = Vec::new();
    assert!(supervisor.until(&mut events, enters("FOLLOWING")).is_some());
    // driving, and far from the goal
    std::thread::sleep(Duration::from_millis(1500));
    harm(broker);
    supervisor.until(&mut events, |_| false);
    let modes: Vec<_> = events.iter().flat_map(entered).collect();
    let code = supervisor.child.wait().unwrap().code();
    assert_eq!((modes, code), expected());
    assert_eq!((calls(&events, "getMap"), calls(&events, "plan")), (1, 1));
    let record = onboard.end();
    // one order to drive, one to stop
    assert_eq!(record.plans, 2);
    assert_eq!(record.events, ["REACHED", "HALTED"]);
    record
}

#[test]
fn n10_the_rover_stops_while_the_broker_is_dead_and_arrives_when_it_is_back() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let record = through(&broker, &vhost, |broker| {
        broker.kill().unwrap();
        // longer than the rover may continue to drive
        std::thread::sleep(Duration::from_secs(3));
        broker.revive().unwrap();
    });
    let (from, to) = record.silence();
    assert!(to - from > 3.0, "nobody was silent: {from} {to}");
    let before = record.moves_between((from - 0.5, from)).count();
    assert!(before > 0, "it did not move when the broker died");
    let last = record.moves_between((from, to)).last().unwrap_or(from);
    let moved = last - from;
    println!("the rover moved for {moved:.2} s without a broker");
    assert!(moved <= LIMIT + BRAKING, "it moved for {moved:.2} s");
    assert!(record.moves_between((to, f64::MAX)).count() > 0);
}

#[test]
fn the_mission_goes_on_when_an_operator_has_closed_the_connections() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    through(&broker, &vhost, |broker| {
        broker.close_connections().unwrap()
    });
}

#[test]
fn the_mission_goes_on_when_an_operator_has_deleted_the_exchanges() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    for exchange in ["robots", "robots.services"] {
        let vhost = broker.vhost().unwrap();
        let record = through(&broker, &vhost, |_| {
            vhost.delete_exchange(exchange).unwrap()
        });
        let (from, to) = record.silence();
        // sooner than a silent broker is given up
        assert!(to - from < 4.5, "{exchange}: {} s without it", to - from);
    }
}

/// Sends a signal to a child process.
fn signal(process: &Child, signal: &str) {
    let mut kill = Command::new("kill");
    let status = kill.args([signal, &process.id().to_string()]).status();
    assert!(status.unwrap().success());
}

#[test]
fn a_provider_killed_in_a_call_is_unavailable_before_the_deadline_and_serves_again_when_it_is_back()
{
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    // a long deadline, so that it does not end the call
    let text = std::fs::read_to_string(&composite).unwrap();
    let patient = text.replace("timeout_ms = 1000", "timeout_ms = 20000");
    assert_ne!(text, patient);
    std::fs::write(&composite, patient).unwrap();
    let command = |process| over(&composite, &broker, &vhost, Some(process));
    let onboard = Running::start(&mut command("onboard"));
    let serves = || queues(&vhost, "robots.services.navigation.TrajectoryPlanner.");

    let mut planning = Heard::start(&mut command("planning"));
    serves();
    wait_until_present(&vhost, "onboard");
    // it takes the request, and then stops responding
    signal(&planning.child, "-STOP");
    let mut supervisor = command("supervisor");
    let supervisor = supervisor.args(["--until", "mode=ARRIVED", "--unless", "mode=STOPPING"]);
    let mut supervisor = Heard::start(supervisor);
    let mut events = Vec::new();
    let plan = |kind: &'static str| {
        move |line: &Value| line["type"] == kind && line["operation"] == "plan"
    };
    let call = supervisor.until(&mut events, plan("call")).unwrap();
    std::thread::sleep(Duration::from_millis(300));
    planning.child.kill().unwrap();
    let reply = supervisor.until(&mut events, plan("reply")).unwrap();
    assert_eq!(reply["error"], "unavailable");
    let took = reply["t"].as_f64().unwrap() - call["t"].as_f64().unwrap();
    assert!(took < 10.0, "{took} s");
    assert!(supervisor.until(&mut events, enters("FAILED")).is_some());

    let _planning = Running::start(&mut command("planning"));
    serves();
    let goal = r#"{"header":{"frame_id":"map"},"pose":{"position":{"x":3.4,"y":4.7},"orientation":{"w":1.0}}}"#;
    let mut tool = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    tool.args([
        "topic",
        "pub",
        "navigation.goal",
        goal,
        "--bus",
        &vhost.url(),
    ]);
    assert!(tool.status().unwrap().success());
    supervisor.until(&mut events, |_| false);
    assert_eq!(
        supervisor.child.wait().unwrap().code(),
        Some(0),
        "{events:?}"
    );
    let modes: Vec<_> = events.iter().flat_map(entered).collect();
    let (again, _) = expected();
    let first = ["WAIT_MAP", "WAIT_PATH", "FAILED"].map(str::to_owned);
    assert_eq!(modes, [&first[..], &again].concat());
    onboard.interrupt();
}

const WRITER: &str = "
asm writer
import StandardLibrary
signature:
	enum domain Mode = {NEW | SAID}
	controlled mode: Mode
	out greeting: String
	out news: String
definitions:
	main rule r_Main =
		if mode = NEW then
			par mode := SAID greeting := \"hello\" news := \"once\" endpar
		endif
default init s0:
	function mode = NEW
";

const READER: &str = "
asm reader
import StandardLibrary
signature:
	monitored greeting: String
	monitored news: String
	controlled heard: String
	controlled read: String
definitions:
	main rule r_Main =
		par
			if greeting != \"\" then heard := greeting endif
			if news != \"\" then read := news endif
		endpar
default init s0:
	function heard = \"\"
	function read = \"\"
";

const LATE: &str = r#"
schema = "composite/1"
[composite]
name = "late"

[components.Writer]
implementation = { asm = "writer.asm", main = "r_Main" }
task = { id = "writer", period_ms = 20 }
ports.out = { greeting = "std_msgs/String" }
publish = { news = "std_msgs/String" }
[components.Writer.bind.out]
greeting = { topic = "greeting" }
news = { topic = "news" }

[components.Reader]
implementation = { asm = "reader.asm", main = "r_Main" }
task = { id = "reader", period_ms = 20 }
ports.in = { greeting = "std_msgs/String", news = "std_msgs/String" }
[components.Reader.bind.monitored]
greeting = { topic = "greeting", receive = "last", none = "" }
news = { topic = "news", receive = "last", none = "" }

[[connections]]
from = "Writer.greeting"
to = "Reader.greeting"
policy = { type = "data", init = true }

[[connections]]
from = "topic:news"
to = "Reader.news"
policy = { type = "data", init = true }

[deploy]
processes = [
  { name = "early", components = ["Writer"] },
  { name = "late", components = ["Reader"] },
]
"#;

#[test]
fn who_starts_late_gets_what_was_published_once() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = late(folder.path());
    let command = |process| {
        let mut command = run_any(&composite);
        command.args(["--bus", &vhost.url(), "--process", process]);
        command
    };
    let mut early = Heard::start(&mut command("early"));
    assert!(early.until(&mut Vec::new(), enters("SAID")).is_some());
    // read once, and a second reader does not cause a second message to the first
    for _ in 0..2 {
        let late = command("late").args(["--until", "read=\"once\""]).output();
        let late = late.unwrap();
        let said = String::from_utf8(late.stdout).unwrap();
        assert_eq!(late.status.code(), Some(0), "{said}");
    }
    let late = command("late")
        .args(["--until", "heard=\"hello\""])
        .output();
    assert_eq!(late.unwrap().status.code(), Some(0));
}

fn late(folder: &Path) -> std::path::PathBuf {
    std::fs::write(folder.join("writer.asm"), WRITER).unwrap();
    std::fs::write(folder.join("reader.asm"), READER).unwrap();
    let composite = folder.join("late.composite.toml");
    std::fs::write(&composite, LATE).unwrap();
    composite
}

#[test]
fn n4_a_contact_on_board_reaches_the_coordinator_over_a_broker() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let composite = navigation().join("navigation.composite.toml");
    // a pillar a hand's breadth in front of the rover, late enough that it drives on a loaded machine, too
    let pillar = r#"World.obstacles=[{ at_s = 14.0, frame = "robot", disc = [0.31, 0.0, 0.05] }]"#;
    let process = |name| {
        let mut command = run_any(&composite);
        command.args(["--bus", &vhost.url(), "--process", name]);
        command
    };
    let onboard = Running::start(process("onboard").args(["--set", pillar]));
    wait_until_present(&vhost, "onboard");
    let mut supervisor = Heard::start(&mut process("supervisor"));
    let mut told = Vec::new();
    let plans_anew = |line: &Value| {
        let mut updates = line["step"]["updates"].as_array().into_iter().flatten();
        updates.any(|update| update["location"] == "tries" && update["after"] == "1")
    };
    assert!(
        supervisor.until(&mut told, plans_anew).is_some(),
        "{told:#?}"
    );
    let drives_on = enters("FOLLOWING");
    assert!(
        supervisor.until(&mut told, drives_on).is_some(),
        "{told:#?}"
    );
    assert_eq!(calls(&told, "plan"), 2);
    let output = onboard.interrupt();
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(summary.contains(r#""collisions":1"#), "{summary}");
}
