//! Services and actions of ROS through a ros-bridge: nodes of rospy with a real master, of Cyclone DDS, and of rclpy on Fast DDS.

use std::path::Path;
use std::process::Command;

use asmotion_ros_domain::{CycloneNode, RclpyNode, domain, python, rclpy};
use asmotion_ros_master::{Master, RospyNode};
use serde_json::{Value, json};

use crate::ros_bridge::Mission;

const EMPTY: &str = "std_msgs/Empty";
const BOOL: &str = "std_msgs/Bool";
const TEXT: &str = "std_msgs/String";
const SET_BOOL: &str = "std_srvs/SetBool";
const MOVE_BASE: &str = "move_base_msgs/MoveBase";
/// Ends of goals in ROS 2.
const SUCCEEDED: u8 = 4;
const CANCELED: u8 = 5;

/// A composite of `tests/ros_calls` that a node asks for calls.
struct Asked {
    // before the master
    mission: Mission,
    person: RospyNode,
    master: Master,
}

impl Asked {
    fn start(name: &str) -> Option<Self> {
        let master = Master::start()?;
        let mut person = master.rospy("/person");
        let mission = Mission::start_in(&master, "ros_calls", name);
        mission.line("registered at the ROS master");
        person.subscribe("/said", TEXT);
        person.obey(json!(["connections", "/said", 1]));
        person.advertise("/ask", EMPTY, 1);
        Some(Self {
            mission,
            person,
            master,
        })
    }

    /// Asks for a call, and returns what is said of it.
    fn ask(&mut self) -> String {
        self.person.publish("/ask", EMPTY, json!({}));
        self.said()
    }

    fn said(&mut self) -> String {
        let (message, _) = self.person.message("/said");
        message["data"].as_str().unwrap().to_owned()
    }
}

#[test]
fn a_specification_calls_a_service_of_rospy_and_knows_why_it_fails() {
    let Some(mut asked) = Asked::start("service") else {
        return;
    };
    asked.person.subscribe("/words", TEXT);
    asked.person.obey(json!(["connections", "/words", 1]));
    assert_eq!(asked.ask(), "NO_SERVER");
    let mut arm = asked.master.rospy("/arm");
    let answer = json!({"reply": {"success": true, "message": "gripped"}});
    arm.obey(json!(["provide", "/arm/set", SET_BOOL, answer]));
    assert_eq!(asked.ask(), "ANSWERED");
    let request = arm.event("request", "/arm/set");
    assert_eq!(request[2], json!({"data": true}));
    // the answer is bound
    let (words, _) = asked.person.message("/words");
    assert_eq!(words, json!({"data": "gripped"}));
    arm.obey(json!(["provide", "/arm/set", SET_BOOL, {"error": "jammed"}]));
    assert_eq!(asked.ask(), "REFUSED");
    arm.obey(json!(["provide", "/arm/set", SET_BOOL, {"delay": 4}]));
    assert_eq!(asked.ask(), "LATE");
    arm.obey(json!(["provide", "/arm/set", SET_BOOL, {"die": true}]));
    assert_eq!(asked.ask(), "SERVER_DIED");
    drop(arm);
    let mut other = asked.master.rospy("/other");
    other.obey(json!(["provide", "/arm/set", "std_srvs/Trigger", {}]));
    assert_eq!(asked.ask(), "OTHER_TYPE");
}

#[test]
fn a_call_of_sca_asm_reaches_a_service_of_rospy() {
    let Some(mut asked) = Asked::start("partner") else {
        return;
    };
    assert_eq!(asked.ask(), "CALL_FAILED");
    let mut arm = asked.master.rospy("/arm");
    let answer = json!({"reply": {"success": true, "message": "gripped"}});
    arm.obey(json!(["provide", "/arm/set", SET_BOOL, answer]));
    assert_eq!(asked.ask(), "gripped");
    let request = arm.event("request", "/arm/set");
    assert_eq!(request[2], json!({"data": true}));
    arm.obey(json!(["provide", "/arm/set", SET_BOOL, {"delay": 3}]));
    assert_eq!(asked.ask(), "CALL_TIMEOUT");
}

/// An action server on `/move`.
fn mover(master: &Master, behaviour: Value) -> RospyNode {
    let mut mover = master.rospy("/mover");
    mover.obey(json!(["act", "/move", MOVE_BASE, behaviour]));
    mover
}

#[test]
fn a_specification_sends_a_goal_to_rospy_and_follows_it() {
    let Some(mut asked) = Asked::start("action") else {
        return;
    };
    let person = &mut asked.person;
    person.subscribe("/told", "std_msgs/Float64");
    person.obey(json!(["connections", "/told", 1]));
    for (topic, kind) in [("/cancel", EMPTY), ("/estop", BOOL)] {
        person.advertise(topic, kind, 1);
    }
    assert_eq!(asked.ask(), "NO_SERVER");
    let at = json!({"base_position": {"pose": {"position": {"x": 1.5}}}});
    let mut mover = mover(&asked.master, json!({"steps": 4, "feedback": at}));
    assert_eq!(asked.ask(), "ARRIVED");
    let goal = mover.event("goal", "/move");
    assert_eq!(goal[2]["target_pose"]["header"]["frame_id"], "map");
    assert_eq!(goal[2]["target_pose"]["pose"]["position"]["x"], 2.5);
    assert_eq!(asked.person.message("/told").0, json!({"data": 1.5}));

    let act = |behaviour: Value| json!(["act", "/move", MOVE_BASE, behaviour]);
    mover.obey(act(json!({"end": "aborted", "text": "no path"})));
    assert_eq!(asked.ask(), "ABORTED");
    mover.event("goal", "/move");

    // a cancellation by the specification
    mover.obey(act(json!({"steps": 600})));
    asked.person.publish("/ask", EMPTY, json!({}));
    mover.event("goal", "/move");
    asked.person.publish("/cancel", EMPTY, json!({}));
    mover.event("preempted", "/move");
    assert_eq!(asked.said(), "PREEMPTED");

    // the caller's deadline
    assert_eq!(asked.ask(), "LATE");
    mover.event("goal", "/move");
    mover.event("preempted", "/move");

    // an emergency stop
    asked.person.publish("/ask", EMPTY, json!({}));
    mover.event("goal", "/move");
    asked.person.publish("/estop", BOOL, json!({"data": true}));
    mover.event("preempted", "/move");
    asked.person.publish("/estop", BOOL, json!({"data": false}));

    // another goal of the same caller
    asked.person.publish("/ask", EMPTY, json!({}));
    mover.event("goal", "/move");
    asked.person.publish("/ask", EMPTY, json!({}));
    mover.event("preempted", "/move");
    mover.event("goal", "/move");
    // the end of the system
    drop(asked.mission);
}

#[test]
fn a_goal_is_rejected_or_lost() {
    let Some(mut asked) = Asked::start("action") else {
        return;
    };
    let mut refuser = asked.master.rospy("/refuser");
    refuser.obey(json!(["reject", "/move", MOVE_BASE]));
    assert_eq!(asked.ask(), "REJECTED");
    drop(refuser);
    let mut mover = mover(&asked.master, json!({"steps": 600}));
    asked.person.publish("/ask", EMPTY, json!({}));
    mover.event("goal", "/move");
    drop(mover);
    assert_eq!(asked.said(), "LOST");
}

#[test]
fn operations_of_components_are_a_service_and_an_action_of_ros() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut person = master.rospy("/person");
    let mission = Mission::start_in(&master, "ros_calls", "offered");
    mission.line("registered at the ROS master");
    for (data, message) in [(true, "gripped"), (false, "let go")] {
        person.obey(json!(["call", "/grip", SET_BOOL, {"data": data}]));
        let response = person.event("response", "/grip");
        assert_eq!(response[2], json!({"success": data, "message": message}));
    }
    let listed = master.tool("rosservice", &["type", "/grip"]);
    assert_eq!(listed.trim(), SET_BOOL);

    let goal =
        json!({"target_pose": {"header": {"frame_id": "map"}, "pose": {"position": {"x": 3.0}}}});
    person.obey(json!(["send", "/drive", MOVE_BASE, goal]));
    person.event("sent", "/drive");
    let end = person.event("end", "/drive");
    assert_eq!(end[2], "SUCCEEDED", "{end}");
    let feedback = person.event("feedback", "/drive");
    assert_eq!(feedback[2]["base_position"]["pose"]["position"]["x"], 1.0);

    // the cancellation may arrive before the goal
    person.obey(json!(["send", "/drive", MOVE_BASE, goal]));
    person.event("sent", "/drive");
    person.obey(json!(["cancel", "/drive"]));
    let end = person.event("end", "/drive");
    assert_eq!(end[2], "PREEMPTED", "{end}");
}

/// A composite of ROS 2 in a domain.
fn mission_of_ros2(name: &str, domain: u16) -> Mission {
    let composite = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ros_calls");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(composite.join(format!("{name}.composite.toml")))
        .args(["--clock", "wall", "--for", "120"])
        .env("ROS_DOMAIN_ID", domain.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env_remove("ROS_LOCALHOST_ONLY");
    let mission = Mission::spawn(command);
    mission.line(&format!("joined the ROS 2 domain {domain}"));
    mission
}

/// The mapping of services is that of rmw_cyclonedds.
#[test]
fn operations_of_components_are_a_service_and_an_action_of_ros_2() {
    let Some(python) = python() else { return };
    let domain = domain();
    let _mission = mission_of_ros2("offered_ros2", domain);
    let mut person = CycloneNode::start(&python, domain, "person");
    person.client("/grip", "std_srvs/srv/SetBool");
    for (data, message) in [(true, "gripped"), (false, "let go")] {
        let response = person.call("/grip", &json!({"data": data}));
        assert_eq!(response, json!({"success": data, "message": message}));
    }
    let (drive, goal) = ("/drive", json!({"target": {"x": 3.0, "y": 0.0, "z": 0.0}}));
    person.action_client(drive, "nav2_msgs/action/DriveOnHeading");
    person.send_goal(drive, &goal);
    assert_eq!(person.goal_number(drive, "accepted"), 1);
    let feedback: Vec<_> = (1..=20)
        .map(|_| person.message("/drive/feedback"))
        .collect();
    let expected: Vec<_> = (1..=20u8)
        .map(|steps| json!({"distance_traveled": f32::from(steps)}))
        .collect();
    assert_eq!(feedback, expected);
    assert_eq!(person.goal_number(drive, "status"), SUCCEEDED);
    person.message("/drive/result");
    person.send_goal(drive, &goal);
    assert_eq!(person.goal_number(drive, "accepted"), 1);
    person.message("/drive/feedback");
    person.cancel_goal(drive);
    assert_eq!(person.goal_number(drive, "cancelling"), 1);
    assert_eq!(person.goal_number(drive, "status"), CANCELED);
}

/// The mapping of services is that of rmw_fastrtps.
#[test]
fn operations_of_components_are_services_of_rclpy() {
    let Some(python) = rclpy() else { return };
    let domain = domain();
    let _mission = mission_of_ros2("offered_ros2", domain);
    let mut person = RclpyNode::start(&python, domain, "person");
    for (data, message) in [(true, "gripped"), (false, "let go")] {
        person.obey(&json!(["call", "/grip", "std_srvs/srv/SetBool", {"data": data}]));
        let response = person.event("response", "/grip");
        assert_eq!(response, [json!({"success": data, "message": message})]);
    }
}

/// The other direction: a specification calls a service of rclpy.
#[test]
fn a_specification_calls_a_service_of_rclpy() {
    let Some(python) = rclpy() else { return };
    let domain = domain();
    let mut arm = RclpyNode::start(&python, domain, "arm");
    let reply = json!({"success": true, "message": "closed"});
    arm.obey(&json!([
        "provide",
        "/arm/set",
        "std_srvs/srv/SetBool",
        reply
    ]));
    arm.obey(&json!(["subscribe", "/said", "std_msgs/msg/String"]));
    let _mission = mission_of_ros2("partner_ros2", domain);
    arm.obey(&json!(["matches", "/said", 1]));
    arm.obey(&json!(["publish", "/ask", "std_msgs/msg/Empty", null]));
    arm.obey(&json!(["matches", "/ask", 1]));
    // a server is found when both sides have discovered it
    loop {
        arm.obey(&json!(["publish", "/ask", "std_msgs/msg/Empty", {}]));
        let said = arm.event("message", "/said");
        if said == [json!({"data": "closed"})] {
            break;
        }
        assert_eq!(said, [json!({"data": "CALL_FAILED"})]);
    }
    assert_eq!(arm.event("request", "/arm/set"), [json!({"data": true})]);
}

#[test]
fn a_goal_that_is_aborted_keeps_its_result() {
    let Some(mut asked) = Asked::start("failure") else {
        return;
    };
    asked.person.subscribe("/left", "nav_msgs/OccupancyGrid");
    asked.person.obey(json!(["connections", "/left", 1]));
    let mut mapper = asked.master.rospy("/mapper");
    let act = |end: &str| {
        let map = json!({"info": {"width": 2, "height": 1}, "data": [0, 100]});
        let behaviour = json!({"end": end, "text": "no way", "result": {"map": map}});
        json!(["act", "/explore", "nav_msgs/GetMap", behaviour])
    };
    mapper.obey(act("aborted"));
    assert_eq!(asked.ask(), "REFUSED");
    let (left, _) = asked.person.message("/left");
    assert_eq!(left["info"]["width"], json!(2));
    assert_eq!(left["data"], json!([0, 100]));
    // the result of a goal that succeeds is the answer
    mapper.obey(act("succeeded"));
    assert_eq!(asked.ask(), "ANSWERED");
    assert_eq!(asked.person.waiting("/left"), 0);
}
