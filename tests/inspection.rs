//! Inspection and control of a running system over a broker: ports, schemas, life cycle, monitor.

use crate::person::person;
use crate::processes::{Running, navigation, over, tool, wait_until_present};
use std::process::Command;
use std::time::{Duration, Instant};

#[test]
fn ports_are_read_and_written_and_the_life_cycle_is_driven_from_outside() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let tool = |arguments: &[&str]| tool(&broker, &url, arguments);
    let composite = navigation().join("navigation.composite.toml");
    let _onboard = Running::start(&mut over(&composite, &broker, &vhost, Some("onboard")));
    wait_until_present(&vhost, "onboard");
    let refused = |arguments: &[&str], reason: &str| {
        let (code, _, err) = tool(arguments);
        assert_eq!(code, Some(2), "{arguments:?}");
        assert!(err.contains(reason), "{arguments:?}: {err}");
    };

    // J15: introspection has a stable format
    let (code, out, err) = tool(&["component", "info", "RoverDriver", "--json"]);
    assert_eq!(code, Some(0), "{err}");
    insta::assert_snapshot!("j15_a_component_as_json", out);

    // J13, J18: every mistake has its message, and does no harm
    let read = |port: &str| tool(&["port", "read", port]);
    let (code, out, err) = read("RoverDriver.odom");
    assert_eq!(code, Some(0), "{err}");
    let odom: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(odom["pose"]["pose"]["position"]["x"].is_f64(), "{out}");
    refused(&["port", "read", "RoverDriver"], "is not a port");
    refused(
        &["port", "read", "RoverDrive.odom"],
        "did you mean `RoverDriver`?",
    );
    refused(
        &["port", "read", "RoverDriver.odo"],
        "has no port `odo`; it has `wheels`, `odom`",
    );
    refused(&["port", "read", "RoverDriver.twist"], "is an input");
    refused(&["port", "write", "RoverDriver.odom", "{}"], "is an output");
    refused(&["port", "write", "RoverDriver.twist", "{"], "is not JSON");
    refused(
        &[
            "port",
            "write",
            "RoverDriver.twist",
            r#"{"linear": "fast"}"#,
        ],
        "`RoverDriver.twist` takes geometry_msgs/Twist: `linear`",
    );
    refused(
        &["port", "write", "RoverDriver.twist", r#"{"lineal": {}}"#],
        "lineal",
    );
    let (code, _, err) = tool(&[
        "port",
        "write",
        "RoverDriver.twist",
        r#"{"linear": {"x": 0}}"#,
    ]);
    assert_eq!(code, Some(0), "{err}");

    // J8: the life cycle, with RTT's guards
    let state = || tool(&["component", "info", "LaserDriver"]).1;
    let go = |what: &str| {
        let (code, _, err) = tool(&["component", what, "LaserDriver"]);
        assert_eq!(code, Some(0), "{what}: {err}");
    };
    refused(&["component", "cleanup", "LaserDriver"], "it is Running");
    go("stop");
    go("cleanup");
    assert!(state().contains("PreOperational"), "{}", state());
    refused(
        &["component", "start", "LaserDriver"],
        "it is PreOperational",
    );
    refused(
        &["component", "reset", "LaserDriver"],
        "it is PreOperational",
    );
    go("configure");
    go("start");
    assert!(state().contains("Running"), "{}", state());

    properties(&tool);
    monitor(broker.password(), &url);
}

/// Exit code, standard output and standard error.
type Said = (Option<i32>, String, String);

/// O12: properties are saved, compared and loaded.
fn properties(all: &dyn Fn(&[&str]) -> Said) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("laser.toml");
    let file = path.to_str().unwrap();
    let tool = |what: &str| all(&["component", what, "LaserDriver", file]);
    let (code, _, err) = tool("save");
    assert_eq!(code, Some(0), "{err}");
    let saved = std::fs::read_to_string(&path).unwrap();
    assert!(saved.contains("\nnoise_m = "), "{saved}");
    assert_eq!(tool("diff").0, Some(0));

    std::fs::write(&path, "noise_m = 0.25\n").unwrap();
    let (code, out, err) = tool("diff");
    assert_eq!(code, Some(1), "{err}");
    assert!(out.contains("noise_m: 0.25 in the file, "), "{out}");
    assert!(out.contains(": not in the file"), "{out}");
    let (code, _, err) = tool("load");
    assert_eq!(code, Some(0), "{err}");
    assert!(err.contains("Kept"), "{err}");
    assert!(!tool("diff").1.contains("noise_m"));

    // as RTT writes it
    let cpf = folder.path().join("laser.cpf");
    let simple = "<simple name=\"noise_m\" type=\"double\"><value>0.125</value></simple>";
    let text = format!("<?xml version=\"1.0\"?>\n<properties>{simple}</properties>\n");
    std::fs::write(&cpf, text).unwrap();
    let loaded = all(&["component", "load", "LaserDriver", cpf.to_str().unwrap()]);
    assert_eq!(loaded.0, Some(0), "{}", loaded.2);
    assert!(
        tool("diff")
            .1
            .contains("noise_m: 0.25 in the file, 0.125 in the component")
    );
    assert_eq!(tool("load").0, Some(0));

    std::fs::write(&path, "noise_m = 0.5\nnoise = 1\n").unwrap();
    let (code, _, err) = tool("load");
    assert_eq!(code, Some(1), "{err}");
    assert!(err.contains("unknown property `noise`"), "{err}");
    std::fs::write(&path, "noise_m = 0.25\n").unwrap();
    assert!(!tool("diff").1.contains("noise_m"), "nothing was set");
}

/// In a real terminal: the monitor uses the alternate screen, shows the system, and restores the terminal on Ctrl-C.
fn monitor(password: &str, url: &str) {
    let keys = [("RoverDriver", "\u{3}")];
    let Some((code, screen)) = person((password, url), &["top"], &keys) else {
        return;
    };
    assert_eq!(code, Some(0), "{screen}");
    let (enters, leaves) = ("\u{1b}[?1049h", "\u{1b}[?1049l");
    assert!(
        screen.contains(enters) && screen.contains(leaves),
        "{screen:?}"
    );
    assert!(screen.rfind(leaves) > screen.rfind(enters), "{screen:?}");
    assert!(screen.contains("RoverDriver"), "{screen:?}");
}

#[test]
fn the_monitor_wants_a_terminal() {
    let output = Command::new(env!("CARGO_BIN_EXE_asmotion"))
        .args(["top", "--bus", "amqp://a@127.0.0.1:1"])
        .env("ASMOTION_PASSWORD", "a")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("needs a terminal"), "{said}");
}

/// In one process, on an internal bus: the monitor ends with the run.
#[test]
fn the_monitor_stands_beside_a_run_without_a_broker() {
    let composite = navigation().join("navigation.composite.toml");
    let run = ["run", composite.to_str().unwrap(), "--top", "--speed", "4"];
    let keys = [("Operator", "q")];
    let Some((code, screen)) = person(("", ""), &run, &keys) else {
        return;
    };
    assert_eq!(code, Some(1), "{screen}");
    assert!(screen.contains("components"), "{screen}");
    assert!(screen.contains("stopped"), "{screen}");
}

#[test]
fn a_run_that_is_looked_at_wants_a_terminal() {
    let mut run = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let composite = navigation().join("navigation.composite.toml");
    let output = run.arg("run").arg(composite).arg("--top").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("`--top` needs a terminal"), "{said}");
}

/// The library over RabbitMQ: the same handle as on the in-process bus.
#[test]
fn t15_j7_j8_j16_a_robot_on_a_broker_is_at_hand() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let composite = navigation().join("navigation.composite.toml");
    let _onboard = Running::start(&mut over(&composite, &broker, &vhost, Some("onboard")));
    wait_until_present(&vhost, "onboard");
    let rover = asmotion_remote::Remote::connect(&vhost.url(), Some("navigation")).unwrap();
    assert_eq!(rover.components().len(), 6);
    let follower = rover.component("TrajectoryFollower").unwrap();
    follower.set("max_speed", 0.25).unwrap();
    assert_eq!(follower.get::<f64>("max_speed"), Ok(0.25));
    let laser = rover.component("LaserDriver").unwrap();
    laser
        .transition(asmotion_component::Transition::Stop)
        .unwrap();
    assert_eq!(laser.state(), Ok(asmotion_component::State::Stopped));
    let driver = rover.component("navigation.RoverDriver").unwrap();
    let mut watch = driver.watch("odom").unwrap();
    for _ in 0..3 {
        let odom = watch.next_within(Duration::from_secs(10));
        let odom = odom.unwrap().content.unwrap();
        assert!(odom.get("pose.pose.position.x").is_some(), "{odom}");
    }
    // the supervisor's components have an `id`
    let _supervisor = Running::start(&mut over(&composite, &broker, &vhost, Some("supervisor")));
    wait_until_present(&vhost, "supervisor");
    // `rover` hears of it on a connection of its own
    let until = Instant::now() + Duration::from_secs(10);
    while rover.component("planner").is_err() && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(50));
    }
    for name in ["planner", "navigation.planner"] {
        assert_eq!(
            rover.component(name).unwrap().present().name,
            "TrajectoryPlanner"
        );
    }
    let other = asmotion_remote::Remote::connect(&vhost.url(), Some("other")).unwrap();
    assert!(other.components().is_empty(), "it is another robot's");
}

#[test]
fn t18_c21_services_are_found_by_their_interface_and_a_stopped_component_is_named() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let tool = |arguments: &[&str]| tool(&broker, &url, arguments);
    let composite = navigation().join("navigation.composite.toml");
    let mut supervisor = over(&composite, &broker, &vhost, Some("supervisor"));
    // without a goal, which would fail without the other process, it runs until the end of the test
    supervisor.args(["--set", "Operator.script=[]"]);
    let _supervisor = Running::start(&mut supervisor);
    wait_until_present(&vhost, "supervisor");

    let offers = |interface: &str| tool(&["component", "list", "--offers", interface]);
    let (code, out, err) = offers("nav/PlanService");
    assert_eq!(code, Some(0), "{err}");
    let rows: Vec<Vec<&str>> = out
        .lines()
        .map(|it| it.split_whitespace().collect())
        .collect();
    let address = "navigation.TrajectoryPlanner.planning";
    let row = ["TrajectoryPlanner", "navigation", "supervisor", "Running"];
    assert_eq!(rows[1], [&[address], &row[..]].concat(), "{out}");
    assert_eq!(rows.len(), 2, "{out}");
    let (code, _, err) = offers("nav/PlanServise");
    assert_eq!(code, Some(1));
    assert!(err.contains("did you mean `nav/PlanService`?"), "{err}");

    for component in ["TrajectoryPlanner", "MapServer"] {
        let (code, _, err) = tool(&["component", "stop", component]);
        assert_eq!(code, Some(0), "{err}");
    }
    let begun = Instant::now();
    let (code, _, err) = tool(&["call", "nav/PlanService.plan", "--timeout", "30"]);
    assert!(begun.elapsed() < Duration::from_secs(20), "it waited");
    assert_eq!(code, Some(1), "{err}");
    let reason = "component `navigation.TrajectoryPlanner` does not run";
    assert!(err.contains(reason), "{err}");
    // maps need no cycle
    let (_, info, _) = tool(&["component", "info", "MapServer"]);
    let operation =
        "MapServer.maps.getMap: nav/Place -> nav_msgs/OccupancyGrid (also while stopped)";
    assert!(info.contains(operation), "{info}");
    let (code, out, err) = tool(&["call", "nav/MapService.getMap", r#"{"name": "office"}"#]);
    assert_eq!(code, Some(0), "{err}");
    let map: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(map["header"]["frame_id"], "map");
}
