//! Bridges that transform messages into another frame: transforms of rospy and of Cyclone DDS.

use std::time::Duration;

use asmotion_ros_domain::{CycloneNode, TopicPolicies, domain, python};
use asmotion_ros_master::{Master, RospyNode};
use serde_json::{Value, json};

use crate::ros_bridge::Mission;

pub(crate) const POSE: &str = "geometry_msgs/PoseStamped";
const PATH: &str = "nav_msgs/Path";
pub(crate) const TRANSFORMS: &str = "tf2_msgs/TFMessage";

fn point(x: f64, y: f64) -> Value {
    json!({ "x": x, "y": y, "z": 0.0 })
}

/// The rotation by a number of quarter turns to the left.
fn quarters(number: i8) -> Value {
    let half = f64::from(number) * std::f64::consts::FRAC_PI_4;
    json!({ "x": 0.0, "y": 0.0, "z": half.sin(), "w": half.cos() })
}

/// A stamp in milliseconds, as ROS 1 names its parts.
pub(crate) fn ros1_stamp(milliseconds: u64) -> Value {
    json!({ "secs": milliseconds / 1000, "nsecs": milliseconds % 1000 * 1_000_000 })
}

fn ros2_stamp(milliseconds: u64) -> Value {
    json!({ "sec": milliseconds / 1000, "nanosec": milliseconds % 1000 * 1_000_000 })
}

pub(crate) fn pose(stamp: Value, frame: &str, x: f64) -> Value {
    let pose = json!({ "position": point(x, 0.0), "orientation": quarters(0) });
    json!({ "header": { "stamp": stamp, "frame_id": frame }, "pose": pose })
}

/// A transform: the child stands at (x, y) of its parent, turned to the left.
pub(crate) fn transform(
    stamp: Value,
    (parent, child): (&str, &str),
    (x, y): (f64, f64),
    turns: i8,
) -> Value {
    json!({
        "header": { "stamp": stamp, "frame_id": parent }, "child_frame_id": child,
        "transform": { "translation": point(x, y), "rotation": quarters(turns) },
    })
}

pub(crate) fn transforms(all: &[Value]) -> Value {
    json!({ "transforms": all })
}

/// Position, yaw in quarter turns, and frame of a pose, rounded.
fn place(message: &Value) -> (f64, f64, f64, String) {
    let rounded = |number: f64| (number * 1e6).round() / 1e6 + 0.0;
    let number = |pointer: &str| message.pointer(pointer).unwrap().as_f64().unwrap();
    let (z, w) = (number("/pose/orientation/z"), number("/pose/orientation/w"));
    let yaw = 2.0 * z.atan2(w) / std::f64::consts::FRAC_PI_2;
    let frame = message["header"]["frame_id"].as_str().unwrap();
    let (x, y) = (number("/pose/position/x"), number("/pose/position/y"));
    (rounded(x), rounded(y), rounded(yaw), frame.to_owned())
}

/// A robot of rospy that publishes transforms and goals.
struct Robot(RospyNode);

impl Robot {
    fn start(master: &Master, name: &str) -> Self {
        let mut node = master.rospy(name);
        node.advertise("/tf", TRANSFORMS, 1);
        Self(node)
    }

    /// The laser stands 0.5 m before the base, and looks to the left.
    fn mount(&mut self) {
        let mounted = transform(ros1_stamp(0), ("base", "laser"), (0.5, 0.0), 1);
        self.0.obey(json!([
            "publish",
            "/tf_static",
            TRANSFORMS,
            transforms(&[mounted]),
            true
        ]));
    }

    /// The base is at x of the odometry, whose origin is at (10, 0) of the map.
    fn drive(&mut self, milliseconds: u64, x: f64) {
        let stamp = || ros1_stamp(milliseconds);
        let moved = [
            transform(stamp(), ("map", "odom"), (10.0, 0.0), 0),
            transform(stamp(), ("odom", "base"), (x, 0.0), 0),
        ];
        self.0.publish("/tf", TRANSFORMS, transforms(&moved));
    }

    fn give_goal(&mut self, milliseconds: u64, frame: &str, x: f64) {
        self.0
            .publish("/goal", POSE, pose(ros1_stamp(milliseconds), frame, x));
    }
}

#[test]
fn poses_of_ros_1_are_transformed_at_their_time() {
    let Some(master) = Master::start() else {
        return;
    };
    let mission = Mission::start_in(&master, "ros_frames", "frames");
    mission.line("registered at the ROS master");
    let mut desk = master.rospy("/desk");
    desk.subscribe("/goal_in_map", POSE);
    desk.obey(json!(["connections", "/goal_in_map", 1]));
    let mut robot = Robot::start(&master, "/robot");
    robot.0.advertise("/goal", POSE, 1);
    // static transforms are latched, and those of /tf interpolated
    robot.mount();
    for (at, x) in [(100_000, 1.0), (101_000, 2.0)] {
        robot.drive(at, x);
    }
    let goal = |desk: &mut RospyNode| place(&desk.message("/goal_in_map").0);
    robot.give_goal(100_500, "laser", 3.0);
    assert_eq!(goal(&mut desk), (12.0, 3.0, 1.0, "map".to_owned()));
    // the latest transform, and a message that is in the frame already
    robot.give_goal(0, "base", 1.0);
    assert_eq!(goal(&mut desk), (13.0, 0.0, 0.0, "map".to_owned()));
    robot.give_goal(7, "/map", 5.0);
    assert_eq!(goal(&mut desk), (5.0, 0.0, 0.0, "map".to_owned()));
    // a message waits for the transform at its time, and the next one does not overtake it
    robot.give_goal(102_000, "base", 0.0);
    robot.give_goal(100_000, "base", 0.0);
    robot.drive(102_500, 3.5);
    assert_eq!(goal(&mut desk), (13.0, 0.0, 0.0, "map".to_owned()));
    assert_eq!(goal(&mut desk), (11.0, 0.0, 0.0, "map".to_owned()));
    // in vain
    robot.give_goal(110_000, "base", 0.0);
    let line = mission.line("was dropped");
    assert!(
        line.contains("between `goal` and `/goal`")
            && line.contains(
                "younger than all transforms from `base` to `odom` (by 7.500 s, after a wait of 15"
            ),
        "{line}"
    );
    for (at, frame, reason) in [
        (
            60_000,
            "base",
            "older than all transforms from `base` to `odom` (by 40.000 s)",
        ),
        (100_500, "camera", "no transform has the frame `camera`"),
        (100_500, "", "its `header.frame_id` is empty"),
    ] {
        robot.give_goal(at, frame, 0.0);
        let line = mission.line("was dropped");
        assert!(line.contains(reason), "{line}");
    }
    // a publisher that starts again, with an earlier time
    drop(robot);
    let mut robot = Robot::start(&master, "/robot");
    robot.0.advertise("/goal", POSE, 1);
    robot.mount();
    for (at, x) in [(5000, 1.0), (6000, 2.0)] {
        robot.drive(at, x);
    }
    // transforms and goals come by two connections
    while desk.waiting("/goal_in_map") == 0 {
        robot.give_goal(5500, "laser", 3.0);
        std::thread::sleep(Duration::from_millis(100));
    }
    assert_eq!(goal(&mut desk), (12.0, 3.0, 1.0, "map".to_owned()));
}

#[test]
fn transforms_of_a_robot_in_a_namespace_are_taken() {
    let Some(master) = Master::start() else {
        return;
    };
    let mission = Mission::start_in(&master, "ros_frames", "namespace");
    mission.line("registered at the ROS master");
    let mut desk = master.rospy("/desk");
    desk.subscribe("/rover/goal_in_map", POSE);
    desk.obey(json!(["connections", "/rover/goal_in_map", 1]));
    // another robot has the same frames
    let placed = |parent, child, x| transform(ros1_stamp(0), (parent, child), (x, 0.0), 0);
    let publish = |topic: &str, transform| {
        json!(["publish", topic, TRANSFORMS, transforms(&[transform]), true])
    };
    let mut robot = master.rospy("/driver");
    robot.obey(publish("/tf", placed("map", "base", 100.0)));
    robot.obey(publish("/tf_static", placed("base", "laser", 100.0)));
    robot.obey(publish("/rover/tf", placed("map", "base", 10.0)));
    robot.obey(publish("/rover/tf_static", placed("base", "laser", 0.5)));
    robot.advertise("/rover/goal", POSE, 1);
    robot.publish("/rover/goal", POSE, pose(ros1_stamp(0), "laser", 3.0));
    let goal = place(&desk.message("/rover/goal_in_map").0);
    assert_eq!(goal, (13.5, 0.0, 0.0, "map".to_owned()));
}

#[test]
fn a_path_to_ros_is_transformed_without_waiting() {
    let Some(master) = Master::start() else {
        return;
    };
    let mission = Mission::start_in(&master, "ros_frames", "frames");
    mission.line("registered at the ROS master");
    let mut desk = master.rospy("/desk");
    desk.subscribe("/local_plan", PATH);
    desk.obey(json!(["connections", "/local_plan", 1]));
    let mut robot = Robot::start(&master, "/robot");
    robot.0.advertise("/plan", PATH, 1);
    let path = |at: u64| {
        let poses = [
            pose(ros1_stamp(0), "", 12.0),
            pose(ros1_stamp(at + 9000), "map", 13.0),
        ];
        json!({ "header": { "stamp": ros1_stamp(at), "frame_id": "map" }, "poses": poses })
    };
    robot.0.publish("/plan", PATH, path(1000));
    let line = mission.line("was dropped");
    assert!(
        line.contains("no transform has the frame `odom` (after a wait of 0 ms)"),
        "{line}"
    );
    robot.drive(1000, 0.0);
    // transforms and plans come by two connections
    let plan = loop {
        robot.0.publish("/plan", PATH, path(1000));
        std::thread::sleep(Duration::from_millis(100));
        if desk.waiting("/local_plan") > 0 {
            break desk.message("/local_plan").0;
        }
    };
    assert_eq!(plan["header"]["frame_id"], "odom");
    let places = [&plan["poses"][0], &plan["poses"][1]].map(place);
    let odom = || "odom".to_owned();
    assert_eq!(places, [(2.0, 0.0, 0.0, odom()), (3.0, 0.0, 0.0, odom())]);
}

#[test]
fn two_bridges_have_transforms_of_their_own() {
    let (Some(python), Some(master)) = (python(), Master::start()) else {
        return;
    };
    let domain = domain();
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/ros_frames/both.composite.toml"
    );
    let mut command = crate::ros2_bridge::run(path.as_ref(), domain);
    command.env("ROS_MASTER_URI", master.uri());
    let mission = Mission::spawn(command);
    mission.line("registered at the ROS master");
    let mut taker = CycloneNode::start(&python, domain, "taker");
    taker.subscribe("/goal", POSE, TopicPolicies::default());
    taker.await_publishers("/goal", 1);
    // two publishers of one topic; static transforms are transient local
    taker.advertise("/tf_static", TRANSFORMS, TopicPolicies::latched(1), 1);
    taker.advertise("/tf", TRANSFORMS, TopicPolicies::default(), 1);
    // in ROS 1, the map of the giver; in ROS 2, that of the taker
    let mut giver = Robot::start(&master, "/giver");
    giver.0.advertise("/goal", POSE, 1);
    let in_hall = transform(ros1_stamp(0), ("hall", "map"), (100.0, 0.0), 0);
    giver.0.publish("/tf", TRANSFORMS, transforms(&[in_hall]));
    let in_hall = |stamp: u64, x: f64| transform(ros2_stamp(stamp), ("hall", "map"), (x, 0.0), 2);
    taker.publish("/tf", &transforms(&[in_hall(5000, 50.0)]));
    taker.publish("/tf", &transforms(&[in_hall(7000, 50.0)]));
    // turned by half a turn: (50 - 101, 0)
    giver.give_goal(0, "map", 1.0);
    let expected = (-51.0, 0.0, 2.0, "map".to_owned());
    let found = place(&taker.message("/goal"));
    assert_eq!((found.0, found.1, found.2.abs(), found.3), expected);
    // the publisher of ROS 2 is killed, and another one knows better
    taker.kill();
    mission.line("no longer answers");
    let mut taker = CycloneNode::start(&python, domain, "taker");
    taker.subscribe("/goal", POSE, TopicPolicies::default());
    taker.await_publishers("/goal", 1);
    taker.advertise("/tf_static", TRANSFORMS, TopicPolicies::latched(1), 1);
    taker.publish("/tf_static", &transforms(&[in_hall(0, 0.0)]));
    let found = loop {
        giver.give_goal(0, "map", 1.0);
        let found = place(&taker.message("/goal"));
        if found.0 == -101.0 {
            break found;
        }
    };
    assert_eq!(found.3, "map");
}
