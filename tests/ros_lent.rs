//! The threads that read sockets of ROS run the cycles of bridges and of what follows them: what the run tells, records and replaces
//! meanwhile.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use asmotion_ros_master::{Master, RospyNode};
use serde_json::{Value, json};

use crate::processes::{queues, through, tool};

const LONG: Duration = Duration::from_secs(60);
const TWIST: &str = "geometry_msgs/Twist";
/// Messages per second.
const RATE: u32 = 1000;

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

const COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "count"
[bridges.ros]
kind   = "ros1"
master = "${ROS_MASTER_URI}"
[components.RosBridge]
implementation = { builtin = "ros-bridge", bridge = "ros" }
activity = { period_ms = 0 }
ports.out = { command = "geometry_msgs/Twist" }
map = [{ from = "command", ros = "/cmd_vel", type = "geometry_msgs/Twist", direction = "from_ros", qos = { depth = 5000 } }]
[components.Counter]
implementation = { asm = "counter.asm" }
activity = { period_ms = 0 }
ports.in = { command = "geometry_msgs/Twist" }
[components.Counter.bind.monitored]
number = { topic = "command", receive = "all", field = "linear.x", none = 0.0 }
lost   = { lost = "command" }
[[connections]]
from = "RosBridge.command"
to = "Counter.command"
policy = { type = "buffer", size = 5000 }
"#;

fn files(place: &Path) -> PathBuf {
    std::fs::write(place.join("counter.asm"), COUNTER).unwrap();
    let composite = place.join("count.composite.toml");
    std::fs::write(&composite, COMPOSITE).unwrap();
    composite
}

/// A run that prints JSON, with the steps of the counter so far.
struct Run {
    child: Child,
    lines: Receiver<Value>,
    /// The numbers in the order of their steps.
    numbers: Vec<u64>,
    missed: u64,
    /// Steps of the counter.
    steps: Vec<u64>,
}

impl Run {
    fn start(mut command: Command) -> Self {
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let output = BufReader::new(child.stdout.take().unwrap()).lines();
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in output.map_while(Result::ok) {
                let object = serde_json::from_str(&line).unwrap_or(json!({ "broken": line }));
                if sender.send(object).is_err() {
                    return;
                }
            }
        });
        Self {
            child,
            lines,
            numbers: Vec::new(),
            missed: 0,
            steps: Vec::new(),
        }
    }

    fn read(&mut self, line: &Value) {
        assert!(line.get("broken").is_none(), "{line}");
        let step = &line["step"];
        for update in step["updates"].as_array().into_iter().flatten() {
            let after: f64 = update["after"].as_str().unwrap().parse().unwrap();
            match update["location"].as_str().unwrap() {
                "latest" => self.numbers.push(after as u64),
                _ => self.missed = after as u64,
            }
        }
        self.steps.extend(step["number"].as_u64());
    }

    fn until(&mut self, what: &str, is_so: impl Fn(&Self, &Value) -> bool) {
        let until = Instant::now() + LONG;
        loop {
            assert!(Instant::now() < until, "{what}");
            let line = self.lines.recv_timeout(LONG).unwrap();
            self.read(&line);
            if is_so(self, &line) {
                return;
            }
        }
    }

    /// Waits until so many numbers have come.
    fn count(&mut self, count: usize) {
        self.until("numbers", |run, _| run.numbers.len() >= count);
    }

    /// Interrupts the run, and reads to its end.
    fn end(&mut self) {
        let process = self.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &process]).status();
        assert!(sent.unwrap().success());
        while let Ok(line) = self.lines.recv_timeout(LONG) {
            self.read(&line);
        }
        self.child.wait().unwrap();
    }

    /// Every number has come once and in order, or is reported as lost.
    fn check(&self) {
        let pairs = self.numbers.windows(2).map(|pair| (pair[0], pair[1]));
        let gaps = pairs.map(|(one, next)| next.checked_sub(one + 1).expect("doubled"));
        assert_eq!(gaps.sum::<u64>(), self.missed);
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn run(composite: &Path, master: &Master) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite);
    command.args(["--json", "--clock", "wall", "--for", "120"]);
    command.env("ROS_MASTER_URI", master.uri());
    command
}

fn driver(master: &Master) -> RospyNode {
    let mut node = master.rospy("/driver");
    node.advertise("/cmd_vel", TWIST, 1);
    let vector = || json!({ "x": 0.0, "y": 0.0, "z": 0.0 });
    let twist = json!({ "linear": vector(), "angular": vector() });
    node.obey(json!([
        "stream", "/cmd_vel", TWIST, twist, "linear.x", 1, RATE
    ]));
    node
}

#[test]
fn what_lent_threads_run_is_told_recorded_and_replayed_alike() {
    let Some(master) = Master::start() else {
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let recording = place.path().join("run.mcap");
    let mut command = run(&files(place.path()), &master);
    command.arg("--record").arg(&recording);
    let mut run = Run::start(command);
    run.until("registered", |_, line| {
        let text = line["text"].as_str().unwrap_or_default();
        text.contains("registered at the ROS master")
    });
    let driver = driver(&master);
    run.count(2000);
    // in the middle of the stream
    run.end();
    drop(driver);
    run.check();
    let first = *run.steps.first().unwrap();
    let expected: Vec<u64> = (first..).take(run.steps.len()).collect();
    assert_eq!(run.steps, expected);

    let mut replay = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = replay.args(["replay", "--json"]).arg(&recording).output();
    let output = output.unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}");
    let mut objects = text.lines().filter_map(|it| serde_json::from_str(it).ok());
    let counter = objects.find(|it: &Value| it["type"] == "coordinator");
    let counter = counter.unwrap();
    assert_eq!(counter["result"], "equal", "{counter}");
    // steps without updates, as the first one, are not told, and counted
    assert_eq!(counter["steps"], *run.steps.last().unwrap(), "{counter}");
}

#[test]
fn a_specification_is_replaced_while_lent_threads_run_it() {
    let (Some(broker), Some(master)) = (asmotion_broker::calm(), Master::start()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let place = tempfile::tempdir().unwrap();
    let composite = files(place.path());
    let mut run = Run::start(through(run(&composite, &master), &broker, &vhost, None));
    queues(&vhost, "robots.services.count.control");
    let _driver = driver(&master);
    for version in 1..=3 {
        run.count(500 * version);
        let text = COUNTER.replace(
            "\t\tpar\n",
            &format!("\t\tpar {}\n", "skip ".repeat(version)),
        );
        std::fs::write(place.path().join("counter.asm"), text).unwrap();
        let arguments = ["reconfigure", composite.to_str().unwrap()];
        let (code, out, err) = tool(&broker, &url, &arguments);
        assert_eq!(code, Some(0), "{out}{err}");
        assert!(out.contains("counter.asm"), "{out}");
    }
    run.count(2500);
    run.end();
    run.check();
}
