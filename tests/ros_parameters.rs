//! Components of composites in a system of ROS: properties as parameters, and managed nodes. Peers are rospy and Cyclone DDS.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use asmotion_ros_domain::{CycloneNode, TopicPolicies, domain, python};
use asmotion_ros_master::{Master, Process, eventually};
use serde_json::{Value, json};

use crate::ros_bridge::Mission;

fn composite(name: &str) -> PathBuf {
    let file = format!("tests/ros_parameters/{name}.composite.toml");
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

/// A node of rospy that sets and reads parameters.
struct Tool(Process);

impl Tool {
    fn start(master: &Master) -> Self {
        let peer = master.peer("parameters", &["tool"]);
        assert_eq!(peer.line(), "ready");
        Self(peer)
    }

    fn ask(&mut self, line: &str) -> String {
        self.0.tell(line);
        self.0.line()
    }

    fn set(&mut self, name: &str, value: &str) {
        assert_eq!(self.ask(&format!("set {name} {value}")), "set");
    }

    /// Sets a parameter until the component has taken the value, which it then has in place of `refused`. Of several values in one
    /// cycle, the last counts, so it tries again with longer rests.
    fn set_until_taken(&mut self, mission: &Mission, name: &str, (value, refused): (&str, &str)) {
        let mut rest = Duration::from_millis(100);
        loop {
            self.set(name, value);
            std::thread::sleep(rest);
            self.set(name, refused);
            let line = mission.line("is set back to");
            if line.contains(&format!("is set back to {value}")) {
                return;
            }
            rest = (2 * rest).min(Duration::from_secs(5));
        }
    }

    /// Waits until a parameter has a value, in JSON.
    fn wait(&mut self, name: &str, value: &str) {
        eventually(&format!("{name} is {value}"), || {
            (self.ask(&format!("get {name}")) == value).then_some(())
        });
    }
}

#[test]
fn properties_are_parameters_of_ros_1_and_follow_them() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut tool = Tool::start(&master);
    // set before, as a launch file does: it goes to the component
    tool.set("/robot/follower/max_turn", "0.75");
    let mission = Mission::start_in(&master, "ros_parameters", "ros1");
    mission.line("registered at the ROS master");
    tool.wait("/robot/follower/max_speed", "0.7");
    // a value out of range is refused, and the master has that of the component again
    tool.set("/robot/follower/max_turn", "99.5");
    let line = mission.line("is set back to 0.75");
    for part in ["`follower/max_turn`", "must be between", "20.0"] {
        assert!(line.contains(part), "{part}: {line}");
    }
    tool.wait("/robot/follower/max_turn", "0.75");
    tool.wait("/robot/follower/goal_heading", "true");
    tool.wait("/robot/follower/mount", "[0.0, 0.0, 0.0]");
    eventually("a single property has its name", || {
        tool.ask("get /map/cells").parse::<u32>().ok()
    });
    // an integer for a number, as people write it
    tool.set_until_taken(&mission, "/robot/follower/max_speed", ("1", "-1"));
    tool.wait("/robot/follower/max_speed", "1.0");
    tool.set("/robot/follower/goal_heading", "\"maybe\"");
    mission.line("`follower/goal_heading` is set back to true");
    tool.wait("/robot/follower/goal_heading", "true");
    // one that is deleted comes back
    assert_eq!(tool.ask("delete /robot/follower/max_speed"), "deleted");
    tool.wait("/robot/follower/max_speed", "1.0");
    tool.set_until_taken(&mission, "/map/cells", ("4000000", "-1"));
}

#[test]
fn parameters_of_ros_1_come_back_with_the_master_and_end_with_the_run() {
    let Some(mut master) = Master::start() else {
        return;
    };
    let mut tool = Tool::start(&master);
    let mission = Mission::start_in(&master, "ros_parameters", "ros1");
    mission.line("registered at the ROS master");
    tool.wait("/robot/follower/max_speed", "0.7");
    tool.set_until_taken(&mission, "/robot/follower/max_speed", ("0.9", "-1"));
    // another master knows no parameters
    master.restart();
    tool.wait("/robot/follower/max_speed", "0.9");
    tool.set("/theirs", "1");
    mission.interrupt();
    eventually("the parameters of the run are gone", || {
        let listed = tool.ask("list");
        let is_over = !listed.contains("/robot/") && listed.contains("/theirs");
        is_over.then_some(())
    });
}

fn run(domain: u16) -> Mission {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(composite("ros2"))
        .args(["--clock", "wall", "--for", "120"])
        .env("ROS_DOMAIN_ID", domain.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env_remove("ROS_LOCALHOST_ONLY");
    let mission = Mission::spawn(command);
    mission.line(&format!("joined the ROS 2 domain {domain}"));
    mission
}

fn double(value: f64) -> Value {
    json!({ "type": 3, "double_value": value })
}

fn parameter(name: &str, value: &Value) -> Value {
    json!({ "name": name, "value": value })
}

/// The value of a parameter without the empty fields for other types.
fn values(response: &Value) -> Vec<Value> {
    let values = response["values"].as_array().unwrap().iter();
    let value = |it: &Value| match it["type"].as_u64().unwrap() {
        0 => Value::Null,
        1 => it["bool_value"].clone(),
        2 => it["integer_value"].clone(),
        3 => it["double_value"].clone(),
        4 => it["string_value"].clone(),
        8 => it["double_array_value"].clone(),
        other => panic!("{other}"),
    };
    values.map(value).collect()
}

const FOLLOWER: &str = "/robot/follower";

#[test]
fn properties_are_parameters_of_a_node_of_ros_2() {
    let Some(python) = python() else { return };
    let domain = domain();
    let _mission = run(domain);
    let mut peer = CycloneNode::start(&python, domain, "tool");
    let service = |name: &str| format!("{FOLLOWER}/{name}");
    for (name, of) in [
        ("get_parameters", "GetParameters"),
        ("get_parameter_types", "GetParameterTypes"),
        ("describe_parameters", "DescribeParameters"),
        ("list_parameters", "ListParameters"),
        ("set_parameters", "SetParameters"),
        ("set_parameters_atomically", "SetParametersAtomically"),
    ] {
        peer.client(&service(name), &format!("rcl_interfaces/srv/{of}"));
    }
    let events = "/parameter_events";
    peer.subscribe(
        events,
        "rcl_interfaces/ParameterEvent",
        TopicPolicies::default(),
    );
    peer.await_publishers(events, 2);
    let names = ["max_speed", "goal_heading", "mount", "nothing"];
    let get = |peer: &mut CycloneNode| {
        values(&peer.call(&service("get_parameters"), &json!({ "names": names })))
    };
    assert_eq!(
        get(&mut peer),
        [json!(0.7), json!(true), json!([0.0, 0.0, 0.0]), Value::Null]
    );
    let types = peer.call(&service("get_parameter_types"), &json!({ "names": names }));
    assert_eq!(types["types"], json!([3, 1, 8, 0]));
    let listed = peer.call(&service("list_parameters"), &json!({}));
    let listed = listed["result"]["names"].as_array().unwrap();
    assert!(
        listed.contains(&json!("max_speed")) && listed.len() == 27,
        "{listed:?}"
    );
    let described = peer.call(
        &service("describe_parameters"),
        &json!({ "names": ["max_speed"] }),
    );
    let described = &described["descriptors"][0];
    assert_eq!(
        described["floating_point_range"][0]["to_value"],
        json!(10.0)
    );
    assert_eq!(described["additional_constraints"], json!("unit: m/s"));
    // one by one: what is wrong does not hinder the others
    let wanted = json!({ "parameters": [
        parameter("max_speed", &double(1.25)),
        parameter("max_turn", &double(-1.0)),
        parameter("goal_heading", &json!({"type": 4, "string_value": "no"})),
        parameter("nothing", &double(1.0)),
        parameter("max_speed", &json!({"type": 2, "integer_value": 2})),
    ]});
    let results = peer.call(&service("set_parameters"), &wanted);
    let results = results["results"].as_array().unwrap();
    let succeeded: Vec<_> = results
        .iter()
        .map(|it| it["successful"].as_bool().unwrap())
        .collect();
    assert_eq!(succeeded, [true, false, false, false, true], "{results:?}");
    for (at, part) in [
        (1, "must be between 0.01 and 20.0"),
        (2, "bool"),
        (3, "`nothing`"),
    ] {
        let reason = results[at]["reason"].as_str().unwrap();
        assert!(reason.contains(part), "{reason}");
    }
    // the caller reads what it has set
    assert_eq!(get(&mut peer)[0], json!(2.0));
    let mut event = Value::Null;
    while event["changed_parameters"][0]["value"]["double_value"] != json!(2.0) {
        event = peer.message(events);
    }
    assert_eq!(event["node"], json!(FOLLOWER));
    // all or none
    let both = |turn: f64| json!({ "parameters": [parameter("max_speed", &double(3.0)), parameter("max_turn", &double(turn))] });
    let result = peer.call(&service("set_parameters_atomically"), &both(99.0));
    assert_eq!(result["result"]["successful"], json!(false), "{result}");
    assert_eq!(get(&mut peer)[0], json!(2.0));
    let result = peer.call(&service("set_parameters_atomically"), &both(3.5));
    assert_eq!(result["result"]["successful"], json!(true), "{result}");
    assert_eq!(get(&mut peer)[0], json!(3.0));
}

#[test]
fn a_component_is_a_managed_node_of_ros_2() {
    let Some(python) = python() else { return };
    let domain = domain();
    let mission = run(domain);
    let mut peer = CycloneNode::start(&python, domain, "manager");
    let service = |name: &str| format!("/map_server/{name}");
    for (name, of) in [
        ("change_state", "lifecycle_msgs/srv/ChangeState"),
        ("get_state", "lifecycle_msgs/srv/GetState"),
        (
            "get_available_states",
            "lifecycle_msgs/srv/GetAvailableStates",
        ),
        (
            "get_available_transitions",
            "lifecycle_msgs/srv/GetAvailableTransitions",
        ),
        ("set_parameters", "rcl_interfaces/srv/SetParameters"),
    ] {
        peer.client(&service(name), of);
    }
    let events = "/map_server/transition_event";
    peer.subscribe(
        events,
        "lifecycle_msgs/TransitionEvent",
        TopicPolicies::default(),
    );
    peer.await_publishers(events, 1);
    let state = |peer: &mut CycloneNode| {
        let response = peer.call(&service("get_state"), &json!({}));
        response["current_state"]["label"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    let change = |peer: &mut CycloneNode, id: u8, label: &str| {
        let request = json!({ "transition": { "id": id, "label": label } });
        let response = peer.call(&service("change_state"), &request);
        response["success"].as_bool().unwrap()
    };
    let possible = |peer: &mut CycloneNode| -> Vec<String> {
        let response = peer.call(&service("get_available_transitions"), &json!({}));
        let all = response["available_transitions"]
            .as_array()
            .unwrap()
            .clone();
        let label = |it: &Value| it["transition"]["label"].as_str().unwrap().to_owned();
        all.iter().map(label).collect()
    };
    assert_eq!(state(&mut peer), "active");
    assert_eq!(possible(&mut peer), ["deactivate", "shutdown"]);
    let states = peer.call(&service("get_available_states"), &json!({}));
    assert_eq!(states["available_states"].as_array().unwrap().len(), 11);
    assert!(change(&mut peer, 4, ""));
    assert_eq!(state(&mut peer), "inactive");
    let goals: Vec<Value> = (0..2)
        .map(|_| peer.message(events)["goal_state"]["label"].clone())
        .collect();
    assert_eq!(goals, ["deactivating", "inactive"]);
    // not possible from here: the state stays, and the story has the reason
    assert!(!change(&mut peer, 1, ""));
    mission.line("`/map_server` cannot make the transition");
    assert!(change(&mut peer, 0, "cleanup"));
    assert_eq!(state(&mut peer), "unconfigured");
    // a component that fails: the map is missing
    let nowhere = json!({ "type": 4, "string_value": "nowhere.yaml" });
    let source = json!({ "parameters": [parameter("source", &nowhere)] });
    let set = peer.call(&service("set_parameters"), &source);
    assert_eq!(set["results"][0]["successful"], json!(true), "{set}");
    assert!(!change(&mut peer, 1, "configure"));
    let line = mission.line("the transition configure failed");
    assert!(line.contains("nowhere.yaml"), "{line}");
    assert_eq!(state(&mut peer), "unconfigured");
    let shut_down = change(&mut peer, 0, "shutdown");
    assert!(shut_down);
    assert_eq!(state(&mut peer), "finalized");
    assert!(possible(&mut peer).is_empty());
    assert!(!change(&mut peer, 1, "configure"));
}
