//! Composites with a ros-bridge, messages of a folder and transforms: recorded and replayed, and reconfigured while they run.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use asmotion_ros_master::{Master, RospyNode};
use serde_json::{Value, json};

use crate::processes::{queues, through, tool};
use crate::ros_bridge::Mission;
use crate::ros_folders::{GAUGE, folder, full_text};
use crate::ros_frames::{POSE, TRANSFORMS, pose, ros1_stamp, transform, transforms};

const LONG: Duration = Duration::from_secs(60);

/// Judges gauges, and goals in the frame of the map.
const WATCHER: &str = r#"asm watcher
import StandardLibrary
signature:
	monitored state: Integer
	monitored x: Real
	out worn: Integer
	out name: String
definitions:
	main rule r_Main =
		if state = 1 then par worn := 1 name := "worn" endpar
		else if x > 100.0 then par worn := 0 name := "far" endpar
		else if x > 0.0 then par worn := 0 name := "near" endpar endif endif endif
"#;

const COMPOSITE: &str = r#"schema = "composite/1"

[composite]
name = "gauge"

[bridges.machine]
kind        = "ros1"
master      = "${ROS_MASTER_URI}"
definitions = ["msgs"]

[components.Watcher]
implementation = { asm = "watcher.asm" }
activity  = { period_ms = 0 }
subscribe = { gauge = "acme_msgs/Gauge", goal = "geometry_msgs/PoseStamped" }
publish   = { verdict = "acme_msgs/Gauge" }

[components.Watcher.bind.monitored]
state = { topic = "gauge", receive = "all", field = "state", none = -1 }
x     = { topic = "goal", receive = "all", field = "pose.position.x", none = -1.0 }

[components.Watcher.bind.out]
worn = { topic = "verdict", field = "state", publish = "on_update" }
name = { topic = "verdict", field = "name", publish = "on_update" }

[components.RosBridge]
implementation = { builtin = "ros-bridge", bridge = "machine" }
activity  = { period_ms = 0 }
publish   = { gauge = "acme_msgs/Gauge", goal = "geometry_msgs/PoseStamped" }
subscribe = { verdict = "acme_msgs/Gauge" }
map = [
  { from = "gauge", ros = "/gauge", type = "acme_msgs/Gauge", direction = "from_ros" },
  { from = "goal", ros = "/goal", type = "geometry_msgs/PoseStamped", direction = "from_ros", transform = { frame = "map", timeout_ms = 5000 } },
  { from = "verdict", ros = "/verdict", type = "acme_msgs/Gauge", direction = "to_ros" },
]
"#;

/// Runs where the bridge is left out.
const BENCH: &str = "asm bench
import StandardLibrary
signature:
	controlled n: Integer
definitions:
	main rule r_Main = n := n + 1
default init s0:
	function n = 0
";

/// Writes the composite, its specification and its folder of messages.
fn files(place: &Path) -> PathBuf {
    let messages = place.join("msgs/acme_msgs/msg");
    std::fs::create_dir_all(&messages).unwrap();
    for name in ["Gauge.msg", "Reading.msg"] {
        let from = folder().join("msgs/acme_msgs/msg").join(name);
        std::fs::copy(from, messages.join(name)).unwrap();
    }
    std::fs::write(place.join("watcher.asm"), WATCHER).unwrap();
    let composite = place.join("gauge.composite.toml");
    std::fs::write(&composite, COMPOSITE).unwrap();
    composite
}

fn run(composite: &Path, master: &Master) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite);
    command.args(["--clock", "wall", "--for", "120"]);
    command.env("ROS_MASTER_URI", master.uri());
    command
}

/// A node of rospy whose base is at (100, 0) of the map.
struct Machine(RospyNode);

impl Machine {
    fn start(master: &Master) -> Self {
        let mut node = master.rospy("/machine");
        node.obey(json!(["define", GAUGE, full_text()]));
        node.subscribe("/verdict", GAUGE);
        node.obey(json!(["connections", "/verdict", 1]));
        node.advertise("/gauge", GAUGE, 1);
        node.advertise("/goal", POSE, 1);
        let placed = transform(ros1_stamp(0), ("map", "base"), (100.0, 0.0), 0);
        let placed = transforms(&[placed]);
        node.obey(json!(["publish", "/tf_static", TRANSFORMS, placed, true]));
        Self(node)
    }

    fn give_goal(&mut self) {
        let goal = pose(ros1_stamp(0), "base", 3.0);
        self.0.publish("/goal", POSE, goal);
    }

    fn give_gauge(&mut self) {
        let header = json!({ "seq": 0, "stamp": ros1_stamp(1000), "frame_id": "pump" });
        let readings = json!([{ "pressure": 2.5, "limits": [1.0, 3.0] }]);
        let gauge = json!({ "header": header, "name": "pump", "state": 1, "readings": readings });
        self.0.publish("/gauge", GAUGE, gauge);
    }

    fn verdict(&mut self) -> String {
        let (message, _) = self.0.message("/verdict");
        message["name"].as_str().unwrap().to_owned()
    }

    /// Gives goals until the verdict is this one.
    fn give_goals_until(&mut self, expected: &str) {
        let until = Instant::now() + LONG;
        loop {
            self.give_goal();
            let found = self.verdict();
            if found == expected {
                return;
            }
            assert!(Instant::now() < until, "still `{found}`");
        }
    }
}

fn asmotion(arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = command.args(arguments).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(text).unwrap())
}

#[test]
fn a_run_with_messages_of_a_folder_and_transforms_is_replayed_without_ros() {
    let Some(master) = Master::start() else {
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let composite = files(place.path());
    let [recording, trace] = ["run.mcap", "run.trace"].map(|name| place.path().join(name));
    let mut command = run(&composite, &master);
    command.arg("--record").arg(&recording);
    command.arg("--trace").arg(&trace);
    let mission = Mission::spawn(command);
    mission.line("registered at the ROS master");
    let mut machine = Machine::start(&master);
    machine.give_gauge();
    assert_eq!(machine.verdict(), "worn");
    machine.give_goal();
    // 3 m before the base, which is at 100 m
    assert_eq!(machine.verdict(), "far");
    mission.interrupt();
    mission.end();
    drop(machine);
    drop(master);

    let (code, text) = asmotion(&["replay", "--json", recording.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{text}");
    let objects = text.lines().filter(|line| line.starts_with('{'));
    let mut objects = objects.map(|line| serde_json::from_str::<Value>(line).unwrap());
    let watcher = objects.find(|it| it["type"] == "coordinator").unwrap();
    assert_eq!(watcher["result"], "equal", "{watcher}");
    assert!(watcher["steps"].as_u64().unwrap() >= 2, "{watcher}");
    // the specification alone, on the inputs of the trace
    let specification = place.path().join("watcher.asm");
    let [specification, trace] = [&specification, &trace].map(|it| it.to_str().unwrap());
    let (code, text) = asmotion(&["sim", specification, "--replay-inputs", trace]);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("\"worn\"") && text.contains("\"far\""),
        "{text}"
    );
}

#[test]
fn a_specification_behind_a_bridge_is_replaced_while_transforms_and_messages_of_a_folder_pass() {
    let (Some(broker), Some(master)) = (asmotion_broker::calm(), Master::start()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let place = tempfile::tempdir().unwrap();
    let composite = files(place.path());
    let mission = Mission::spawn(through(run(&composite, &master), &broker, &vhost, None));
    mission.line("registered at the ROS master");
    queues(&vhost, "robots.services.gauge.control");
    let mut machine = Machine::start(&master);
    machine.give_goals_until("far");

    let write = |name: &str, text: String| std::fs::write(place.path().join(name), text).unwrap();
    let reconfigure = || tool(&broker, &url, &["reconfigure", composite.to_str().unwrap()]);
    write("watcher.asm", WATCHER.replace("\"far\"", "\"distant\""));
    let (code, out, err) = reconfigure();
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(out.contains("watcher.asm"), "{out}");
    // the static transform was published once, before
    machine.give_goals_until("distant");
    machine.give_gauge();
    assert_eq!(machine.verdict(), "worn");

    // the bridge is connected when the process starts
    for (from, to, reason) in [
        (
            "frame = \"map\"",
            "frame = \"odom\"",
            "`RosBridge` differs in",
        ),
        (
            "[\"msgs\"]",
            "[\"msgs\", \"msgs/acme_msgs\"]",
            "`bridges` of the composite",
        ),
    ] {
        write("gauge.composite.toml", COMPOSITE.replace(from, to));
        let (code, out, err) = reconfigure();
        assert_eq!(code, Some(1), "{out}{err}");
        assert!(err.contains(reason) || out.contains(reason), "{out}{err}");
        machine.give_goals_until("distant");
    }
}

#[test]
fn a_bridge_with_transforms_is_refused_in_virtual_time_and_can_be_left_out() {
    let place = tempfile::tempdir().unwrap();
    let composite = files(place.path());
    let path = composite.to_str().unwrap();
    let uri = "http://127.0.0.1:1";
    let run = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .args(["run", path, "--for", "1", "--clock", "virtual"])
            .args(more);
        let output = command.env("ROS_MASTER_URI", uri).output().unwrap();
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        (output.status.code(), text)
    };
    let (code, text) = run(&[]);
    assert_ne!(code, Some(0), "{text}");
    assert!(text.contains("a ros-bridge needs the wall clock"), "{text}");
    // the types of the folder are known without the bridge
    let bridge = "{ builtin = \"ros-bridge\", bridge = \"machine\" }";
    let profiles = COMPOSITE.replace(bridge, &format!("{bridge}\nprofile = \"robot\""));
    let bench = "[components.Bench]\nimplementation = { asm = \"bench.asm\" }\n\
                 activity = { period_ms = 100 }\nprofile = \"bench\"\n";
    std::fs::write(&composite, profiles + bench).unwrap();
    std::fs::write(place.path().join("bench.asm"), BENCH).unwrap();
    let (code, text) = run(&["--profile", "bench"]);
    assert!(matches!(code, Some(0 | 1)), "{text}");
    assert!(
        !text.contains("wall clock") && !text.contains("error"),
        "{text}"
    );
}
