//! Running composites, and the demo.

use super::{NAVIGATION, asmotion, run};
use std::path::Path;

#[test]
fn n11_the_demo_reaches_its_goal_and_says_so() {
    let (code, out, err) = run(&["demo", "--speed", "0"]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.starts_with("reached in ARRIVED"), "{out}");
    assert!(err.contains("FOLLOWING → ARRIVED"), "{err}");
    assert!(err.contains("BLOCKED"), "the demo shows a replan: {err}");
}

/// Time of the processor, which does not depend on what else runs on the machine.
#[test]
fn n11_a_full_mission_takes_less_than_5_s() {
    let script = "\"$0\" demo --speed 0 > /dev/null 2>&1 || exit 1; times";
    let mut shell = std::process::Command::new("sh");
    let shell = shell.args(["-c", script, env!("CARGO_BIN_EXE_asmotion")]);
    let output = shell.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let times = String::from_utf8(output.stdout).unwrap();
    // the second line is about the children: user and system time, as in `0m0.31s 0m0.02s`
    let seconds = |time: &str| {
        let (minutes, seconds) = time.trim_end_matches('s').split_once('m').unwrap();
        60.0 * minutes.parse::<f64>().unwrap() + seconds.parse::<f64>().unwrap()
    };
    let children = times.lines().nth(1).unwrap();
    let total: f64 = children.split_whitespace().map(seconds).sum();
    assert!((0.001..5.0).contains(&total), "{total} s: {times}");
}

#[test]
fn the_demo_goes_where_it_is_told() {
    let (code, out, _) = run(&[
        "demo", "--speed", "0", "--goal", "4.2,15.6", "--world", "plain", "--quiet",
    ]);
    assert_eq!(code, 0, "{out}");
    let (code, out, _) = run(&["demo", "--speed", "0", "--goal", "21.1,17.2", "--quiet"]);
    assert_eq!(
        code, 1,
        "the table of the meeting room cannot be reached: {out}"
    );
}

#[test]
fn a_goal_that_is_none_is_a_wrong_usage() {
    let (code, _, err) = run(&["demo", "--goal", "kitchen"]);
    assert_eq!(code, 2);
    assert!(err.contains("expected two numbers"), "{err}");
    let (code, _, _) = run(&["fly"]);
    assert_eq!(code, 2);
}

#[test]
fn a_composite_runs_from_any_folder_in_virtual_time() {
    let composite = Path::new(env!("CARGO_MANIFEST_DIR")).join(NAVIGATION);
    let elsewhere = tempfile::tempdir().unwrap();
    let mut command = asmotion();
    command
        .current_dir(elsewhere.path())
        .args(["run", "--quiet"])
        .arg(composite);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn a_composite_runs_in_wall_time() {
    let (code, out, err) = run(&["run", NAVIGATION, "--clock", "wall", "--for", "3"]);
    assert_eq!(code, 1, "three seconds are not enough: {out}{err}");
    assert!(out.starts_with("time up in FOLLOWING"), "{out}{err}");
    assert!(err.contains("WAIT_PATH → FOLLOWING"), "{err}");
}

#[test]
fn a_run_ends_with_what_it_is_told() {
    let until = ["--until", "mode=WAIT_PATH", "--unless", "command=HALT"];
    let (code, out, err) = run(&[&["run", NAVIGATION, "--quiet"], &until[..]].concat());
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.contains("reached in WAIT_PATH"), "{out}");
}

#[test]
fn properties_are_set_as_toml_writes_them() {
    let start = |setting: &str| {
        let limit = ["--for", "2", "--until", "mode=ARRIVED", "--json"];
        let (code, out, err) = run(&[&["run", NAVIGATION, "--set", setting], &limit[..]].concat());
        assert_eq!(code, 1, "two seconds are not enough: {out}{err}");
        out.lines()
            .filter(|line| line.contains("\"to_goal_m\""))
            .count()
    };
    for setting in [
        "start=[1.4, 4.7, 0]",
        "start=1.4,4.7,0",
        "World.start=[1.4, 4.7, 0.0]",
        "World.obstacles=[{ at_s = 0.0, disc = [14.5, 7.3, 0.25] }]",
        "place=office",
    ] {
        assert_eq!(start(setting), 1, "{setting}");
    }
}

#[test]
fn a_seed_needs_no_property_of_the_composite() {
    let (_, _, err) = run(&["run", "specs/youbot/youbot.composite.toml", "--seed", "3"]);
    assert!(!err.contains("C013"), "{err}");
}

#[test]
fn two_specifications_talk_in_a_composite() {
    let courier = "specs/courier/courier.composite.toml";
    let (code, out, err) = run(&["run", courier, "--until", "jobs=3", "--for", "20"]);
    assert_eq!(code, 0, "{err}");
    assert!(
        out.contains("dispatcher.job ×3, dispatcher.done ×3"),
        "{out}"
    );
    assert!(out.contains("; 0 failed"), "{out}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_queue_that_does_not_appear_is_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let composite = folder.path().join("waiting.composite.toml");
    let queue = format!("mqueue:/asmotion-never-{}", std::process::id());
    let text = format!(
        r#"
        schema = "composite/1"
        [composite]
        name = "waiting"
        [components.Rover]
        implementation = {{ rust = "nav::sim::RoverDriver" }}
        [[connections]]
        from = "{queue}"
        to = "Rover.twist"
        "#
    );
    std::fs::write(&composite, text).unwrap();
    let mut command = asmotion();
    command
        .args(["run", "--clock", "wall", "--for", "8"])
        .arg(&composite);
    let output = command.output().unwrap();
    let story = String::from_utf8_lossy(&output.stderr);
    let waiting = format!("Rover for {queue}");
    assert_eq!(story.matches(&waiting).count(), 1, "{story}");
}

#[test]
fn a_goal_reached_with_a_collision_is_no_success() {
    // a post that appears too near to brake, and disappears
    let post = r#"World.obstacles=[{ at_s = 6.0, until_s = 8.0, frame = "robot", disc = [0.27, 0.0, 0.05] }]"#;
    let mission = ["run", NAVIGATION, "--goal", "5,4.7", "--set", post];
    let (code, out, err) = run(&mission);
    assert_eq!(code, 1, "{out}{err}");
    assert!(out.starts_with("reached in ARRIVED"), "{out}{err}");
    assert!(out.contains("with a collision"), "{out}");
    assert!(err.contains("collision"), "{err}");
    let (code, out, _) = run(&[&mission[..], &["--json"]].concat());
    assert!(code == 1 && out.contains("\"collisions\":1"), "{out}");
    let (code, out, _) = run(&["run", NAVIGATION, "--goal", "5,4.7", "--json"]);
    assert!(code == 0 && out.contains("\"collisions\":0"), "{out}");
}

/// The last velocities of the wheels in a table of `RoverDriver.wheels`, rad/s.
fn last_wheels(table: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(table).unwrap();
    let mut rows = csv_rows(&text);
    let head = rows.next().unwrap();
    let last = rows.last().unwrap();
    let wheels = head
        .iter()
        .zip(last)
        .filter(|(name, _)| name.contains("wheels"));
    wheels.filter_map(|(_, value)| value.parse().ok()).collect()
}

fn csv_rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.lines().map(|line| line.split(',').collect())
}

/// Ends a run in each way, in mid-motion; the last command to the wheels is to stand still.
#[test]
fn the_wheels_stand_still_at_the_end_of_every_run() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("wheels.csv");
    let recorded = |arguments: &[&str]| {
        let mut command = asmotion();
        command
            .args([
                "run",
                NAVIGATION,
                "--quiet",
                "--ports",
                "RoverDriver.wheels",
                "--record",
            ])
            .arg(&table)
            .args(arguments);
        command
    };
    let output = recorded(&["--for", "10"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "time is up: {output:?}");
    assert_eq!(last_wheels(&table), [0.0, 0.0]);

    for signal in ["INT", "TERM", "HUP"] {
        std::fs::remove_file(&table).unwrap();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args(["run", NAVIGATION, "--clock", "wall", "--quiet"])
            .args(["--ports", "RoverDriver.wheels", "--record"])
            .arg(&table);
        let mut child = command.spawn().unwrap();
        // it starts to drive after about two seconds
        std::thread::sleep(std::time::Duration::from_secs(4));
        let id = child.id().to_string();
        let kill = std::process::Command::new("kill");
        let killed = { kill }.args(["-s", signal, &id]).status().unwrap();
        assert!(killed.success());
        assert_eq!(
            child.wait().unwrap().code(),
            Some(1),
            "SIG{signal} stops it"
        );
        let text = std::fs::read_to_string(&table).unwrap();
        assert!(text.lines().count() > 50, "SIG{signal}: {text}");
        assert_eq!(last_wheels(&table), [0.0, 0.0], "after SIG{signal}");
    }
}

#[test]
fn a_rover_that_slips_is_told_from_one_that_arrives() {
    let mission = ["run", NAVIGATION, "--quiet", "--json"];
    let summary = |more: &[&str]| -> serde_json::Value {
        let (code, out, err) = run(&[&mission[..], more].concat());
        assert_eq!(code, 0, "{out}{err}");
        serde_json::from_str(out.lines().last().unwrap()).unwrap()
    };
    let distance = |summary: &serde_json::Value, key: &str| summary[key].as_f64().unwrap();
    let arrived = summary(&[]);
    assert!(distance(&arrived, "true_to_goal_m") < 0.2, "{arrived}");
    // both believe to have arrived; the floor of the second one is slippery
    let slipped = summary(&["--set", "World.slip=0.02"]);
    assert!(distance(&slipped, "to_goal_m") < 0.2, "{slipped}");
    assert!(distance(&slipped, "true_to_goal_m") > 0.2, "{slipped}");
    let (_, out, _) = run(&["run", NAVIGATION, "--quiet"]);
    assert!(out.contains("m from the goal by odometry, "), "{out}");
    assert!(out.contains("m in truth (simulator)"), "{out}");
}

/// `solve` is true for one step. Its provider answers two or three steps later.
#[test]
fn a_call_outlasts_the_step_that_makes_it() {
    let folder = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir("specs/youbot").unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
    }
    let path = folder.path().join("youbot.composite.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let kinematics = "implementation = { rust = \"youbot::Kinematics\" }\n";
    let slow = format!("{kinematics}activity = {{ period_ms = 120 }}\n");
    assert_eq!(text.matches(kinematics).count(), 1);
    std::fs::write(&path, text.replace(kinematics, &slow)).unwrap();
    let path = path.display().to_string();
    let run_it = [
        "run",
        &path,
        "--until",
        "mode=IDLE",
        "--for",
        "20",
        "--json",
    ];
    let (code, out, err) = run(&run_it);
    assert_eq!(code, 0, "{out}{err}");
    let summary: serde_json::Value = serde_json::from_str(out.lines().last().unwrap()).unwrap();
    assert_eq!(summary["failed_calls"], 0, "{summary}");
}
