//! Programs of a composite whose processes run on several machines, over a broker. Each machine has a folder of its own.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use super::{FILE, Workshop, children, is_running, until};
use crate::person::person;
use crate::processes::{queues, tool};

/// The processes of two machines.
const DEPLOYED: &str = r#"
[deploy]
processes = [
  { name = "arm", host = "robot", components = ["Gripper"] },
  { name = "brain", host = "desk", components = ["Coordinator"] },
]

[[wires]]"#;

/// Exit code, standard output and standard error of a run.
type EndOfRun = (Option<i32>, String, String);

/// The folders of two machines: the robot has the program, the desk has not. `None` without Python.
fn machines() -> Option<(Workshop, Workshop)> {
    let (robot, desk) = (Workshop::new()?, Workshop::new()?);
    for machine in [&robot, &desk] {
        machine.change(&[("[[wires]]", DEPLOYED)]);
    }
    std::fs::remove_file(desk.path("gripper.py")).unwrap();
    Some((robot, desk))
}

#[test]
fn a_program_of_another_machine_may_be_absent() {
    let Some((robot, desk)) = machines() else {
        return;
    };
    let (code, _, err) = desk.run(&["check", FILE]);
    assert_eq!(code, Some(0), "{err}");
    insta::assert_snapshot!("elsewhere", err);
    // where it is present it is asked, wherever it is to run
    let (code, _, err) = robot.run(&["check", FILE]);
    assert_eq!(code, Some(0), "{err}");
    assert!(err.contains("no findings"), "{err}");
    // the machine that runs it needs it
    let run = |arguments: &[&str]| {
        let mut command = desk.command(arguments);
        command.env("ASMOTION_PASSWORD", "a");
        let output = command.output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let no_broker = ["--bus", "amqp://a@127.0.0.1:1"];
    for arguments in [
        ["up", FILE, "--host", "robot"],
        ["run", FILE, "--process", "arm"],
    ] {
        let (code, err) = run(&[&arguments[..], &no_broker].concat());
        assert_ne!(code, Some(0), "{arguments:?} {err}");
        assert!(err.contains("error[C153]"), "{arguments:?} {err}");
    }
    let (code, err) = run(&["run", FILE]);
    assert_ne!(code, Some(0), "{err}");
    assert!(err.contains("error[C153]"), "{err}");
    // the process of another component starts, as far as there is a broker
    let (_, err) = run(&[&["run", FILE, "--process", "brain"], &no_broker[..]].concat());
    assert!(err.contains("warning[C154]"), "{err}");
    assert!(!err.contains("error[C"), "{err}");
}

#[test]
fn a_program_that_runs_elsewhere_is_nested() {
    let Some(desk) = Workshop::new() else {
        return;
    };
    let arm = r#"
schema = "composite/1"
[composite]
name = "arm"
[components.Gripper]
implementation = { process = ["python3", "absent.py"] }
"#;
    std::fs::write(desk.path("arm.composite.toml"), arm).unwrap();
    let outer = |hosts: [&str; 2]| {
        let [left, right] = hosts;
        let text = format!(
            r#"
schema = "composite/1"
[composite]
name = "robot"
[components.Left]
implementation = {{ composite = "arm.composite.toml" }}
[components.Right]
implementation = {{ composite = "arm.composite.toml" }}
[deploy]
processes = [
  {{ name = "left", host = "{left}", components = ["Left"] }},
  {{ name = "right", {right} components = ["Right"] }},
]
"#
        );
        std::fs::write(desk.path("robot.composite.toml"), text).unwrap();
        let (code, _, err) = desk.run(&["check", "robot.composite.toml"]);
        (
            code,
            err.contains("warning[C154]"),
            err.contains("error[C153]"),
        )
    };
    assert_eq!(
        outer(["robot", "host = \"robot\","]),
        (Some(0), true, false)
    );
    // the same file, of which this machine runs one instance
    assert_eq!(outer(["robot", ""]), (Some(1), false, true));
}

/// `asmotion up`, ended with the test.
struct Supervisor(Option<Child>);

impl Supervisor {
    fn end(mut self) -> Output {
        let child = self.0.take().unwrap();
        let id = child.id().to_string();
        let status = Command::new("kill").args(["-TERM", &id]).status();
        assert!(status.unwrap().success());
        child.wait_with_output().unwrap()
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            let id = child.id().to_string();
            let _ = Command::new("kill").args(["-TERM", &id]).status();
            let _ = child.wait();
        }
    }
}

#[test]
fn a_program_is_seen_changed_and_called_over_a_broker() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let Some((robot, desk)) = machines() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let with_bus = |machine: &Workshop, arguments: &[&str]| {
        let mut command = machine.command(arguments);
        command.args(["--bus", &url]);
        command.env("ASMOTION_PASSWORD", broker.password());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    };
    let up = with_bus(&robot, &["up", FILE, "--host", "robot"]).spawn();
    let up = Supervisor(Some(up.unwrap()));
    queues(&vhost, "robots.services.gripper.control.arm");
    let programs = until("the program", || program_below(up.0.as_ref()?.id()));

    let tool = |arguments: &[&str]| tool(&broker, &url, arguments);
    let (code, out, err) = tool(&["component", "info", "Gripper"]);
    assert_eq!(code, Some(0), "{err}");
    insta::assert_snapshot!("info", steady(&out));
    let (code, out, err) = tool(&["component", "info", "Gripper", "--json"]);
    assert_eq!(code, Some(0), "{err}");
    let info: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(info.to_string().contains("acme/GripperState"), "{info}");
    let (code, out, err) = tool(&["port", "read", "Gripper.state"]);
    assert_eq!(code, Some(0), "{err}");
    let state: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(state["opening"], 0.0, "{out}");
    let keys = [("Gripper", "\u{3}")];
    let seen = person((broker.password(), &url), &["top"], &keys);
    let (code, screen) = seen.unwrap();
    assert_eq!(code, Some(0), "{screen}");

    reconfigured(&robot, &tool);

    // the coordinator, on the machine that does not have the program
    let arguments = ["run", FILE, "--process", "brain", "--until", "mode=CLOSED"];
    let arguments = [&arguments[..], &["--for", "30", "--json"]].concat();
    let brain = with_bus(&desk, &arguments).output().unwrap();
    let (modes, code) = crate::processes::modes(&brain);
    assert_eq!(modes, ["OPENING", "CLOSING", "CLOSED"]);
    assert_eq!(code, Some(0));

    // the new version reaches the process that cannot ask the program, too
    let arguments = ["run", FILE, "--process", "brain", "--for", "60"];
    let brain = Supervisor(Some(with_bus(&desk, &arguments).spawn().unwrap()));
    queues(&vhost, "robots.services.gripper.control.brain");
    robot.change(&[("[[wires]]", DEPLOYED), ("speed = 0.2", "speed = 0.25")]);
    let path = robot.path(FILE);
    let (code, out, err) = tool(&["reconfigure", path.to_str().unwrap()]);
    let expected = "arm: `Gripper` has speed = 0.25\nbrain: no changes\n";
    assert_eq!((code, &*out), (Some(0), expected), "{err}");
    brain.end();

    let output = up.end();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{err}");
    until("the end of the program", || {
        (!is_running(programs)).then_some(())
    });
}

/// A property is changed, and a new program is not started.
fn reconfigured(robot: &Workshop, tool: &impl Fn(&[&str]) -> EndOfRun) {
    let path = robot.path(FILE);
    let reconfigure = || tool(&["reconfigure", path.to_str().unwrap()]);
    let (code, out, err) = reconfigure();
    assert_eq!((code, &*out), (Some(0), "arm: no changes\n"), "{err}");
    robot.change(&[("[[wires]]", DEPLOYED), ("speed = 0.2", "speed = 0.3")]);
    let (code, out, err) = reconfigure();
    let expected = "arm: `Gripper` has speed = 0.3\n";
    assert_eq!((code, &*out), (Some(0), expected), "{err}");
    robot.change(&[("[[wires]]", DEPLOYED), ("speed = 0.2", "speed = 0.9")]);
    let (code, _, err) = reconfigure();
    assert_eq!(code, Some(1), "{err}");
    assert!(err.contains("speed"), "{err}");
    let another = "[\"python3\", \"gripper.py\", \"--another\"]";
    let programs = ("[\"python3\", \"gripper.py\"]", another);
    robot.change(&[("[[wires]]", DEPLOYED), programs]);
    let (code, _, err) = reconfigure();
    assert_eq!(code, Some(1), "{err}");
    assert!(
        err.contains("it is no program of the running system"),
        "{err}"
    );
}

/// The process of the gripper below a process.
fn program_below(process: u32) -> Option<u32> {
    let is_gripper = |process: &u32| {
        let line = std::fs::read(Path::new("/proc").join(process.to_string()).join("cmdline"));
        String::from_utf8_lossy(&line.unwrap_or_default()).contains("gripper.py")
    };
    let children = children(process);
    let found = children.iter().copied().find(is_gripper);
    found.or_else(|| children.into_iter().find_map(program_below))
}

/// Replaces the numbers of cycles and their durations.
fn steady(text: &str) -> String {
    let mut steady = String::new();
    for line in text.lines() {
        let is_measured = line.trim_start().starts_with("cycle");
        let mut characters = line.chars().peekable();
        while let Some(character) = characters.next() {
            let is_number = is_measured && character.is_ascii_digit();
            steady.push(if is_number { '#' } else { character });
            let more = |it: &char| it.is_ascii_digit() || *it == '.';
            while is_number && characters.next_if(more).is_some() {}
        }
        steady.push('\n');
    }
    steady
}
