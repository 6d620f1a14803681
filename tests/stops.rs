//! What leaves a process when a component or the whole run ends: the safe values of its outputs reach foreign readers, in any
//! order of the components in the composite.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use asmotion_ros_master::{Master, RospyNode};
use asmotion_skip::PYTHON;
use serde_json::json;

use crate::processes::{queues, tool};
use crate::ros_bridge::Mission;
use crate::stranger::python;

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(30);

/// Permits a movement in each step, and may fail.
const DRIVER: &str = "asm driver
import StandardLibrary
signature:
	controlled n: Integer
	out moves: Boolean
definitions:
	main rule r_Main =
		par
			n := n + 1
			moves := true
			if n = FAILS then n := 0 endif
		endpar
default init s0:
	function n = 0
";

/// How a run, or one of its components, ends.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ending {
    /// By a signal.
    Signal(&'static str),
    /// After its time.
    TimeUp,
    /// A driver fails, and ends the run.
    Fault,
    /// A driver fails and is started again; the others go on.
    Reset,
    /// A driver fails, and stops all components.
    Escalate,
}

const ENDINGS: [Ending; 6] = [
    Ending::Signal("-TERM"),
    Ending::Signal("-INT"),
    Ending::TimeUp,
    Ending::Fault,
    Ending::Reset,
    Ending::Escalate,
];

/// All orders of these elements.
fn orders(of: &[&'static str]) -> Vec<Vec<&'static str>> {
    if of.is_empty() {
        return vec![Vec::new()];
    }
    let starting = |first: &&'static str| {
        let rest: Vec<_> = of.iter().copied().filter(|it| it != first).collect();
        let first = *first;
        orders(&rest).into_iter().map(move |mut order| {
            order.insert(0, first);
            order
        })
    };
    of.iter().flat_map(starting).collect()
}

/// A driver that publishes the topic `NAME`, or writes its output of this name.
fn driver(name: &str, ends: &str, ending: Ending) -> String {
    let on_exception = match ending {
        Ending::Reset => ", on_exception = \"reset\", max_resets = 1",
        Ending::Escalate => ", on_exception = \"escalate\"",
        Ending::Signal(_) | Ending::TimeUp | Ending::Fault => "",
    };
    format!(
        r#"
[components.{name}]
implementation = {{ asm = "{name}.asm" }}
activity = {{ period_ms = 20 }}
{ends} = {{ {name} = "std_msgs/Bool" }}
lifecycle = {{ safe = {{ {name} = {{ data = false }} }}{on_exception} }}
[components.{name}.bind.out]
moves = {{ topic = "{name}", field = "data", publish = "every_step" }}
"#
    )
}

/// Writes a composite of elements, and the specifications of its drivers, of which `drive` fails if it is to.
fn composite(folder: &Path, header: &str, elements: &[String], ending: Ending) -> PathBuf {
    let fails = match ending {
        Ending::Fault | Ending::Reset | Ending::Escalate => "150",
        Ending::Signal(_) | Ending::TimeUp => "-1",
    };
    for (name, limit) in [("drive", fails), ("arm", "-1")] {
        let text = DRIVER.replace("asm driver", &format!("asm {name}"));
        let text = text.replace("FAILS", limit);
        std::fs::write(folder.join(format!("{name}.asm")), text).unwrap();
    }
    let path = folder.join("driven.composite.toml");
    let text = format!("schema = \"composite/1\"\n[composite]\nname = \"driven\"\n{header}\n");
    std::fs::write(&path, text + &elements.concat()).unwrap();
    path
}

/// `asmotion run` of a composite.
fn run(composite: &Path, ending: Ending) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let seconds = match ending {
        Ending::TimeUp => "4",
        Ending::Signal(_) | Ending::Fault | Ending::Reset | Ending::Escalate => "120",
    };
    command.arg("run").arg(composite);
    command.args(["--clock", "wall", "--for", seconds]);
    command.current_dir(composite.parent().unwrap());
    command
}

const BRIDGE: &str = r#"
[components.bridge]
implementation = { builtin = "ros-bridge", bridge = "robot" }
activity = { period_ms = 0 }
subscribe = { drive = "std_msgs/Bool", arm = "std_msgs/Bool" }
map = [
  { from = "drive", ros = "/drive", type = "std_msgs/Bool", direction = "to_ros" },
  { from = "arm", ros = "/arm", type = "std_msgs/Bool", direction = "to_ros" },
]
"#;

const ROBOT: &str = "[bridges.robot]\nkind = \"ros1\"\nmaster = \"${ROS_MASTER_URI}\"";

/// Runs drivers and a ros-bridge in this order. Returns the last message that a robot of ROS receives from each driver.
fn last_in_ros(
    master: &Master,
    robot: &mut RospyNode,
    order: &[&str],
    ending: Ending,
) -> [bool; 2] {
    let folder = tempfile::tempdir().unwrap();
    let element = |name: &&str| match *name {
        "bridge" => BRIDGE.to_owned(),
        name => driver(name, "publish", ending),
    };
    let elements: Vec<_> = order.iter().map(element).collect();
    let composite = composite(folder.path(), ROBOT, &elements, ending);
    let mut command = run(&composite, ending);
    command.env("ROS_MASTER_URI", master.uri());
    let mission = Mission::spawn(command);
    let topics = ["/drive", "/arm"];
    for topic in topics {
        let (moves, _) = robot.message(topic);
        assert_eq!(moves, json!({"data": true}), "{order:?}, {ending:?}");
    }
    match ending {
        Ending::Signal(signal) => mission.signal(signal),
        Ending::Reset => {
            while robot.message("/drive").0 == json!({"data": true}) {}
            assert_eq!(robot.message("/drive").0, json!({"data": true}));
            mission.signal("-TERM");
        }
        Ending::TimeUp | Ending::Fault | Ending::Escalate => {}
    }
    mission.end();
    // time for the robot to print it
    std::thread::sleep(Duration::from_millis(300));
    topics.map(|topic| {
        let mut last = true;
        for _ in 0..robot.waiting(topic) {
            last = robot.message(topic).0["data"].as_bool().unwrap();
        }
        last
    })
}

#[test]
fn safe_values_reach_a_robot_of_ros_in_any_order_of_drivers_and_bridge() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut robot = master.rospy("/robot");
    for topic in ["/drive", "/arm"] {
        robot.subscribe(topic, "std_msgs/Bool");
    }
    let term = orders(&["drive", "arm", "bridge"]);
    let term = term.into_iter().map(|order| (order, ENDINGS[0]));
    let others = ENDINGS[1..].iter();
    let others = others.map(|ending| (vec!["drive", "arm", "bridge"], *ending));
    for (order, ending) in term.chain(others) {
        let last = last_in_ros(&master, &mut robot, &order, ending);
        assert_eq!(last, [false, false], "{order:?}, {ending:?}");
    }
}

const PROGRAM: &str = r#"
[components.program]
implementation = { process = ["python3", "program.py"] }
activity = { period_ms = 20 }
subscribe = { drive = "std_msgs/Bool", arm = "std_msgs/Bool" }
"#;

#[test]
fn safe_values_reach_a_program_in_any_order() {
    if Command::new("python3").arg("--version").output().is_err() {
        PYTHON.skip();
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (order, ending) in orders(&["drive", "arm", "program"])
        .into_iter()
        .zip(ENDINGS)
        .chain([(vec!["drive", "arm", "program"], ENDINGS[0])])
    {
        let folder = tempfile::tempdir().unwrap();
        for file in ["tests/stops/program.py", "examples/gripper/protocol.py"] {
            let to = folder.path().join(Path::new(file).file_name().unwrap());
            std::fs::copy(root.join(file), to).unwrap();
        }
        let element = |name: &&str| match *name {
            "program" => PROGRAM.to_owned(),
            name => driver(name, "publish", ending),
        };
        let elements: Vec<_> = order.iter().map(element).collect();
        let composite = composite(folder.path(), "", &elements, ending);
        let mission = Mission::spawn(run(&composite, ending));
        let taken = || std::fs::read_to_string(folder.path().join("taken")).unwrap_or_default();
        let until = Instant::now() + LONG;
        while !(taken().contains("drive true") && taken().contains("arm true")) {
            assert!(Instant::now() < until, "{order:?}, {ending:?}: {}", taken());
            std::thread::sleep(Duration::from_millis(20));
        }
        match ending {
            Ending::Signal(signal) => mission.signal(signal),
            Ending::Reset => {
                while !taken().contains("drive false") {
                    assert!(Instant::now() < until, "{order:?}: {}", taken());
                    std::thread::sleep(Duration::from_millis(20));
                }
                mission.signal("-TERM");
            }
            Ending::TimeUp | Ending::Fault | Ending::Escalate => {}
        }
        mission.end();
        let taken = taken();
        for name in ["drive", "arm"] {
            let mut lines = taken.lines().filter(|line| line.starts_with(name));
            let last = lines.next_back().unwrap();
            assert!(last.ends_with("false"), "{order:?}, {ending:?}: {taken}");
        }
    }
}

/// A foreign program that prints what it receives.
struct Peer {
    child: Child,
    lines: Receiver<String>,
}

impl Peer {
    fn start(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in output.lines().map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        Self { child, lines }
    }

    /// Waits for a line.
    #[track_caller]
    fn until(&self, wanted: &str) {
        while self.lines.recv_timeout(LONG).expect(wanted) != wanted {}
    }

    /// The last line, once no more come.
    fn last(&self) -> Option<String> {
        let next = || self.lines.recv_timeout(Duration::from_millis(500)).ok();
        std::iter::from_fn(next).last()
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn safe_values_reach_an_orocos_queue_in_any_order() {
    if Command::new("python3").arg("--version").output().is_err() {
        PYTHON.skip();
        return;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/stops/queue.py");
    let both = orders(&["drive", "arm"]).into_iter().cycle();
    for (number, (order, ending)) in both.zip(ENDINGS).enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let queue = format!("/asmotion-stop-{}-{number}", std::process::id());
        let mut elements: Vec<_> = order
            .iter()
            .map(|name| driver(name, "ports.out", ending))
            .collect();
        elements.push(format!(
            "[[connections]]\nfrom = \"drive.drive\"\nto = \"mqueue:{queue}\"\npolicy = {{ type = \"buffer\", size = 8 }}\n"
        ));
        let composite = composite(folder.path(), "", &elements, ending);
        let mission = Mission::spawn(run(&composite, ending));
        let mut command = Command::new("python3");
        command.arg(&script).arg(&queue);
        let reader = Peer::start(command);
        reader.until("true");
        match ending {
            Ending::Signal(signal) => mission.signal(signal),
            Ending::Reset => {
                reader.until("false");
                reader.until("true");
                mission.signal("-TERM");
            }
            Ending::TimeUp | Ending::Fault | Ending::Escalate => {}
        }
        mission.end();
        assert_eq!(
            reader.last().as_deref(),
            Some("false"),
            "{order:?}, {ending:?}"
        );
    }
}

#[test]
fn safe_values_reach_the_broker_in_any_order() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/returns/peer.py");
    let both = orders(&["drive", "arm"]).into_iter().cycle();
    let endings = ENDINGS.map(Some).into_iter().chain([None, None]);
    for (order, ending) in both.zip(endings) {
        let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
        // `None`: an order of `component stop`, after which the run goes on
        let of_run = ending.unwrap_or(Ending::Signal("-TERM"));
        let elements = order.iter().map(|name| driver(name, "publish", of_run));
        let elements: Vec<_> = elements.collect();
        let header = "[topics.drive]\ncodec = \"json\"";
        let composite = composite(folder.path(), header, &elements, of_run);
        let mut command = Command::new(python);
        command
            .arg(&script)
            .args(["watch", &vhost.url(), "driven.drive"]);
        let reader = Peer::start(command);
        reader.until("watches");
        let url = format!(
            "amqp://{}@{}/{}",
            broker.user(),
            broker.address(),
            vhost.name()
        );
        let mut command = run(&composite, of_run);
        command.args(["--bus", &url]);
        command.env("ASMOTION_PASSWORD", broker.password());
        let mission = Mission::spawn(command);
        let [moves, stands] = ["{\"data\": true}", "{\"data\": false}"];
        reader.until(moves);
        match ending {
            None => {
                queues(&vhost, "robots.services.driven.control.");
                let (code, _, err) = tool(&broker, &url, &["component", "stop", "drive"]);
                assert_eq!(code, Some(0), "{err}");
                assert_eq!(reader.last().as_deref(), Some(stands), "{order:?}");
                continue;
            }
            Some(Ending::Signal(signal)) => mission.signal(signal),
            Some(Ending::Reset) => {
                reader.until(stands);
                reader.until(moves);
                mission.signal("-TERM");
            }
            Some(Ending::TimeUp | Ending::Fault | Ending::Escalate) => {}
        }
        mission.end();
        assert_eq!(
            reader.last().as_deref(),
            Some(stands),
            "{order:?}, {ending:?}"
        );
    }
}

#[test]
fn safe_values_of_another_process_reach_a_robot_of_ros_when_up_ends() {
    let (Some(broker), Some(master)) = (asmotion_broker::calm(), Master::start()) else {
        return;
    };
    let mut robot = master.rospy("/robot");
    for topic in ["/drive", "/arm"] {
        robot.subscribe(topic, "std_msgs/Bool");
    }
    let processes = [
        "{ name = \"drivers\", components = [\"drive\", \"arm\"] }",
        "{ name = \"outside\", components = [\"bridge\"] }",
    ];
    for order in [[0, 1], [1, 0]] {
        let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
        let ending = Ending::Signal("-TERM");
        let elements = [
            driver("drive", "publish", ending),
            driver("arm", "publish", ending),
            BRIDGE.to_owned(),
        ];
        let listed = order.map(|it| processes[it]).join(", ");
        let header = format!("{ROBOT}\n[deploy]\nprocesses = [{listed}]");
        let composite = composite(folder.path(), &header, &elements, ending);
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.arg("up").arg(&composite);
        let (user, address) = (broker.user(), broker.address());
        let url = format!("amqp://{user}@{address}/{}", vhost.name());
        command.args(["--bus", &url]);
        command.env("ASMOTION_PASSWORD", broker.password());
        command.env("ROS_MASTER_URI", master.uri());
        let mission = Mission::spawn(command);
        let started = mission.line("drivers, process ");
        let drivers = started.rsplit(' ').next().unwrap();
        let signal = |signal: &str| {
            let sent = Command::new("kill").args([signal, drivers]).status();
            assert!(sent.unwrap().success());
        };
        for topic in ["/drive", "/arm"] {
            let (moves, _) = robot.message(topic);
            assert_eq!(moves, json!({"data": true}), "{order:?}");
        }
        // the drivers need a while to end
        signal("-STOP");
        mission.signal("-TERM");
        std::thread::sleep(Duration::from_millis(300));
        signal("-CONT");
        mission.end();
        std::thread::sleep(Duration::from_millis(300));
        for topic in ["/drive", "/arm"] {
            let mut last = true;
            for _ in 0..robot.waiting(topic) {
                last = robot.message(topic).0["data"].as_bool().unwrap();
            }
            assert!(!last, "{order:?}, {topic}");
        }
    }
}
