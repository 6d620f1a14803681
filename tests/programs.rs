//! Components in other programs, written in Python with its standard library alone.

mod machines;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use asmotion_skip::PYTHON;

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(30);

const COMPOSITE: &str = include_str!("../examples/gripper/gripper.composite.toml");

/// A folder with the programs, the specification and a composite; `None` without Python.
struct Workshop {
    folder: tempfile::TempDir,
}

impl Workshop {
    fn new() -> Option<Self> {
        if Command::new("python3").arg("--version").output().is_err() {
            PYTHON.skip();
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for source in ["engine/program/tests/programs", "examples/gripper"] {
            for entry in std::fs::read_dir(root.join(source)).unwrap() {
                let entry = entry.unwrap();
                if entry.file_type().unwrap().is_file() {
                    std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
                }
            }
        }
        Some(Self { folder })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes the composite with these changes.
    fn change(&self, changes: &[(&str, &str)]) {
        let mut text = COMPOSITE.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        std::fs::write(self.path("gripper.composite.toml"), text).unwrap();
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.args(arguments).current_dir(self.folder.path());
        command
    }

    /// Exit code, standard output, standard error.
    fn run(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let Output {
            status,
            stdout,
            stderr,
        } = self.command(arguments).output().unwrap();
        let text = |bytes: Vec<u8>| {
            let text = String::from_utf8(bytes).unwrap();
            text.replace(&self.folder.path().display().to_string(), "[folder]")
        };
        (status.code(), text(stdout), text(stderr))
    }
}

const FILE: &str = "gripper.composite.toml";

#[test]
fn a_program_is_checked_described_drawn_and_expanded_like_any_component() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let (code, _, err) = workshop.run(&["check", FILE]);
    assert_eq!(code, Some(0), "{err}");
    assert!(err.contains("no findings"), "{err}");
    let (_, described, _) = workshop.run(&["describe", FILE]);
    insta::assert_snapshot!("described", described);
    let (_, connections, _) = workshop.run(&["check", "--connections", FILE]);
    insta::assert_snapshot!("connections", connections);
    let (_, drawn, _) = workshop.run(&["graph", "--format", "dot", FILE]);
    assert!(drawn.contains("python3 gripper.py"), "{drawn}");
    let (_, expanded, _) = workshop.run(&["expand", FILE]);
    std::fs::write(workshop.path("expanded.composite.toml"), &expanded).unwrap();
    let (code, again, err) = workshop.run(&["expand", "expanded.composite.toml"]);
    assert_eq!((code, again), (Some(0), expanded), "{err}");
}

#[test]
fn mistakes_about_a_program_are_found_before_it_runs() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let mut text = String::new();
    for (from, to) in [
        ("publish = { state =", "publish = { stat ="),
        ("speed = 0.2", "speed = 0.9"),
        ("speed = 0.2", "sped = 0.2"),
        ("field = \"opening\"", "field = \"openning\""),
        ("\"gripper.close\"", "\"gripper.shut\""),
        ("with = { force = 2.5 }", "with = { strength = 2.5 }"),
        (
            "state = \"acme/GripperState\" }\npublish = { command",
            "state = \"acme/Gripper\" }\npublish = { command",
        ),
    ] {
        workshop.change(&[(from, to)]);
        let (code, out, _) = workshop.run(&["check", "--format", "concise", FILE]);
        text += &format!("{to}\n{code:?} {out}\n");
    }
    insta::assert_snapshot!(text);
}

#[test]
fn a_program_that_cannot_be_asked_is_an_error_with_its_cause() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let mut text = String::new();
    for program in [
        "[\"python3\", \"bad.py\", \"exits\"]",
        "[\"python3\", \"bad.py\", \"never-connects\"], start_timeout_s = 2.5",
        "[\"python3\", \"bad.py\", \"garbage\"]",
        "[\"python3\", \"bad.py\", \"shape\"]",
        "\"grippr\"",
        "\"./gripper.py\"",
        "[]",
        "\"python3\", directory = \"drivers\"",
    ] {
        let process = "[\"python3\", \"gripper.py\"]";
        workshop.change(&[(process, program)]);
        let (code, _, err) = workshop.run(&["check", FILE]);
        assert_eq!(code, Some(1), "{err}");
        let first = err.split("\n\n").next().unwrap_or_default();
        text += &format!("{first}\n\n");
    }
    insta::assert_snapshot!(text);
    // nothing is started
    workshop.change(&[("[\"python3\", \"gripper.py\"]", "\"grippr\"")]);
    let (code, _, err) = workshop.run(&["check", "--no-programs", FILE]);
    assert_eq!(code, Some(0), "{err}");
    let first = err.split("\n\n").next();
    insta::assert_snapshot!("not_asked", first.unwrap_or_default());
}

#[test]
fn a_coordinator_calls_a_program_and_two_runs_are_equal() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let run = || workshop.run(&["run", FILE, "--until", "mode=CLOSED", "--for", "10"]);
    let (code, out, err) = run();
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(err.contains("CLOSING → CLOSED"), "{err}");
    assert!(err.contains("Gripper: configured with 0.2"), "{err}");
    let steady = |text: &str| {
        // durations of the machine
        let lines = text.lines().filter(|line| !line.contains(" wall"));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    let (_, _, again) = run();
    assert_eq!(steady(&err), steady(&again));
    let (code, out, err) = workshop.run(&[
        "run",
        FILE,
        "--until",
        "mode=CLOSED",
        "--for",
        "10",
        "--clock",
        "wall",
    ]);
    assert_eq!(code, Some(0), "{out}{err}");
}

#[test]
fn a_run_with_a_program_is_recorded_as_json_and_replayed() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    for clock in ["virtual", "wall"] {
        let arguments = ["run", FILE, "--until", "mode=CLOSED", "--for", "10"];
        let recording = ["--clock", clock, "--json", "--trace", "run.trace"];
        let (code, out, err) = workshop.run(&[&arguments[..], &recording].concat());
        assert_eq!(code, Some(0), "{clock}: {out}{err}");
        let events: Vec<serde_json::Value> = out
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect();
        let is_of_program = |event: &serde_json::Value, kind: &str| {
            event["component"] == "Gripper" && event["type"] == kind
        };
        for kind in ["call", "reply"] {
            let is_shown = events.iter().any(|event| is_of_program(event, kind));
            assert!(is_shown, "{clock}: {out}");
        }
        let replay = ["sim", "grasp.asm", "--replay-inputs", "run.trace", "-q"];
        let (code, out, err) = workshop.run(&replay);
        assert_eq!(code, Some(0), "{clock}: {out}{err}");
        assert!(out.contains("  mode = CLOSED\n"), "{clock}: {out}");
    }
}

#[test]
fn operations_of_programs_and_components_are_compared() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let mut text = String::new();
    // a program to a program, to a component of the executable, and the reverse
    for (reference, service) in [
        ("Other.grip", "Gripper.grip"),
        ("Other.planner", "Planner.planning"),
        ("Planner.maps", "Other.maps"),
    ] {
        let part = format!(
            r#"
schema = "composite/1"
[composite]
name = "mixed"
[components.Gripper]
implementation = {{ process = ["python3", "gripper.py"] }}
activity = {{ period_ms = 100 }}
[components.Other]
implementation = {{ process = ["python3", "differing.py"] }}
activity = {{ period_ms = 100 }}
[components.Planner]
implementation = {{ rust = "nav::TrajectoryPlanner" }}
activity = {{ period_ms = 100 }}
subscribe = {{ obstacles = "nav/Obstacles" }}
[[promote]]
topic = "obstacles"
as = "obstacles"
[[wires]]
reference = "{reference}"
service = "{service}"
timeout_ms = 500
"#
        );
        std::fs::write(workshop.path("mixed.composite.toml"), part).unwrap();
        let (code, _, err) = workshop.run(&["check", "mixed.composite.toml"]);
        assert_eq!(code, Some(1), "{err}");
        text += &err;
    }
    insta::assert_snapshot!("operations", text);
}

#[test]
fn two_components_have_the_same_program() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let second = r#"
[components.Second]
implementation = { process = ["python3", "gripper.py"] }
activity = { period_ms = 100 }
subscribe = { command = "acme/GripperCommand" }
properties = { speed = 0.4 }

[[wires]]"#;
    let wire = "service = \"Gripper.grip\"";
    workshop.change(&[("[[wires]]", second), (wire, "service = \"Second.grip\"")]);
    let arguments = ["run", FILE, "--for", "1", "--record", "run.csv"];
    let ports = ["--ports", "*.state", "--json"];
    let (code, out, err) = workshop.run(&[&arguments[..], &ports].concat());
    assert_eq!(code, Some(0), "{out}{err}");
    insta::assert_snapshot!(
        "same_program",
        std::fs::read_to_string(workshop.path("run.csv")).unwrap()
    );
}

#[test]
fn a_mission_runs_a_program() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let (code, out, err) = workshop.run(&["test", "gripper.mission.toml"]);
    assert_eq!(code, Some(0), "{out}{err}");
}

#[test]
fn programs_are_nested_and_started_in_their_directory() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    std::fs::create_dir_all(workshop.path("arm/programs")).unwrap();
    for file in ["protocol.py", "gripper.py"] {
        std::fs::rename(
            workshop.path(file),
            workshop.path("arm/programs").join(file),
        )
        .unwrap();
    }
    let nested = r#"
schema = "composite/1"
[composite]
name = "arm"
[components.Left]
implementation = { process = ["python3", "gripper.py"], directory = "programs" }
activity = { period_ms = 100 }
[components.Right]
implementation = { process = ["python3", "gripper.py"], directory = "programs", start_timeout_s = 20, timeout_s = 1.5 }
activity = { period_ms = 50 }
properties = { speed = 0.3 }
"#;
    std::fs::write(workshop.path("arm/arm.composite.toml"), nested).unwrap();
    let outer = r#"
schema = "composite/1"
[composite]
name = "robot"
[components.Arm]
implementation = { composite = "arm/arm.composite.toml" }
"#;
    std::fs::write(workshop.path("robot.composite.toml"), outer).unwrap();
    let (code, out, err) = workshop.run(&["run", "robot.composite.toml", "--for", "1"]);
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(err.contains("Arm/Left: configured with 0.1"), "{err}");
    assert!(err.contains("Arm/Right: configured with 0.3"), "{err}");
    let (_, expanded, _) = workshop.run(&["expand", "robot.composite.toml"]);
    let right = r#"directory = "arm/programs", start_timeout_s = 20.0, timeout_s = 1.5 }"#;
    assert!(expanded.contains(right), "{expanded}");
}

#[test]
fn a_program_that_fails_is_reset_and_the_others_go_on() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let bad = r#"
[components.Bad]
implementation = { process = ["python3", "bad.py", "hangs"], timeout_s = 1 }
activity = { period_ms = 100 }
lifecycle = { on_exception = "reset", max_resets = 1 }

[[wires]]"#;
    workshop.change(&[("[[wires]]", bad)]);
    let (code, out, err) = workshop.run(&["run", FILE, "--until", "mode=CLOSED", "--for", "10"]);
    assert_eq!(code, Some(0), "{out}{err}");
    let silent = err.matches("PROGRAM_SILENT: the program did not answer `cycle` within 1s");
    assert_eq!(silent.count(), 2, "{err}");
}

/// The processes below a process.
fn children(process: u32) -> BTreeSet<u32> {
    let mut children = BTreeSet::new();
    for thread in std::fs::read_dir(format!("/proc/{process}/task"))
        .into_iter()
        .flatten()
    {
        let list = thread.unwrap().path().join("children");
        let list = std::fs::read_to_string(list).unwrap_or_default();
        children.extend(list.split_whitespace().map(|it| it.parse::<u32>().unwrap()));
    }
    children
}

/// Waits until something is there.
fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begin.elapsed() < LONG, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Whether a process runs; one that has ended and was not reaped does not.
fn is_running(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let state = status.rsplit(')').next().unwrap_or_default().trim_start();
    !state.is_empty() && !state.starts_with('Z')
}

#[test]
fn a_killed_asmotion_leaves_no_program() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let mut command = workshop.command(&["run", FILE, "--clock", "wall", "--for", "60"]);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut asmotion = command.spawn().unwrap();
    // the first program is asked, the next one is the component
    std::thread::sleep(Duration::from_millis(1500));
    let programs = until("a program", || {
        let children = children(asmotion.id());
        (!children.is_empty()).then_some(children)
    });
    asmotion.kill().unwrap();
    asmotion.wait().unwrap();
    until("the end of the program", || {
        programs.iter().all(|it| !is_running(*it)).then_some(())
    });
}
