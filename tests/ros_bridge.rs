//! Composites that join a system of ROS 1 through a ros-bridge: nodes of rospy, and a real master.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use asmotion_ros_master::{Master, SOON};
use serde_json::json;

use crate::processes::through;

fn composite(folder: &str, name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/{folder}/{name}.composite.toml"))
}

/// A running composite, with the lines of its story and of its summary.
pub struct Mission {
    child: Child,
    lines: Receiver<String>,
}

impl Mission {
    fn start(master: &Master, name: &str) -> Self {
        Self::start_in(master, "ros_bridge", name)
    }

    /// Starts a composite of a folder of `tests`.
    pub(crate) fn start_in(master: &Master, folder: &str, name: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .arg("run")
            .arg(composite(folder, name))
            .args(["--clock", "wall", "--for", "120"])
            .env("ROS_MASTER_URI", master.uri());
        Self::spawn(command)
    }

    /// Starts a command that prints a story.
    pub fn spawn(mut command: Command) -> Self {
        command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let output = child.stderr.take().unwrap();
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self { child, lines }
    }

    /// Ends the run as Ctrl-C does.
    pub fn interrupt(&self) {
        let process = self.child.id().to_string();
        let status = Command::new("kill").args(["-INT", &process]).status();
        assert!(status.unwrap().success());
    }

    /// The next line of the story with this text.
    pub fn line(&self, text: &str) -> String {
        let mut before = Vec::new();
        loop {
            match self.lines.recv_timeout(SOON) {
                Ok(line) if line.contains(text) => return line,
                Ok(line) => before.push(line),
                Err(_) => panic!("no line with `{text}`, only {before:#?}"),
            }
        }
    }
}

impl Mission {
    /// Sends a signal such as `-TERM`.
    pub(crate) fn signal(&self, signal: &str) {
        let process = self.child.id().to_string();
        let sent = Command::new("kill").args([signal, &process]).status();
        assert!(sent.unwrap().success());
    }

    /// Waits for its end.
    pub(crate) fn end(mut self) {
        self.child.wait().unwrap();
    }
}

impl Drop for Mission {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

const LIMIT: &str = "/speed_limit";
const INT: &str = "std_msgs/Int32";
const BOOL: &str = "std_msgs/Bool";
const EMPTY: &str = "std_msgs/Empty";

#[test]
fn r2_an_emergency_stop_serves_a_robot_of_ros() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut robot = master.rospy("/driver");
    robot.subscribe(LIMIT, INT);
    let mission = Mission::start(&master, "estop");
    mission.line("registered at the ROS master");
    // latched: it starts with the limit 0
    let (message, publisher) = robot.message(LIMIT);
    assert_eq!(
        (message, &*publisher),
        (json!({"data": 0}), "/asmotion/estop")
    );
    for (topic, kind) in [
        ("/estop/reset", EMPTY),
        ("/estop/confirm", EMPTY),
        ("/estop/button", BOOL),
    ] {
        robot.advertise(topic, kind, 1);
    }
    let await_limit = |robot: &mut asmotion_ros_master::RospyNode, limit: i32| {
        while robot.message(LIMIT).0 != json!({"data": limit}) {}
    };
    robot.publish("/estop/reset", EMPTY, json!({}));
    mission.line("LATCHED → ARMED");
    robot.publish("/estop/confirm", EMPTY, json!({}));
    await_limit(&mut robot, 2);
    robot.publish("/estop/button", BOOL, json!({"data": true}));
    await_limit(&mut robot, 0);
    // R1: the tools of ROS see the node and its topics
    let listed = master.tool("rosnode", &["list"]);
    assert!(
        listed.lines().any(|node| node == "/asmotion/estop"),
        "{listed}"
    );
    let info = master.tool("rostopic", &["info", LIMIT]);
    assert!(
        info.contains("Type: std_msgs/Int32") && info.contains("* /asmotion/estop"),
        "{info}"
    );
}

const TEXT: &str = "std_msgs/String";

#[test]
fn r10_a_topic_mapped_both_ways_does_not_storm() {
    let Some(master) = Master::start() else {
        return;
    };
    let (mut one, mut other) = (master.rospy("/one"), master.rospy("/other"));
    let mission = Mission::start(&master, "words");
    mission.line("registered at the ROS master");
    other.subscribe("/word", TEXT);
    other.subscribe("/out", TEXT);
    one.advertise("/word", TEXT, 2);
    one.advertise("/in", TEXT, 1);
    other.obey(json!(["connections", "/word", 2]));
    other.obey(json!(["connections", "/out", 1]));
    for word in ["first", "ping", "ping", "last"] {
        one.publish("/word", TEXT, json!({"data": word}));
    }
    // a relay: another topic of ROS, so nothing is suppressed, and all of the above is over
    one.publish("/in", TEXT, json!({"data": "over"}));
    assert_eq!(
        other.message("/out"),
        (json!({"data": "over"}), "/words_RosBridge".to_owned())
    );
    let heard: Vec<_> = (0..6).map(|_| other.message("/word")).collect();
    let of = |node: &str| -> Vec<_> {
        let words = heard.iter().filter(|(_, publisher)| publisher == node);
        words
            .map(|(word, _)| word["data"].as_str().unwrap())
            .collect()
    };
    assert_eq!(of("/one"), ["first", "ping", "ping", "last"]);
    assert_eq!(of("/words_RosBridge"), ["pong", "pong"]);
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(other.waiting("/word"), 0);
}

/// The topics of both processes are their own; each bridge brings what the other one publishes, and does not return it.
#[test]
fn r10_two_processes_that_map_one_topic_both_ways_do_not_storm() {
    let Some(master) = Master::start() else {
        return;
    };
    let (mut one, mut other) = (master.rospy("/one"), master.rospy("/other"));
    let first = Mission::start(&master, "words");
    first.line("registered at the ROS master");
    let words = composite("ros_bridge", "words");
    let place = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(&words).unwrap();
    let text = text.replace("name = \"words\"", "name = \"others\"");
    let specification = words.with_file_name("listener.asm").display().to_string();
    let path = place.path().join("others.composite.toml");
    std::fs::write(&path, text.replace("listener.asm", &specification)).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(&path)
        .args(["--clock", "wall", "--for", "120"])
        .env("ROS_MASTER_URI", master.uri());
    let second = Mission::spawn(command);
    second.line("registered at the ROS master");

    other.subscribe("/word", TEXT);
    // two bridges and the observer hear the speaker, and the observer hears all three
    one.advertise("/word", TEXT, 3);
    other.obey(json!(["connections", "/word", 3]));
    for word in ["first", "ping", "last"] {
        one.publish("/word", TEXT, json!({"data": word}));
    }
    let mut heard: Vec<String> = (0..5)
        .map(|_| {
            let (word, publisher) = other.message("/word");
            format!("{publisher} {}", word["data"].as_str().unwrap())
        })
        .collect();
    heard.sort();
    assert_eq!(
        heard,
        [
            "/one first",
            "/one last",
            "/one ping",
            "/others_RosBridge pong",
            "/words_RosBridge pong",
        ]
    );
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(other.waiting("/word"), 0);
}

/// A composite that relays one topic of ROS to another one.
fn relay(folder: &Path, name: &str, from: &str, to: &str, master: &Master) -> Mission {
    let text = format!(
        r#"schema = "composite/1"

[composite]
name = "{name}"

[bridges.ros]
kind   = "ros1"
master = "${{ROS_MASTER_URI}}"

[components.RosBridge]
implementation = {{ builtin = "ros-bridge", bridge = "ros" }}
activity  = {{ period_ms = 0 }}
subscribe = {{ word = "std_msgs/String" }}
publish   = {{ word = "std_msgs/String" }}
map = [
  {{ from = "word", ros = "{from}", type = "std_msgs/String", direction = "from_ros" }},
  {{ from = "word", ros = "{to}", type = "std_msgs/String", direction = "to_ros" }},
]
"#
    );
    let path = folder.join(format!("{name}.composite.toml"));
    std::fs::write(&path, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(&path)
        .args(["--clock", "wall", "--for", "120"])
        .env("ROS_MASTER_URI", master.uri());
    let mission = Mission::spawn(command);
    mission.line("registered at the ROS master");
    mission
}

#[test]
fn r10_two_processes_that_relay_in_opposite_directions_do_not_storm() {
    let Some(master) = Master::start() else {
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let (mut one, mut other) = (master.rospy("/one"), master.rospy("/other"));
    let there = relay(place.path(), "there", "/a", "/b", &master);
    let back = relay(place.path(), "back", "/b", "/a", &master);
    // both say which connection they do not have
    for (mission, text) in [
        (
            &there,
            "`/back_RosBridge` relays `/b` to `/a`, and this node `/a` to `/b`",
        ),
        (
            &back,
            "`/there_RosBridge` relays `/a` to `/b`, and this node `/b` to `/a`",
        ),
    ] {
        let line = mission.line("messages would go round");
        assert!(line.contains(text), "{line}");
    }
    for topic in ["/a", "/b"] {
        one.advertise(topic, TEXT, 1);
        other.subscribe(topic, TEXT);
        // of the speaker and of a bridge
        other.obey(json!(["connections", topic, 2]));
        one.obey(json!(["connections", topic, 2]));
    }
    for topic in ["/a", "/b"] {
        one.publish(topic, TEXT, json!({"data": topic}));
    }
    let mut heard = Vec::new();
    for topic in ["/a", "/b"] {
        for _ in 0..2 {
            let (word, publisher) = other.message(topic);
            let word = word["data"].as_str().unwrap();
            heard.push(format!("{topic} {publisher} {word}"));
        }
    }
    heard.sort();
    assert_eq!(
        heard,
        [
            "/a /back_RosBridge /b",
            "/a /one /a",
            "/b /one /b",
            "/b /there_RosBridge /a",
        ]
    );
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!((other.waiting("/a"), other.waiting("/b")), (0, 0));
}

#[test]
fn r10_three_processes_that_relay_in_a_circle_do_not_storm() {
    let Some(master) = Master::start() else {
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let (mut one, mut other) = (master.rospy("/one"), master.rospy("/other"));
    let relays = [
        ("first", "/a", "/b"),
        ("second", "/b", "/c"),
        ("third", "/c", "/a"),
    ];
    let [first, second, third] =
        relays.map(|(name, from, to)| relay(place.path(), name, from, to, &master));
    // the last one closes the circle; the first one learns it when the third publishes
    for (mission, text) in [
        (
            &third,
            "`/second_RosBridge` relays `/b` to `/c`, and this node `/c` to `/a`, from where they come through `/a`, `/b`",
        ),
        (
            &first,
            "`/third_RosBridge` relays `/c` to `/a`, and this node `/a` to `/b`, from where they come through `/b`, `/c`",
        ),
    ] {
        let line = mission.line("messages would go round");
        assert!(line.contains(text), "{line}");
    }
    one.advertise("/a", TEXT, 1);
    for (topic, publishers) in [("/a", 2), ("/b", 1), ("/c", 1)] {
        other.subscribe(topic, TEXT);
        other.obey(json!(["connections", topic, publishers]));
    }
    // of the listener and of the first bridge
    one.obey(json!(["connections", "/a", 2]));
    for text in ["word", "again"] {
        one.publish("/a", TEXT, json!({"data": text}));
        for (topic, publisher) in [
            ("/a", "/one"),
            ("/b", "/first_RosBridge"),
            ("/c", "/second_RosBridge"),
        ] {
            let heard = other.message(topic);
            assert_eq!(heard, (json!({"data": text}), publisher.to_owned()));
        }
    }
    std::thread::sleep(Duration::from_millis(500));
    for topic in ["/a", "/b", "/c"] {
        assert_eq!(other.waiting(topic), 0, "{topic}");
    }
    drop(second);
}

/// One robot brings a topic of ROS to the broker, another one that stands for its bridge brings it back: the first one does not
/// receive it again.
#[test]
fn r10_a_circle_over_a_broker_is_noticed() {
    let Some(master) = Master::start() else {
        return;
    };
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let (vhost, place) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
    let start = |name: &str, rest: &str| {
        let text = format!(
            r#"schema = "composite/1"

[composite]
name = "{name}"

[bridges.ros]
kind   = "ros1"
master = "${{ROS_MASTER_URI}}"

[components.RosBridge]
implementation = {{ builtin = "ros-bridge", bridge = "ros" }}
activity  = {{ period_ms = 0 }}
{rest}"#
        );
        let path = place.path().join(format!("{name}.composite.toml"));
        std::fs::write(&path, text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.arg("run").arg(&path);
        command.args(["--clock", "wall", "--for", "120"]);
        command.env("ROS_MASTER_URI", master.uri());
        let mission = Mission::spawn(through(command, &broker, &vhost, None));
        mission.line("registered at the ROS master");
        mission
    };
    let north = start(
        "north",
        r#"publish = { word = "std_msgs/String" }
map = [{ from = "word", ros = "/a", type = "std_msgs/String", direction = "from_ros" }]
"#,
    );
    let _south = start(
        "south",
        r#"ports.in = { word = "std_msgs/String" }
map = [{ from = "word", ros = "/a", type = "std_msgs/String", direction = "to_ros" }]

[components.North]
implementation = { builtin = "remote", target = "robot://north/RosBridge" }

[[connections]]
from = "North.word"
to   = "RosBridge.word"
policy = { type = "buffer", size = 8 }
"#,
    );
    let line = north.line("messages would go round");
    let expected = "`/south_RosBridge` relays the topic `north.RosBridge.word` of the broker to `/a`, and this node `/a` to the topic \
         `north.RosBridge.word` of the broker";
    assert!(line.contains(expected), "{line}");
    let (mut one, mut other) = (master.rospy("/one"), master.rospy("/other"));
    one.advertise("/a", TEXT, 1);
    other.subscribe("/a", TEXT);
    // of the speaker and of the bridge in the south
    other.obey(json!(["connections", "/a", 2]));
    // of the listener and of the bridge in the north
    one.obey(json!(["connections", "/a", 2]));
    for text in ["first", "second"] {
        one.publish("/a", TEXT, json!({"data": text}));
        let mut heard = [other.message("/a"), other.message("/a")];
        heard.sort_by(|one, other| one.1.cmp(&other.1));
        let of = |node: &str| (json!({"data": text}), node.to_owned());
        assert_eq!(heard, [of("/one"), of("/south_RosBridge")]);
    }
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(other.waiting("/a"), 0);
}

#[test]
fn r9_messages_pass_with_stamps_frames_and_without_code() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut peer = master.rospy("/peer");
    let mission = Mission::start(&master, "words");
    mission.line("registered at the ROS master");
    let pose = json!({
        "header": {"seq": 77, "stamp": {"secs": 12, "nsecs": 345}, "frame_id": "map"},
        "pose": {"position": {"x": 1.5, "y": -2.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
    });
    let data: Vec<i8> = (0..160_000u32).map(|cell| (cell % 101) as i8).collect();
    let grid = json!({
        "header": {"seq": 1, "stamp": {"secs": 3, "nsecs": 0}, "frame_id": "map"},
        "info": {"map_load_time": {"secs": 1, "nsecs": 2}, "resolution": 0.5, "width": 400, "height": 400,
            "origin": {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}},
        "data": data,
    });
    for (from, to, kind, message) in [
        ("/pose", "/pose_out", "geometry_msgs/PoseStamped", pose),
        ("/grid", "/grid_out", "nav_msgs/OccupancyGrid", grid),
    ] {
        peer.subscribe(to, kind);
        peer.obey(json!(["connections", to, 1]));
        peer.advertise(from, kind, 1);
        for count in 0..3 {
            peer.publish(from, kind, message.clone());
            let mut expected = message.clone();
            // publishers count
            expected["header"]["seq"] = json!(count);
            let (mut found, _) = peer.message(to);
            // rospy counts from 1, roscpp from 0, and nothing depends on the first
            assert_eq!(found["header"]["seq"], json!(count), "{to}");
            found["header"]["seq"] = json!(count);
            assert_eq!(found, expected, "{to}");
        }
    }
}

/// A message goes from ROS through the proxy into the composite, and back: each of its two cycles is woken, and none waits for a
/// period.
#[test]
fn n6_a_round_trip_through_the_proxy_takes_no_period() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut peer = master.rospy("/peer");
    let mission = Mission::start(&master, "words");
    mission.line("registered at the ROS master");
    peer.subscribe("/out", TEXT);
    peer.obey(json!(["connections", "/out", 1]));
    peer.advertise("/in", TEXT, 1);
    let mut times: Vec<Duration> = (0..51)
        .map(|number| {
            let word = json!({"data": format!("{number}")});
            let begun = Instant::now();
            peer.publish("/in", TEXT, word.clone());
            assert_eq!(peer.message("/out").0, word);
            begun.elapsed()
        })
        .collect();
    times.sort_unstable();
    assert!(times[25] < Duration::from_millis(250), "{times:?}");
}

#[test]
fn r6_a_bridge_waits_for_the_master_and_comes_back_to_it() {
    let Some(mut master) = Master::start() else {
        return;
    };
    master.kill();
    let mission = Mission::start(&master, "words");
    let line = mission.line("not registered at the ROS master");
    assert!(
        line.contains(&format!("127.0.0.1:{}", master.port)),
        "{line}"
    );
    for _ in 0..2 {
        master.restart();
        mission.line("registered at the ROS master");
        let mut peer = master.rospy("/peer");
        peer.subscribe("/out", TEXT);
        peer.obey(json!(["connections", "/out", 1]));
        peer.advertise("/in", TEXT, 1);
        peer.publish("/in", TEXT, json!({"data": "again"}));
        assert_eq!(peer.message("/out").0, json!({"data": "again"}));
        master.kill();
        mission.line("not registered at the ROS master");
    }
}

#[test]
fn r10_a_slow_subscriber_loses_the_oldest_messages() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut fast = master.rospy("/fast");
    let mut slow = master.rospy("/slow");
    let mission = Mission::start(&master, "words");
    mission.line("registered at the ROS master");
    for peer in [&mut fast, &mut slow] {
        peer.subscribe("/out", TEXT);
        peer.obey(json!(["connections", "/out", 1]));
    }
    fast.advertise("/in", TEXT, 1);
    slow.pause();
    let long = "x".repeat(100_000);
    const COUNT: usize = 200;
    for number in 0..COUNT {
        fast.publish("/in", TEXT, json!({"data": format!("{number} {long}")}));
        let (word, _) = fast.message("/out");
        assert!(
            word["data"]
                .as_str()
                .unwrap()
                .starts_with(&format!("{number} "))
        );
    }
    slow.go_on();
    // a few are in the buffers of the kernel, and four in the queue; the newest is among them
    let mut received = Vec::new();
    while received.last() != Some(&(COUNT - 1)) {
        let (word, _) = slow.message("/out");
        let number = word["data"].as_str().unwrap().split(' ').next().unwrap();
        received.push(number.parse::<usize>().unwrap());
    }
    assert!(received.len() < COUNT, "{received:?}");
    assert!(received.is_sorted_by(|a, b| a < b), "{received:?}");
    assert!(
        received.ends_with(&[COUNT - 4, COUNT - 3, COUNT - 2, COUNT - 1]),
        "{received:?}"
    );
}

#[test]
fn r9_fields_are_converted_by_their_units() {
    let Some(master) = Master::start() else {
        return;
    };
    const FLOAT: &str = "std_msgs/Float64";
    let mut peer = master.rospy("/peer");
    let mission = Mission::start(&master, "words");
    mission.line("registered at the ROS master");
    peer.subscribe("/radians", FLOAT);
    peer.obey(json!(["connections", "/radians", 1]));
    peer.advertise("/degrees", FLOAT, 1);
    peer.publish("/degrees", FLOAT, json!({"data": 90.0}));
    let (message, _) = peer.message("/radians");
    let radians = message["data"].as_f64().unwrap();
    assert!(
        (radians - std::f64::consts::FRAC_PI_2).abs() < 1e-9,
        "{message}"
    );
}

#[test]
fn bad_publishers_are_reported_and_disturb_no_other() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut person = master.rospy("/person");
    let mission = Mission::start(&master, "words");
    mission.line("registered at the ROS master");
    person.subscribe("/out", TEXT);
    person.obey(json!(["connections", "/out", 1]));
    person.advertise("/in", TEXT, 1);
    for (behaviour, reported) in [
        ("md5", "has the type `std_msgs/String`"),
        ("utf8", "cannot read"),
        ("huge", "4294967280 bytes; the limit is"),
        ("truncated", "the connection ended after"),
        ("short", "cannot read"),
        ("header", "/in"),
    ] {
        let name = format!("/bad_{behaviour}");
        let bad = master.peer("bad_publisher", &[&name, "/in", behaviour]);
        assert_eq!(bad.line(), "connected", "{behaviour}");
        let line = mission.line(reported);
        assert!(line.contains("RosBridge"), "{line}");
        person.publish("/in", TEXT, json!({"data": behaviour}));
        // what can be read of a bad publisher arrives, too
        while person.message("/out").0 != json!({"data": behaviour}) {}
    }
    let good = master.peer("bad_publisher", &["/good", "/in", "good"]);
    assert_eq!(good.line(), "connected");
    while person.message("/out").0 != json!({"data": "good"}) {}
}

#[test]
fn r6_a_bridge_needs_the_wall_clock() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(composite("ros_bridge", "words"))
        .args(["--speed", "0"]);
    let output = command
        .env("ROS_MASTER_URI", "http://127.0.0.1:1/")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success(), "{text}");
    assert!(text.contains("a ros-bridge needs the wall clock"), "{text}");
}
