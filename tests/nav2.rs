//! The specification in the place of Nav2's behaviour tree, in front of servers that speak its interfaces over Cyclone DDS.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use asmotion_ros_domain::{CycloneNode, Nav2, TopicPolicies, domain, python};
use serde_json::json;

use crate::ros_bridge::Mission;

const PLAN: &str = "compute_path_to_pose";
const FOLLOW: &str = "follow_path";
const CLEAR_GLOBAL: &str = "clear /global_costmap/clear_entirely_global_costmap";
const CLEAR_LOCAL: &str = "clear /local_costmap/clear_entirely_local_costmap";

/// A robot with Nav2's servers, a person with RViz, and the coordinator.
struct Robot {
    mission: Mission,
    nav2: Nav2,
    person: CycloneNode,
}

impl Robot {
    fn start(python: &Path) -> Self {
        let domain = domain();
        let composite =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/nav2/nav2.composite.toml");
        let nav2 = Nav2::start(python, domain);
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .env("ROS_DOMAIN_ID", domain.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env_remove("ROS_LOCALHOST_ONLY")
            .arg("run")
            .arg(&composite)
            .args(["--clock", "wall", "--for", "120"]);
        let mission = Mission::spawn(command);
        mission.line("joined the ROS 2 domain");
        let mut person = CycloneNode::start(python, domain, "rviz");
        for (topic, kind) in [
            ("/goal_pose", "geometry_msgs/PoseStamped"),
            ("/estop", "std_msgs/Bool"),
            ("/cancel_navigation", "std_msgs/Empty"),
        ] {
            person.advertise(topic, kind, TopicPolicies::default(), 1);
        }
        Self {
            mission,
            nav2,
            person,
        }
    }

    fn goal(&mut self, x: f64) {
        let pose = json!({
            "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "map"},
            "pose": {
                "position": {"x": x, "y": 0.0, "z": 0.0},
                "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
            },
        });
        self.person.publish("/goal_pose", &pose);
    }

    /// No two parts of Nav2 moved the robot at once.
    fn check(&mut self) {
        self.nav2.events_for(Duration::from_millis(100));
        let heard = self.nav2.heard();
        assert!(
            !heard.iter().any(|it| it.starts_with("TWO MOVERS")),
            "{heard:?}"
        );
    }
}

#[test]
fn it_replans_every_second_and_arrives() {
    let Some(python) = python() else { return };
    let mut robot = Robot::start(&python);
    robot.goal(4.0);
    robot.mission.line("IDLE → NAVIGATING");
    let events = robot.nav2.until("end follow_path 4");
    let count = |event: &str| events.iter().filter(|it| *it == event).count();
    // after 1 s and 2 s a new path takes the place of the one before, without a cancellation, which would stop the robot
    let plans = count("begin compute_path_to_pose");
    assert!((2..=4).contains(&plans), "{events:?}");
    assert_eq!(count("begin follow_path"), plans, "{events:?}");
    assert_eq!(count("end follow_path 6"), plans - 1, "{events:?}");
    assert_eq!(count("cancel follow_path"), 0, "{events:?}");
    robot.mission.line("NAVIGATING → AT_GOAL");
    robot.check();
}

#[test]
fn it_clears_costmaps_and_recovers_as_the_tree_does() {
    let Some(python) = python() else { return };
    let mut robot = Robot::start(&python);
    // the controller makes no progress, twice
    for _ in 0..2 {
        robot.nav2.next_fails(FOLLOW, 105, 0.1);
    }
    robot.goal(4.0);
    let events = robot.nav2.until(CLEAR_GLOBAL);
    let expected = [
        "begin compute_path_to_pose",
        "end compute_path_to_pose 4",
        "begin follow_path",
        "end follow_path 6",
        CLEAR_LOCAL,
        "begin follow_path",
        "end follow_path 6",
        CLEAR_LOCAL,
        CLEAR_GLOBAL,
    ];
    assert_eq!(events, expected);
    robot.mission.line("NAVIGATING → RECOVERING");
    robot.mission.line("RECOVERING → NAVIGATING");
    robot.nav2.until("begin follow_path");
    // while it follows, there is no path any more, also with a clear costmap: the robot stops, and only then spins
    for _ in 0..2 {
        robot.nav2.next_fails(PLAN, 208, 0.05);
    }
    let events = robot.nav2.until("begin spin");
    let at = |event: &str| events.iter().position(|it| it == event);
    let cancelled = at("cancel follow_path").unwrap();
    let stopped = at("end follow_path 5").unwrap();
    assert!(
        cancelled < stopped && at(CLEAR_GLOBAL).unwrap() < cancelled,
        "{events:?}"
    );
    robot.nav2.until("end spin 4");
    robot.nav2.until("end follow_path 4");
    robot.mission.line("NAVIGATING → AT_GOAL");
    robot.check();
}

#[test]
fn an_emergency_stop_and_a_new_goal_stop_the_robot_first() {
    let Some(python) = python() else { return };
    let mut robot = Robot::start(&python);
    robot.goal(4.0);
    robot.nav2.until("begin follow_path");
    robot.goal(-4.0);
    let events = robot.nav2.until("begin compute_path_to_pose");
    let expected = [
        "cancel follow_path",
        "end follow_path 5",
        "begin compute_path_to_pose",
    ];
    assert_eq!(events, expected);
    robot.nav2.until("begin follow_path");
    robot.person.publish("/estop", &json!({"data": true}));
    robot.nav2.until("end follow_path 5");
    robot.mission.line("STOPPING → IDLE");
    // a goal while the stop is pressed has no effect
    robot.goal(4.0);
    assert_eq!(robot.nav2.events_for(Duration::from_millis(500)), [""; 0]);
    robot.person.publish("/estop", &json!({"data": false}));
    robot.goal(4.0);
    robot.nav2.until("begin follow_path");
    robot.person.publish("/cancel_navigation", &json!({}));
    robot.nav2.until("end follow_path 5");
    robot.check();
}

#[test]
fn errors_that_no_recovery_helps_and_servers_that_leave_end_the_navigation() {
    let Some(python) = python() else { return };
    let mut robot = Robot::start(&python);
    // the goal is outside of the map
    robot.nav2.next_fails(PLAN, 204, 0.05);
    robot.goal(400.0);
    robot.mission.line("NAVIGATING → GAVE_UP");
    let heard = robot.nav2.heard().join(" ");
    assert!(
        !heard.contains("clear") && !heard.contains("spin"),
        "{heard}"
    );
    robot.goal(4.0);
    robot.nav2.until("begin follow_path");
    robot.check();
    robot.nav2.kill();
    robot.mission.line("→ GAVE_UP");
}
