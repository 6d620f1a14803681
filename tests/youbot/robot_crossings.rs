//! A component that stands for one of another robot, together with reconfiguration, profiles, missions, traces and the shell.

use asmotion_broker::Vhost;

use super::another_robot::{Client, STATION, Site, Station};
use crate::processes::queues;

/// Runs a command. Returns its exit code and all that it printed.
fn asmotion(arguments: &[&str], input: &str) -> (Option<i32>, String) {
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(arguments).env_remove("ASMOTION_BUS");
    let output = command.write_stdin(input).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).unwrap())
}

/// A tool on the broker of a test.
fn tool(vhost: &Vhost<'_>, arguments: &[&str], input: &str) -> (Option<i32>, String) {
    asmotion(&[arguments, &["--bus", &vhost.url()]].concat(), input)
}

#[test]
fn a_station_is_reconfigured_while_it_controls_another_robot() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let _arm = site.arm(6);
    let _station = site.station();
    let client = Client::new(&vhost);
    client.reaches(&[0.0; 6]);
    let becomes = |changes: &[(&str, &str)]| {
        let mut text = STATION.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let path = site.write("station", &text);
        tool(&vhost, &["reconfigure", path.to_str().unwrap()], "")
    };
    let (code, said) = becomes(&[]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(
        said, "station: no changes\n",
        "no warning that no robot was asked"
    );

    let slower = ("period_ms = 20", "period_ms = 40");
    let (code, said) = becomes(&[slower]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("`Facade` cycles every 40ms"), "{said}");
    let goal = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
    client.command(&goal).unwrap();
    client.reaches(&goal);

    // neither another component of the robot nor a second stand-in can be connected while the station runs
    let other = ("robot://arm/Driver", "robot://arm/Drive");
    let second = "[components.Second]\nimplementation = { builtin = \"remote\", target = \"robot://arm/Driver\" }\n[components.Facade]";
    for (changed, reasons) in [
        (
            other,
            [
                "C158",
                "it is no component of the running system; a new one needs a start of the system",
            ],
        ),
        (("[components.Facade]", second), ["NEEDS_START", "`Second`"]),
    ] {
        let (code, said) = becomes(&[slower, changed]);
        assert_eq!(code, Some(1), "{said}");
        for reason in reasons {
            assert!(said.contains(reason), "{reason}: {said}");
        }
        assert!(said.contains("`station` runs unchanged"), "{said}");
        assert!(!said.contains("C159"), "{said}");
    }
    let goal = [0.2; 6];
    client.command(&goal).unwrap();
    client.reaches(&goal);
}

/// A proxy for a driver of its own in the profile `sim`, and for that of the robot in the profile `real`.
const WITH_PROFILES: &str = r#"
schema = "composite/1"
[composite]
name = "station"
[components.Own]
profile = "sim"
implementation = { rust = "youbot::DummyDriver" }
activity = { period_ms = 20 }
properties = { joints = 6, speed = 10.0 }
[components.Arm]
profile = "real"
implementation = { builtin = "remote", target = "robot://arm/Driver" }
[components.OwnFacade]
profile = "sim"
implementation = { builtin = "port-proxy", target = "Own" }
activity = { period_ms = 20 }
services = { reading = "youbot/RetrievingStatus" }
[components.Facade]
profile = "real"
implementation = { builtin = "port-proxy", target = "Arm" }
activity = { period_ms = 20 }
services = { reading = "youbot/RetrievingStatus" }
"#;

#[test]
fn a_profile_decides_whether_a_run_or_a_mission_needs_the_other_robot() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let composite = write("station.composite.toml", WITH_PROFILES);
    let (code, said) = asmotion(&["run", &composite, "--profile", "sim", "--for", "1"], "");
    assert_eq!(code, Some(0), "{said}");
    let reason =
        "`robot://arm/Driver` is a component of another robot, which is reached over a broker";
    let (code, said) = asmotion(&["run", &composite, "--profile", "real", "--for", "1"], "");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains(reason), "{said}");
    let mission = |profile: &str, facade: &str| {
        let text = format!(
            "schema = \"mission/1\"\ncomposite = \"station.composite.toml\"\nprofile = \"{profile}\"\nlimit_s = 1\n\n\
             [[expect]]\neventually = \"state({facade}) = Running\"\n"
        );
        write(&format!("{profile}.mission.toml"), &text)
    };
    let (code, said) = asmotion(&["test", &mission("sim", "OwnFacade")], "");
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = asmotion(&["test", &mission("real", "Facade")], "");
    assert_eq!(code, Some(2), "{said}");
    for expected in [
        "error[V036]",
        reason,
        "real.mission.toml:2",
        "select another one with `profile`",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
}

/// Counts what it receives of the other robot.
const WATCH: &str = "asm watch
import StandardLibrary
signature:
  monitored position: Seq(Real)
  controlled seen: Integer
  controlled joints: Integer
definitions:
  main rule r_Main =
    if isDef(position) then
      par
        seen := seen + 1
        joints := length(position)
      endpar
    endif
default init s0:
  function seen = 0
  function joints = 0
";

const WATCHED: &str = r#"
[components.Watch]
implementation = { asm = "watch.asm" }
activity = { period_ms = 100 }
ports.in = { status = "youbot/JointStatus" }
bind.monitored = { position = { topic = "status", field = "position" } }
[[connections]]
from = "Arm.jointStatus"
to = "Watch.status"
"#;

#[test]
fn a_trace_of_a_specification_that_reads_another_robot_replays_without_it() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let arm = site.arm(6);
    let station = site.write("station", &(STATION.to_owned() + WATCHED));
    let beside = |name: &str| station.with_file_name(name);
    let (watch, trace) = (beside("watch.asm"), beside("station.trace"));
    std::fs::write(&watch, WATCH).unwrap();
    let (trace_path, watch_path) = (trace.to_str().unwrap(), watch.to_str().unwrap());
    let mut run = site.run(&station, &["--trace", trace_path, "--until", "seen=5"]);
    let (code, said) = Station::start(&mut run).end();
    assert_eq!(code, Some(0), "{said}");
    drop(arm);
    let (code, said) = asmotion(&["sim", watch_path, "--replay-inputs", trace_path], "");
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("seen: 4 → 5") || said.contains("seen := 5"),
        "{said}"
    );
    assert!(said.contains("joints"), "{said}");
}

#[test]
fn tools_show_and_call_a_component_of_another_robot_by_its_short_name() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let _arm = site.arm(6);
    let _station = site.station();
    Client::new(&vhost).reaches(&[0.0; 6]);
    let (code, said) = tool(
        &vhost,
        &["shell"],
        "ls\ncd Arm\nls\nread jointStatus\ncd ..\nFacade.getJointsPositions()\nexit\nls\n",
    );
    assert_eq!(code, Some(0), "{said}");
    for shown in ["Arm: Running in process station", "youbot/JointStatus"] {
        assert!(said.contains(shown), "{shown}: {said}");
    }
    assert_eq!(said.matches("\"position\"").count(), 2, "{said}");
    assert!(!said.contains("error:"), "{said}");
    for operation in [
        "station.Facade.reading.getJointsPositions",
        "Facade.reading.getJointsPositions",
        "Facade.getJointsPositions",
    ] {
        let (code, said) = tool(&vhost, &["call", operation], "");
        assert_eq!(code, Some(0), "{operation}: {said}");
        assert!(said.contains("\"position\""), "{operation}: {said}");
    }
    let (code, said) = tool(&vhost, &["call", "Facade.reading.getJointPositions"], "");
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("did you mean `station.Facade.reading.getJointsPositions`?"),
        "{said}"
    );

    // a second robot has a component of the name
    let other = STATION.replace("name = \"station\"", "name = \"other\"");
    let _other = site.robot(&site.write("other", &other), &[]);
    queues(&vhost, "robots.services.other.control.other");
    let (code, said) = tool(&vhost, &["component", "info", "Facade"], "");
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("ambiguous name `Facade`: other.Facade, station.Facade"),
        "{said}"
    );
    let (code, said) = tool(&vhost, &["call", "Facade.getJointsPositions"], "");
    assert_eq!(code, Some(2), "{said}");
    let candidates =
        "other.Facade.reading.getJointsPositions, station.Facade.reading.getJointsPositions";
    assert!(said.contains(candidates), "{said}");
}
