//! `asmotion check --connections`: the connections between components and their guarantees.

use std::collections::BTreeMap;

/// The output for each connection of a composite, by `from → to`: its transport and its guarantee.
fn ways(composite: &str) -> BTreeMap<String, (String, String)> {
    let mut check = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    check.current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = check.args(["check", "--connections", composite]).output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let cells = |line: &str| -> Vec<String> {
        let cells = line.split("  ").map(str::trim);
        cells
            .filter(|it| !it.is_empty())
            .map(str::to_owned)
            .collect()
    };
    let rows = text.lines().map(cells).filter(|row| row.len() == 5);
    let way = |row: Vec<String>| {
        let [from, to, _, way, promise] = <[String; 5]>::try_from(row).unwrap();
        (format!("{from} → {to}"), (way, promise))
    };
    rows.skip(1).map(way).collect()
}

#[test]
fn j21_the_real_time_path_of_the_navigation_and_of_the_youbot_has_no_broker_hop() {
    let navigation = ways("specs/navigation/navigation.composite.toml");
    let youbot = ways("specs/youbot/youbot.composite.toml");
    let inside = ("in process, lock-free".to_owned(), "real time".to_owned());
    // from measurements to commands
    for hop in [
        "World.encoders → RoverDriver.encoders",
        "RoverDriver.odom → TrajectoryFollower.odom",
        "LaserDriver.scan → TrajectoryAdapter.scan",
        "TrajectoryAdapter.adapted → TrajectoryFollower.path",
        "TrajectoryFollower.twist → CollisionMonitor.command",
        "LaserDriver.scan → CollisionMonitor.scan",
        "CollisionMonitor.twist → RoverDriver.twist",
        "RoverDriver.wheels → World.wheels",
    ] {
        assert_eq!(navigation.get(hop), Some(&inside), "{hop}: {navigation:#?}");
    }
    for hop in [
        "Driver/youBotDriver.jointStatus → Driver/SCAyouBotDriver.jointStatus",
        "Driver/SCAyouBotDriver.commands → Driver/youBotDriver.commands",
    ] {
        assert_eq!(youbot.get(hop), Some(&inside), "{hop}: {youbot:#?}");
    }
    // connections that are not real-time capable are listed as such
    let broker = ("over the broker".to_owned(), "not real time".to_owned());
    let plan = "ASMCoordinator.plan → TrajectoryAdapter.path";
    assert_eq!(navigation.get(plan), Some(&broker), "{navigation:#?}");
    let send = "Locomotor.send → Driver/SCAyouBotDriver.sendingCommand";
    assert_eq!(youbot.get(send), Some(&broker), "{youbot:#?}");
}

#[test]
fn j21_a_wire_that_names_a_broker_goes_over_it_inside_of_a_process_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pair.composite.toml");
    let text = r#"
schema = "composite/1"
[composite]
name = "pair"
[brokers.main]
url = "amqp://rover1/cell"
[components.Operator]
implementation = { rust = "youbot::Operator" }
references = { move = { interface = "youbot/Locomotion", optional = true } }
services = { notifying = "youbot/Notifying" }
[components.Proxy]
implementation = { builtin = "port-proxy", target = "Arm" }
services = { retrievingStatus = "youbot/RetrievingStatus" }
references = { notifying = "youbot/Notifying" }
map = [{ operation = "retrievingStatus.getJointsPositions", port = "Arm.jointStatus", mode = "last" }]
notify = { reference = "notifying", refresh = "jointStatus.new" }
[components.Arm]
implementation = { rust = "youbot::DummyDriver" }
[[wires]]
reference = "Proxy.notifying"
service = "Operator.notifying"
binding = "amqp"
oneway = true
[[connections]]
from = "Arm.jointStatus"
to = "Proxy.jointStatus"
policy = { type = "data", lock = "locked" }
"#;
    std::fs::write(&path, text).unwrap();
    let mut check = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = check.args(["check", "--connections"]).arg(&path).output();
    let text = String::from_utf8(output.unwrap().stdout).unwrap();
    insta::assert_snapshot!(text);
}
