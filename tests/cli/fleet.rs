//! Several robots in one composite: each has its own summary.

use super::{NAVIGATION, run};
use std::path::Path;

/// A composite of two rovers in worlds of their own with the same goal; the left one starts closer to it.
fn fleet() -> (tempfile::TempDir, String) {
    let navigation = Path::new(env!("CARGO_MANIFEST_DIR")).join(NAVIGATION);
    let robot = |name: &str, settings: &str| {
        let path = navigation.display();
        format!("[components.{name}]\nimplementation = {{ composite = \"{path}\" }}\n{settings}\n")
    };
    let left = robot("Left", "properties = { start = [20.0, 7.0, 0.0] }\n");
    let right = robot("Right", "");
    let text = format!("schema = \"composite/1\"\n[composite]\nname = \"fleet\"\n\n{left}{right}");
    super::file("fleet.composite.toml", text)
}

#[test]
fn a_run_of_several_robots_ends_when_all_have_reached_their_goals() {
    let (_folder, path) = fleet();
    let command = ["run", &path, "-q"];
    let (code, out, err) = run(&command);
    assert_eq!(code, 0, "{out}{err}");
    let line = |robot: &str| {
        out.lines()
            .find(|line| line.trim_start().starts_with(robot))
            .unwrap()
    };
    assert!(line("Left").contains("ARRIVED, driven"), "{out}");
    assert!(line("Right").contains("ARRIVED, driven"), "{out}");

    let (_, json, _) = run(&[&command[..], &["--json"]].concat());
    let summary: serde_json::Value = serde_json::from_str(json.lines().last().unwrap()).unwrap();
    assert_eq!(summary["outcome"], "reached");
    assert_eq!(summary["control_state"], "ARRIVED", "of both");
    assert_eq!(
        summary["driven_m"],
        serde_json::Value::Null,
        "there are two paths"
    );
    let robots = summary["robots"].as_array().unwrap();
    let names: Vec<_> = robots.iter().map(|robot| &robot["name"]).collect();
    assert_eq!(names, ["Left", "Right"]);
    for robot in robots {
        assert!(robot["to_goal_m"].as_f64().unwrap() < 0.15, "{robot}");
        assert_eq!(robot["control_state"], "ARRIVED");
    }
    let driven = |index: usize| robots[index]["driven_m"].as_f64().unwrap();
    assert!((7.0..12.0).contains(&driven(0)), "{robots:?}");
    assert!((25.0..60.0).contains(&driven(1)), "{robots:?}");
    assert!(
        summary["time_s"].as_f64().unwrap() > 40.0,
        "the last one decides"
    );
}

#[test]
fn a_headline_names_the_control_state_of_each_robot_where_they_differ() {
    let (_folder, path) = fleet();
    // the left one has arrived, the right one is still on its way
    let command = ["run", &path, "-q", "--for", "30"];
    let (code, out, err) = run(&command);
    assert_eq!(code, 1, "{out}{err}");
    let headline =
        "time up in ARRIVED (Left/ASMCoordinator), FOLLOWING (Right/ASMCoordinator) after 30.0 s";
    assert!(out.lines().any(|line| line == headline), "{out}");

    let (_, json, _) = run(&[&command[..], &["--json"]].concat());
    let summary: serde_json::Value = serde_json::from_str(json.lines().last().unwrap()).unwrap();
    assert_eq!(summary["outcome"], "time up");
    assert_eq!(summary["control_state"], serde_json::Value::Null);
    let states = serde_json::json!([
        { "component": "Left/ASMCoordinator", "state": "ARRIVED" },
        { "component": "Right/ASMCoordinator", "state": "FOLLOWING" },
    ]);
    assert_eq!(summary["control_states"], states);
    assert_eq!(summary["robots"][0]["control_state"], "ARRIVED");
    assert_eq!(summary["robots"][1]["control_state"], "FOLLOWING");
}

/// The summary of the twenty rovers of `specs/fleet`.
fn twenty_rovers(arguments: &[&str]) -> (i32, serde_json::Value) {
    let command = ["run", "specs/fleet/fleet.composite.toml", "--json", "-q"];
    let (code, json, err) = run(&[&command, arguments].concat());
    let last = json.lines().last().expect(&err);
    (code, serde_json::from_str(last).unwrap())
}

#[test]
fn twenty_rovers_in_one_world_reach_their_goals_or_say_why_not() {
    let (code, summary) = twenty_rovers(&["--for", "120"]);
    assert_eq!((code, summary["outcome"].as_str()), (1, Some("failed")));
    assert_eq!(summary["collisions"], 0, "{summary}");
    let robots = summary["robots"].as_array().unwrap();
    let names: Vec<_> = robots
        .iter()
        .map(|it| it["name"].as_str().unwrap())
        .collect();
    let expected: Vec<_> = (1..=20).map(|it| format!("Rover{it}")).collect();
    assert_eq!(names, expected, "in the order of their numbers");
    let mut arrived = 0;
    for robot in robots {
        let away = robot["true_to_goal_m"].as_f64().unwrap();
        let cause = robot["cause"].as_str().unwrap();
        match robot["control_state"].as_str() {
            Some("ARRIVED") => {
                arrived += 1;
                assert!(away < 0.2, "{robot}");
            }
            Some("FAILED") => {
                assert!(
                    ["event = NO_PATH", "event = BLOCKED"].contains(&cause),
                    "{robot}"
                );
            }
            _ => panic!("{robot}"),
        }
        // its goal is beside the lockers, where no rover has room
        if robot["name"] == "Rover5" {
            assert_eq!((cause, away > 6.0), ("event = NO_PATH", true), "{robot}");
        }
    }
    assert!(arrived >= 15, "{arrived} have arrived");
}

#[test]
fn a_fleet_has_the_same_trace_in_every_run() {
    let events = || {
        let command = [
            "run",
            "specs/fleet/fleet.composite.toml",
            "--json",
            "--for",
            "4",
        ];
        let (_, json, _) = run(&command);
        let mut lines: Vec<String> = json.lines().map(str::to_owned).collect();
        // the summary contains the wall-clock time
        lines.pop();
        lines
    };
    let first = events();
    assert!(first.len() > 100, "{} events", first.len());
    assert!(first == events());
}

#[test]
fn a_headline_counts_the_control_states_of_many_robots() {
    let command = [
        "run",
        "specs/fleet/fleet.composite.toml",
        "-q",
        "--for",
        "3",
    ];
    let (_, out, _) = run(&command);
    let headline = "time up in FAILED ×1, FOLLOWING ×19 after 3.0 s";
    assert!(out.lines().any(|line| line == headline), "{out}");
    // rows of one element are one
    assert!(out.contains("  received   rover1…20/goal ×20"), "{out}");
    let rover5 = out.lines().find(|line| line.contains("Rover5 "));
    let rover5 = rover5.unwrap_or_default();
    assert!(
        rover5.contains("FAILED (event = NO_PATH), driven 0.0 m"),
        "{rover5}"
    );
}
