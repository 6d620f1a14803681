//! A thousand commands a second from ROS, while the master, the publisher or both are killed and started again three times: each gap
//! is reported, nothing comes twice, and the robot stops when its commands are too old.
//!
//! `ASMOTION_KILLS_SECONDS` is the length of each of the four phases, 2 s by default.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_ros_domain::{CycloneNode, TopicPolicies, domain, python};
use asmotion_ros_master::{Master, RospyNode};
use serde_json::{Value, json};

const TWIST: &str = "geometry_msgs/Twist";
/// Commands per second.
const RATE: u32 = 1000;
/// The numbers of each publisher begin at a multiple of this.
const PUBLISHER: u64 = 10_000_000;
/// Age limit of the robot's commands, in s.
const LIMIT: f64 = 0.2;
/// Period of the robot, in s.
const PERIOD: f64 = 0.01;
/// Time for everything on a busy machine.
const LONG: Duration = Duration::from_secs(60);

/// Reads every command.
const COUNTER: &str = "asm counter
import StandardLibrary
signature:
	monitored number: Real
	monitored lost: Integer
	controlled latest: Real
	controlled missed: Integer
definitions:
	main rule r_Main =
		par
			if number > 0.0 then latest := number endif
			if lost > 0 then missed := missed + lost endif
		endpar
default init s0:
	function latest = 0.0
	function missed = 0
";

/// Drives in each cycle in which it has a command.
const ROBOT: &str = "asm robot
import StandardLibrary
signature:
	monitored speed: Real
	controlled driven: Integer
	controlled stands: Boolean
definitions:
	main rule r_Main =
		if speed > 0.0 then par driven := driven + 1 stands := false endpar
		else if not stands then stands := true endif endif
default init s0:
	function driven = 0
	function stands = true
";

fn composite(folder: &Path, bridge: &str, qos: &str) -> PathBuf {
    std::fs::write(folder.join("counter.asm"), COUNTER).unwrap();
    std::fs::write(folder.join("robot.asm"), ROBOT).unwrap();
    let text = format!(
        r#"schema = "composite/1"
[composite]
name = "driven"
[bridges.ros]
{bridge}
[components.RosBridge]
implementation = {{ builtin = "ros-bridge", bridge = "ros" }}
activity = {{ period_ms = 0 }}
ports.out = {{ command = "{TWIST}" }}
map = [{{ from = "command", ros = "/cmd_vel", type = "{TWIST}", direction = "from_ros", qos = {{ {qos} }} }}]
[components.Counter]
implementation = {{ asm = "counter.asm" }}
activity = {{ period_ms = 0 }}
ports.in = {{ command = "{TWIST}" }}
[components.Counter.bind.monitored]
number = {{ topic = "command", receive = "all", field = "linear.x", none = 0.0 }}
lost   = {{ lost = "command" }}
[components.Robot]
implementation = {{ asm = "robot.asm" }}
activity = {{ period_ms = 10 }}
ports.in = {{ command = "{TWIST}" }}
[components.Robot.bind.monitored]
speed = {{ topic = "command", receive = "last", field = "linear.y", none = 0.0 }}
[[connections]]
from = "RosBridge.command"
to = "Counter.command"
policy = {{ type = "buffer", size = 5000 }}
[[connections]]
from = "RosBridge.command"
to = "Robot.command"
policy = {{ type = "data", max_age_ms = 200, on_stale = "no_data" }}
"#
    );
    let path = folder.join("driven.composite.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// What the run has shown so far, with times in s.
#[derive(Default)]
struct Shown {
    numbers: Vec<(f64, u64)>,
    missed: u64,
    driven: Vec<f64>,
    stopped: Vec<f64>,
    notices: Vec<(f64, String)>,
    /// Messages lost according to the summary.
    lost: u64,
    has_ended: bool,
}

impl Shown {
    fn read(&mut self, line: &Value) {
        let time = line["t"].as_f64().unwrap_or_default();
        for update in line["step"]["updates"].as_array().into_iter().flatten() {
            let after = update["after"].as_str().unwrap();
            match update["location"].as_str().unwrap() {
                "latest" => {
                    let number: f64 = after.parse().unwrap();
                    self.numbers.push((time, number as u64));
                }
                "missed" => self.missed = after.parse().unwrap(),
                "driven" => self.driven.push(time),
                "stands" if after == "true" => self.stopped.push(time),
                _ => {}
            }
        }
        if line["type"] == "notice" {
            let text = line["text"].as_str().unwrap().to_owned();
            self.notices.push((time, text));
        }
        for input in line["lost"].as_array().into_iter().flatten() {
            if input["input"] == "Counter.command" {
                self.lost += input["count"].as_u64().unwrap();
            }
        }
    }

    fn notices(&self, text: &str) -> Vec<f64> {
        let of_text = self.notices.iter().filter(|(_, it)| it.contains(text));
        of_text.map(|(time, _)| *time).collect()
    }

    fn last(&self) -> u64 {
        self.numbers.last().map_or(0, |(_, number)| *number)
    }
}

/// A run whose output is read all the time.
struct Run {
    child: Child,
    shown: Arc<Mutex<Shown>>,
}

impl Run {
    fn start(composite: &Path, change: impl FnOnce(&mut Command)) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.arg("run").arg(composite);
        command.args(["--json", "--clock", "wall", "--for", "600"]);
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        change(&mut command);
        let mut child = command.spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let shown = Arc::new(Mutex::new(Shown::default()));
        let kept = Arc::clone(&shown);
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                kept.lock()
                    .unwrap()
                    .read(&serde_json::from_str(&line).unwrap());
            }
            kept.lock().unwrap().has_ended = true;
        });
        Self { child, shown }
    }

    fn with<T>(&self, look: impl FnOnce(&Shown) -> T) -> T {
        look(&self.shown.lock().unwrap())
    }

    fn until(&self, what: &str, mut is_so: impl FnMut(&Shown) -> bool) {
        let until = Instant::now() + LONG;
        while !self.with(&mut is_so) {
            let about = || self.with(|it| (it.last(), it.notices.clone()));
            assert!(Instant::now() < until, "{what}: {:?}", about());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until the commands of this publisher have come for so many seconds.
    fn drive(&self, publisher: u64, seconds: f64) {
        let is_of = |number: u64| number / PUBLISHER == publisher;
        self.until("commands", |shown| is_of(shown.last()));
        let begun = self.with(|shown| shown.numbers.last().unwrap().0);
        self.until("a phase", |shown| {
            is_of(shown.last()) && shown.numbers.last().unwrap().0 >= begun + seconds
        });
    }

    /// Waits until the robot has stopped because this publisher has been killed.
    fn stop(&self, publisher: u64) {
        let last = |shown: &Shown| {
            let mut numbers = shown.numbers.iter().rev();
            numbers
                .find(|(_, it)| it / PUBLISHER == publisher)
                .unwrap()
                .0
        };
        self.until("the robot stands", |shown| {
            shown.stopped.last().is_some_and(|at| *at > last(shown))
        });
    }

    fn end(mut self) -> Shown {
        let process = self.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &process]).status();
        assert!(sent.unwrap().success());
        self.child.wait().unwrap();
        self.until("the end of the output", |shown| shown.has_ended);
        std::mem::take(&mut *self.shown.lock().unwrap())
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn phase() -> f64 {
    let variable = std::env::var("ASMOTION_KILLS_SECONDS");
    variable.map_or(2.0, |seconds| seconds.parse().unwrap())
}

/// Checks the numbers, and that the robot drove for no longer than the limit after the last command of each publisher that was
/// killed. Prints the figures.
fn check(shown: &Shown, publishers: u64) {
    let numbers: Vec<u64> = shown.numbers.iter().map(|(_, number)| *number).collect();
    assert!(numbers.is_sorted_by(|one, next| one < next), "doubled");
    let pairs = numbers.windows(2).map(|pair| (pair[0], pair[1]));
    let within = pairs.filter(|(one, next)| one / PUBLISHER == next / PUBLISHER);
    let gaps: u64 = within.map(|(one, next)| next - one - 1).sum();
    assert_eq!(gaps, shown.missed, "gaps that nobody has reported");
    assert_eq!(shown.missed, shown.lost);
    let mut stops = Vec::new();
    for publisher in 1..publishers {
        let of = |number: &(f64, u64)| number.1 / PUBLISHER == publisher;
        let last = shown.numbers.iter().rev().find(|it| of(it)).unwrap().0;
        let next = shown.numbers.iter().find(|it| it.1 / PUBLISHER > publisher);
        let next = next.unwrap().0;
        let mut stopped = shown.stopped.iter();
        let stopped = stopped.find(|at| **at > last && **at < next);
        let stopped = *stopped.expect("it stops");
        let mut driven = shown.driven.iter().rev();
        let drove = driven.find(|at| **at < stopped).unwrap() - last;
        stops.push(drove);
        assert!(
            drove <= LIMIT + PERIOD,
            "drove {drove} s after its last command"
        );
    }
    let count = numbers.len();
    eprintln!("{count} commands, {gaps} lost and reported; drove on for {stops:.3?} s");
}

#[test]
fn publishers_of_ros_2_are_killed_three_times_at_1_khz() {
    let Some(python) = python() else { return };
    let (folder, domain) = (tempfile::tempdir().unwrap(), domain());
    let bridge = format!("kind = \"ros2\"\ndomain = {domain}");
    let qos = "depth = 5000, deadline_ms = 100";
    let run = Run::start(&composite(folder.path(), &bridge, qos), |command| {
        command
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env_remove("ROS_LOCALHOST_ONLY");
    });
    run.until("joined", |shown| !shown.notices("joined").is_empty());
    let start = |publisher: u64| {
        let mut node = CycloneNode::start(&python, domain, &format!("driver_{publisher}"));
        let policies = TopicPolicies {
            deadline: Some(Duration::from_millis(100)),
            depth: 1000,
            ..TopicPolicies::default()
        };
        node.advertise("/cmd_vel", TWIST, policies, 1);
        let first = publisher * PUBLISHER + 1;
        node.stream("/cmd_vel", &twist(), ("linear.x", first), RATE);
        node
    };
    let mut talker = start(1);
    for publisher in 1..=3 {
        run.drive(publisher, phase());
        let gaps = run.with(|shown| shown.notices("no message within the deadline").len());
        talker.kill();
        run.stop(publisher);
        run.until("a report of the gap", |shown| {
            shown.notices("no message within the deadline").len() > gaps
        });
        talker = start(publisher + 1);
    }
    run.drive(4, phase());
    check(&run.end(), 4);
}

/// The master of ROS 1 is killed first, which no connection notices, and then the publisher.
#[test]
fn the_master_and_publishers_of_ros_1_are_killed_three_times_at_1_khz() {
    let Some(mut master) = Master::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let bridge = format!("kind = \"ros1\"\nmaster = \"{}\"", master.uri());
    let run = Run::start(&composite(folder.path(), &bridge, "depth = 5000"), |_| ());
    let registered = |count: usize| {
        run.until("registered", |shown| {
            shown.notices("registered at the ROS master").len()
                - shown.notices("not registered").len()
                >= count
        });
    };
    registered(1);
    let start = |master: &Master, publisher: u64| -> RospyNode {
        let mut node = master.rospy(&format!("/driver_{publisher}"));
        node.advertise("/cmd_vel", TWIST, 1);
        let first = publisher * PUBLISHER + 1;
        node.obey(json!([
            "stream",
            "/cmd_vel",
            TWIST,
            twist(),
            "linear.x",
            first,
            RATE
        ]));
        node
    };
    let mut talker = start(&master, 1);
    for publisher in 1..=3u64 {
        run.drive(publisher, phase() / 2.0);
        master.kill();
        // the connection does not need the master
        run.drive(publisher, phase() / 2.0);
        drop(talker);
        run.stop(publisher);
        run.until("reports of both", |shown| {
            let count = usize::try_from(publisher).unwrap();
            shown.notices("not registered").len() >= count
                && shown.notices("for `/cmd_vel`").len() >= count
        });
        master.restart();
        registered(1 + usize::try_from(publisher).unwrap());
        talker = start(&master, publisher + 1);
    }
    run.drive(4, phase());
    check(&run.end(), 4);
}

fn twist() -> Value {
    json!({
        "linear": {"x": 0.0, "y": 1.0, "z": 0.0},
        "angular": {"x": 0.0, "y": 0.0, "z": 0.0},
    })
}
