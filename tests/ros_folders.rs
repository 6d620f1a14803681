//! Bridges whose messages, services and actions are defined in folders: messages of rospy, an action of rclpy, and wrong folders.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use asmotion_ros_domain::{RclpyNode, domain, rclpy, test_definitions};
use asmotion_ros_master::Master;
use serde_json::json;

use crate::processes::{Running, queues, through, tool};
use crate::ros_bridge::Mission;
use crate::ros2_bridge;

pub(crate) const GAUGE: &str = "acme_msgs/Gauge";

pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ros_folders")
}

/// Exit code, and standard output and error together.
fn asmotion(arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = command.args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let all = text(&output.stdout) + &text(&output.stderr);
    (output.status.code().unwrap(), all)
}

/// A definition in the form of the header of a connection, from which rospy makes its own classes and sums.
pub(crate) fn full_text() -> String {
    let read = |name: &str| {
        fs::read_to_string(folder().join(format!("msgs/acme_msgs/msg/{name}.msg"))).unwrap()
    };
    let line = "=".repeat(80);
    let header = "uint32 seq\ntime stamp\nstring frame_id\n";
    format!(
        "{}\n{line}\nMSG: std_msgs/Header\n{header}\n{line}\nMSG: acme_msgs/Reading\n{}",
        read("Gauge"),
        read("Reading")
    )
}

#[test]
fn messages_of_a_folder_pass_to_and_from_rospy() {
    let Some(master) = Master::start() else {
        return;
    };
    let mission = Mission::start_in(&master, "ros_folders", "gauge");
    mission.line("registered at the ROS master");
    let mut machine = master.rospy("/machine");
    machine.obey(json!(["define", GAUGE, full_text()]));
    for topic in ["/gauge_out", "/verdict"] {
        machine.subscribe(topic, GAUGE);
        machine.obey(json!(["connections", topic, 1]));
    }
    machine.advertise("/gauge", GAUGE, 1);
    let gauge = |state: u8| {
        json!({
            "header": {"seq": 0, "stamp": {"secs": 12, "nsecs": 5}, "frame_id": "pump"},
            "name": "größe", "state": state,
            "readings": [{"pressure": 2.5, "limits": [1.0, 3.0]}, {"pressure": 2.75, "limits": [0.0, 0.5]}],
        })
    };
    machine.publish("/gauge", GAUGE, gauge(0));
    let (mut relayed, publisher) = machine.message("/gauge_out");
    relayed["header"]["seq"] = json!(0);
    assert_eq!((relayed, &*publisher), (gauge(0), "/gauge_RosBridge"));
    machine.publish("/gauge", GAUGE, gauge(1));
    let (verdict, _) = machine.message("/verdict");
    assert_eq!(
        (&verdict["state"], &verdict["name"], &verdict["readings"]),
        (&json!(1), &json!("watcher"), &json!([]))
    );
}

#[test]
fn a_composite_with_definitions_is_checked_described_and_expanded() {
    let composite = folder().join("gauge.composite.toml");
    let path = composite.to_str().unwrap();
    let (code, text) = asmotion(&["check", path]);
    assert_eq!(code, 0, "{text}");
    let (code, text) = asmotion(&["describe", "--asyncapi", path]);
    assert_eq!(code, 0, "{text}");
    for part in ["acme_msgs/Gauge", "pressure", "limits"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // the expansion names the folder from its own place
    let (code, text) = asmotion(&["expand", path]);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains(r#"definitions = ["msgs"]"#), "{text}");
    let beside = tempfile::Builder::new()
        .suffix(".composite.toml")
        .tempfile_in(folder())
        .unwrap();
    fs::write(beside.path(), &text).unwrap();
    // followed by the warnings about defaults
    let (code, again) = asmotion(&["expand", beside.path().to_str().unwrap()]);
    assert!(code == 0 && again.starts_with(&text), "{again}");
    assert!(!again.contains("`transforms` has no effect"), "{again}");
}

/// A copy of the composite and its folder, with one file changed.
fn copy(file: &str, change: impl Fn(String) -> String) -> tempfile::TempDir {
    let copy = tempfile::tempdir().unwrap();
    let messages = copy.path().join("msgs/acme_msgs/msg");
    fs::create_dir_all(&messages).unwrap();
    for name in [
        "gauge.composite.toml",
        "watcher.asm",
        "msgs/acme_msgs/msg/Gauge.msg",
        "msgs/acme_msgs/msg/Reading.msg",
    ] {
        let mut text = fs::read_to_string(folder().join(name)).unwrap();
        if name == file {
            text = change(text);
        }
        fs::write(copy.path().join(name), text).unwrap();
    }
    copy
}

#[test]
fn a_wrong_definition_is_reported_with_its_file_and_line() {
    let cases = [
        (
            "msgs/acme_msgs/msg/Reading.msg",
            "float64 pressure  # bar",
            "float64 2pressure",
            &["C175", "Reading.msg:1:1", "`2pressure` is not a name"][..],
        ),
        (
            "msgs/acme_msgs/msg/Gauge.msg",
            "uint8 state",
            "wstring state",
            &["C175", "Gauge.msg:6:1", "not a type of this generation"],
        ),
        // a missing definition of a field, where the message is used
        (
            "msgs/acme_msgs/msg/Gauge.msg",
            "Reading[] readings",
            "Reeding[] readings",
            &["C170", "Gauge.msg: ", "`acme_msgs/msg/Reeding`"],
        ),
        (
            "gauge.composite.toml",
            "[\"msgs\"]",
            "[\"massages\"]",
            &["C175", "gauge.composite.toml:10:17", "massages"],
        ),
        (
            "gauge.composite.toml",
            "[\"msgs\"]",
            "[\"msgs/acme_msgs/msg/..\", \"msgs/acme_msgs/msg\"]",
            &["C175", "gauge.composite.toml:10:", "no definitions"],
        ),
    ];
    for (file, right, wrong, expected) in cases {
        let copy = copy(file, |text| {
            assert!(text.contains(right), "{text}");
            text.replace(right, wrong)
        });
        let composite = copy.path().join("gauge.composite.toml");
        let (code, text) = asmotion(&["check", composite.to_str().unwrap()]);
        assert_eq!(code, 1, "{text}");
        for part in expected {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}

/// A run takes no new definitions, so a version with another one is refused, with the name of the type.
#[test]
fn a_definition_that_changes_while_the_system_runs_needs_a_start() {
    let (Some(master), Some(broker)) = (Master::start(), asmotion_broker::calm()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let copy = copy("", |text| text);
    let path = copy.path().join("gauge.composite.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(&path);
    command.args(["--json", "--for", "120", "--clock", "wall"]);
    command.env("ROS_MASTER_URI", master.uri());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let _run = Running::start(&mut through(command, &broker, &vhost, None));
    queues(&vhost, "robots.services.gauge.control");
    let reconfigure = || {
        let (code, out, err) = tool(&broker, &url, &["reconfigure", path.to_str().unwrap()]);
        (code, out + &err)
    };
    let (code, err) = reconfigure();
    assert_eq!(code, Some(0), "{err}");
    let reading = copy.path().join("msgs/acme_msgs/msg/Reading.msg");
    let text = fs::read_to_string(&reading).unwrap();
    fs::write(&reading, text + "float64 temperature\n").unwrap();
    let (code, err) = reconfigure();
    assert_eq!(code, Some(1), "{err}");
    for part in ["NEEDS_START", "the definition of `acme_msgs/Gauge`"] {
        assert!(err.contains(part), "{part}: {err}");
    }
}

/// A specification that calls an action of a node of rclpy, and one that offers it, in the same system.
const FIBONACCI: &str = r#"schema = "composite/1"

[composite]
name = "fibonacci"

[bridges.ros]
kind        = "ros2"
definitions = ["DEFINITIONS"]

[components.Caller]
implementation = { asm = "SPECIFICATIONS/caller.asm" }
activity   = { period_ms = 0 }
references = { count = "test_msgs/Fibonacci" }
subscribe  = { ask = "std_msgs/Empty" }
publish    = { said = "std_msgs/String", words = "std_msgs/String" }

[components.Caller.bind.monitored]
asked   = { topic = "ask", edge = true }
outcome = { value = "NOTHING" }

[components.Caller.bind.out]
said = { topic = "said", field = "data", publish = "on_update" }

[components.Caller.bind.out.command]
CALL = { call = "count.call", with = { order = 7 }, keep = "answer", ok = "ANSWERED", failed = "FAILED", timeout = "LATE", event = "outcome" }
SAY  = { publish = "words", value = { data = "counted" } }

[components.Driver]
implementation = { asm = "SPECIFICATIONS/driver.asm" }
activity = { period_ms = 50 }
services = { driving = "test_msgs/Fibonacci" }

[components.RosBridge]
implementation = { builtin = "ros-bridge", bridge = "ros" }
activity   = { period_ms = 0 }
services   = { count = "test_msgs/Fibonacci" }
references = { driving = "test_msgs/Fibonacci" }
subscribe  = { said = "std_msgs/String" }
publish    = { ask = "std_msgs/Empty" }
map = [
  { from = "count.call", ros = "/count", type = "test_msgs/Fibonacci", direction = "to_ros", cancel = "count.cancel" },
  { from = "driving.call", ros = "/drive", type = "test_msgs/action/Fibonacci", direction = "from_ros" },
  { from = "ask", ros = "/ask", type = "std_msgs/Empty", direction = "from_ros" },
  { from = "said", ros = "/said", type = "std_msgs/String", direction = "to_ros" },
]

[[wires]]
reference  = "Caller.count"
service    = "ros:/count"
timeout_ms = 20000

[[wires]]
reference  = "RosBridge.driving"
service    = "Driver.driving"
timeout_ms = 20000
"#;

#[test]
fn an_action_of_a_folder_passes_to_and_from_rclpy() {
    let Some(python) = rclpy() else { return };
    let (domain, place) = (domain(), tempfile::tempdir().unwrap());
    let composite = place.path().join("fibonacci.composite.toml");
    let specifications = folder().parent().unwrap().join("ros_calls");
    let text = FIBONACCI.replace("DEFINITIONS", &test_definitions().display().to_string());
    let text = text.replace("SPECIFICATIONS", &specifications.display().to_string());
    fs::write(&composite, text).unwrap();

    let of = "test_msgs/action/Fibonacci";
    let mut peer = RclpyNode::start(&python, domain, "peer");
    peer.obey(&json!(["act", "/count", of, 3]));
    peer.obey(&json!(["subscribe", "/said", "std_msgs/msg/String"]));
    let mission = Mission::spawn(ros2_bridge::run(&composite, domain));
    mission.line(&format!("joined the ROS 2 domain {domain}"));
    peer.obey(&json!(["matches", "/said", 1]));
    peer.obey(&json!(["publish", "/ask", "std_msgs/msg/Empty", null]));
    peer.obey(&json!(["matches", "/ask", 1]));
    // until both sides have found the server
    loop {
        peer.obey(&json!(["publish", "/ask", "std_msgs/msg/Empty", {}]));
        let said = peer.event("message", "/said");
        if said == [json!({"data": "ANSWERED"})] {
            break;
        }
        assert_eq!(said, [json!({"data": "FAILED"})]);
    }
    assert_eq!(peer.event("goal", "/count"), [json!({"order": 7})]);

    // the other direction: the specification takes 1 s for each goal
    peer.obey(&json!(["send", "/drive", of, {"order": 4}]));
    peer.event("accepted", "/drive");
    assert_eq!(
        peer.event("end", "/drive"),
        [json!(4), json!({"sequence": []})]
    );
    peer.obey(&json!(["send", "/drive", of, {"order": 4}]));
    peer.event("accepted", "/drive");
    peer.obey(&json!(["cancel", "/drive"]));
    assert_eq!(peer.event("cancelling", "/drive"), [json!(1)]);
    assert_eq!(peer.event("end", "/drive")[0], json!(5));
}
