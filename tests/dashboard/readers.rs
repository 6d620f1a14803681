//! What the dashboard offers to other programs, read by packages that know nothing of asmotion: channels in the protocol of
//! Foxglove, and figures in the text format of Prometheus.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use asmotion_skip::Requirement;
use serde_json::Value;

use crate::mission::RunningMission;

/// Versions of the packages.
const PACKAGES: [&str; 4] = [
    "jsonschema==4.25.1",
    "mcap-ros2-support==0.5.7",
    "prometheus_client==0.23.1",
    "websockets==15.0.1",
];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/dashboard")
        .join(name)
}

/// Returns a Python with the packages in `target/dashboard`, installed if one is missing.
fn python() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/dashboard/venv");
    let python = folder.join("bin/python");
    let has_packages = || {
        let imports = "import jsonschema, mcap_ros2, prometheus_client, websockets.sync.client";
        let tried = Command::new(&python).args(["-c", imports]).output();
        tried.is_ok_and(|it| it.status.success())
    };
    if !has_packages() {
        let mut venv = Command::new("python3");
        let made = venv.args(["-m", "venv"]).arg(&folder).output();
        if made.is_ok_and(|it| it.status.success()) {
            let mut pip = Command::new(&python);
            pip.args(["-m", "pip", "install", "--quiet"]).args(PACKAGES);
            let _ = pip.output();
        }
    }
    if has_packages() {
        return Some(python);
    }
    asmotion_skip::PYPI.skip();
    None
}

fn output(command: &mut Command, input: &str) -> Value {
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut process = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = process.stdin.take().unwrap();
    stdin.write_all(input.as_bytes()).unwrap();
    drop(stdin);
    let output = process.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The text at a path of a dashboard.
fn text(address: &str, path: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    text.split_once("\r\n\r\n").unwrap().1.to_owned()
}

/// Packages of npm, with their versions.
const NODE_PACKAGES: [&str; 4] = [
    "@foxglove/ws-protocol@0.8.0",
    "@foxglove/rosmsg@5.0.5",
    "@foxglove/rosmsg2-serialization@3.1.0",
    "ws@8.18.3",
];

/// Returns a folder with the packages of npm in `target/dashboard`, installed if they are missing.
fn node() -> Option<PathBuf> {
    const NPM: Requirement<'_> = Requirement {
        name: "typescript",
        tests: "the tests with packages of npm",
        remedy: "Install `node` and `npm`, and make the registry of npm reachable",
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/dashboard/npm");
    let has_packages = || {
        let packages = ["ws-protocol", "rosmsg", "rosmsg2-serialization"];
        let modules = folder.join("node_modules");
        let mut packages = packages.iter().map(|it| modules.join("@foxglove").join(it));
        packages.all(|it| it.exists()) && modules.join("ws").exists()
    };
    if !has_packages() {
        std::fs::create_dir_all(&folder).unwrap();
        let mut npm = Command::new("npm");
        npm.args(["install", "--silent", "--prefix"]).arg(&folder);
        let _ = npm.args(NODE_PACKAGES).output();
    }
    if has_packages() {
        return Some(folder);
    }
    NPM.skip();
    None
}

#[test]
fn a_viewer_decodes_every_message_of_a_mission() {
    let Some(python) = python() else { return };
    let mission = RunningMission::start(&[]);
    let mut command = Command::new(python);
    command
        .arg(file("viewer.py"))
        .args([mission.address(), "8"]);
    check_channels(&output(&mut command, ""));
}

#[test]
fn the_client_of_foxglove_decodes_every_message_of_a_mission() {
    let Some(folder) = node() else { return };
    let mission = RunningMission::start(&[]);
    let mut command = Command::new("node");
    command
        .arg(file("viewer.mjs"))
        .args([mission.address(), "8"]);
    check_channels(&output(command.current_dir(folder), ""));
}

/// Checks what a viewer has seen of the mission.
fn check_channels(seen: &Value) {
    assert_eq!(seen["info"]["metadata"]["composite"], "both");
    let channels = seen["channels"].as_object().unwrap();
    let channel = |name: &str| {
        let known: Vec<&String> = channels.keys().collect();
        channels
            .get(name)
            .unwrap_or_else(|| panic!("no `{name}` in {known:?}"))
    };
    for (name, schema) in [
        ("log", "foxglove.Log"),
        ("asm/Rover/ASMCoordinator/step", "asmotion.Step"),
        ("asm/Rover/ASMCoordinator/state", "asmotion.State"),
        ("frame/Rover/RoverDriver.odom", "foxglove.FrameTransform"),
        ("topic/Rover/odom", "nav_msgs/msg/Odometry"),
        ("port/Rover/LaserDriver.scan", "sensor_msgs/msg/LaserScan"),
        (
            "port/Rover/LaserDriver.mounting",
            "geometry_msgs/msg/TransformStamped",
        ),
        ("port/Rover/MapServer.map", "nav_msgs/msg/OccupancyGrid"),
        ("topic/Rover/plan", "nav_msgs/msg/Path"),
    ] {
        let channel = channel(name);
        assert_eq!(channel["schema"], schema, "{name}");
        assert!(channel["count"].as_u64().unwrap() > 0, "{name}: {channel}");
    }
    let state = &channel("asm/Rover/ASMCoordinator/state")["last"];
    assert_eq!(state["control_state"], state["values"]["mode"]);
    assert!(state["control_state"].is_string(), "{state}");
    // the frame is where the odometry says, in the same frames
    let frame = &channel("frame/Rover/RoverDriver.odom")["last"];
    assert_eq!(
        (&frame["parent_frame_id"], &frame["child_frame_id"]),
        (&"map".into(), &"base_link".into())
    );
    // the scan can be drawn: its frame is mounted on that of the robot
    let mounting = &channel("port/Rover/LaserDriver.mounting")["last"];
    let scan = &channel("port/Rover/LaserDriver.scan")["last"];
    assert_eq!(
        (&mounting["header"]["frame_id"], &mounting["child_frame_id"]),
        (&frame["child_frame_id"], &scan["header"]["frame_id"])
    );
    // 50 in a second on a quiet machine
    let odom = channel("topic/Rover/odom");
    let count = odom["count"].as_u64().unwrap();
    assert!(count > 20, "{odom}");
}

#[test]
fn the_parser_of_prometheus_reads_the_figures() {
    let Some(python) = python() else { return };
    let mission = RunningMission::start(&[]);
    // the first description of the components arrives within a second
    let families = loop {
        let figures = text(mission.address(), "/metrics");
        let mut command = Command::new(&python);
        let families = output(command.arg(file("metrics.py")), &figures);
        if !families["asmotion_component_running"].is_null() {
            break families;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    };
    let families = families.as_object().unwrap();
    assert!(families.len() > 15, "{families:?}");
    for (name, family) in families {
        // units are those of the base, and counters say that they are
        for unit in ["_ms", "_us", "_hz", "_percent", "_total_seconds"] {
            assert!(!name.ends_with(unit), "{name}");
        }
        assert!(name.starts_with("asmotion_"), "{name}");
        assert!(family["help"].as_str().unwrap().ends_with('.'), "{name}");
        let is_counter = family["type"] == "counter";
        assert!(is_counter || family["type"] == "gauge", "{name}");
        for sample in family["samples"].as_array().unwrap() {
            let sampled = sample[0].as_str().unwrap();
            assert_eq!(sampled.ends_with("_total"), is_counter, "{sampled}");
        }
    }
    let running = families["asmotion_component_running"]["samples"]
        .as_array()
        .unwrap();
    let of = |name: &str| running.iter().find(|it| it[1]["component"] == name);
    assert_eq!(of("Rover/RoverDriver").unwrap()[2], 1.0);
}
