//! Data-flow components, and composites that provide them as services.

use super::bench::Bench;
use asmotion_messages::{JointCommand, JointStatus};
use asmotion_runtime::{Run, Simulation};
use std::time::Duration;

/// The names of a component's inputs, outputs, services and references.
fn face(simulation: &Simulation, component: &str) -> [Vec<String>; 4] {
    let declared = simulation.declaration(component).unwrap();
    [
        declared.inputs.iter().map(|it| it.name.clone()).collect(),
        declared.outputs.iter().map(|it| it.name.clone()).collect(),
        declared.services.iter().map(|it| it.name.clone()).collect(),
        declared
            .references
            .iter()
            .map(|it| it.name.clone())
            .collect(),
    ]
}

#[test]
fn y2_the_driver_reads_commands_and_writes_what_the_joints_do() {
    let (mut simulation, log) = Bench::default().simulate();
    let [inputs, outputs, ..] = face(&simulation, "Driver/youBotDriver");
    assert_eq!(inputs, ["commands", "period"]);
    assert_eq!(outputs, ["jointStatus"]);
    let command = JointCommand {
        position: vec![0.1, -0.2, 0.3, -0.4, 0.5],
        ..JointCommand::default()
    };
    let now = simulation.now();
    let port = "Driver/youBotDriver.commands";
    simulation.inject(now, port, command.clone()).unwrap();
    simulation.run_for(Duration::from_secs(2));
    let log = log.lock().unwrap();
    let (_, status): &(_, JointStatus) = log.statuses.last().unwrap();
    assert_eq!(status.position, command.position);
    // the proxy commanded nothing, so it waits for nothing
    assert_eq!(log.events(), [""; 0]);
}

#[test]
fn y3_the_proxy_is_declared_and_offers_services_for_ports() {
    let script = &["1 move 0.5 0.2 -0.3 0.4 0.1", "3 read"];
    let (mut simulation, log) = Bench {
        script,
        ..Bench::default()
    }
    .simulate();
    let [.., services, references] = face(&simulation, "Driver/SCAyouBotDriver");
    assert_eq!(
        services,
        ["sendingCommand", "retrievingStatus", "settingPeriod"]
    );
    assert_eq!(references, ["notifying"]);
    simulation.run_for(Duration::from_secs(4));
    let log = log.lock().unwrap();
    let read = log.replies[1].2.as_ref().unwrap();
    let position: Vec<f64> = read.get("position").unwrap().to().unwrap();
    assert_eq!(position, [0.5, 0.2, -0.3, 0.4, 0.1]);
}

/// The driver's composite with a gripper of two joints beside the arm, which has its own proxy.
fn with_gripper() -> String {
    let arm = Bench::default().driver;
    let service = r#"{ service = "SCAyouBotDriver.retrievingStatus""#;
    let reading = arm.replace(service, r#"{ service = "SCAGripper.retrievingStatus""#);
    let joined = r#"connections = [
  { from = "SCAGripper.commands", to = "gripper.commands" },
  { from = "SCAGripper.period", to = "gripper.period" },
  { from = "gripper.jointStatus", to = "SCAGripper.jointStatus", policy = { type = "buffer", size = 32 } },"#;
    let reading = reading.replace("connections = [", joined);
    assert!(reading.contains("SCAGripper.r") && reading.contains("gripper.j"));
    reading
        + r#"
[components.gripper]
implementation = { rust = "youbot::DummyDriver" }
activity   = { period_ms = 50 }
ports.in   = { commands = "youbot/JointCommand", period = "std_msgs/Float64" }
ports.out  = { jointStatus = "youbot/JointStatus" }
properties = { joints = 2 }

[components.SCAGripper]
implementation = { builtin = "port-proxy", target = "gripper" }
activity   = { period_ms = 20 }
services   = { sendingCommand = "youbot/SendingCommands", retrievingStatus = "youbot/RetrievingStatus", settingPeriod = "youbot/SettingPeriod" }
map = [
  { operation = "sendingCommand.setJointsPositions", port = "gripper.commands", mode = "oneway" },
  { operation = "retrievingStatus.getJointsPositions", port = "gripper.jointStatus", mode = "last" },
  { operation = "settingPeriod.setPeriod", port = "gripper.period", mode = "oneway" },
]
"#
}

#[test]
fn c13_one_facade_hides_several_data_flow_components() {
    let bench = Bench {
        driver: with_gripper(),
        script: &["1 move 0.5 0.2 -0.3 0.4 0.1", "3 read"],
        ..Bench::default()
    };
    let log = bench.run(4);
    // the client sees a single service: the arm obeys, the gripper reports
    assert_eq!(log.events(), ["busy", "idle"]);
    let read = log.replies[1].2.as_ref().unwrap();
    assert_eq!(read.get("position").unwrap().count(), Some(2));
}

/// Two arms, each a nested composite, in a composite without components of its own.
const PAIR: &str = r#"
schema = "composite/1"
promote = [
  { service = "Left.sendingCommand", as = "sendingCommand" },
  { service = "Left.settingPeriod", as = "settingPeriod" },
  { reference = "Left.notifying", as = "notifying" },
  { service = "Right.retrievingStatus", as = "retrievingStatus" },
]
[composite]
name = "pair"
[components.Left]
implementation = { composite = "inner.composite.toml" }
[components.Right]
implementation = { composite = "inner.composite.toml" }
properties = { joints = 6 }
"#;

#[test]
fn j4_data_flow_components_stand_in_a_hierarchy_of_composites() {
    let inner = Bench::default().driver;
    let must = r#"notifying = "youbot/Notifying""#;
    // the right arm has no listener
    let may = r#"notifying = { interface = "youbot/Notifying", optional = true }"#;
    assert!(inner.contains(must));
    let (mut simulation, log) = Bench {
        driver: PAIR.to_owned(),
        inner: Some(inner.replace(must, may)),
        script: &["1 move 0.5 0.2 -0.3 0.4 0.1", "3 read"],
        ..Bench::default()
    }
    .simulate();
    let components = simulation.components();
    for arm in ["Left", "Right"] {
        let driver = format!("Driver/{arm}/youBotDriver");
        assert!(components.contains(&driver), "{components:?}");
    }
    simulation.run_for(Duration::from_secs(4));
    let log = log.lock().unwrap();
    assert_eq!(log.events(), ["busy", "idle"], "of the left arm");
    let read = log.replies[1].2.as_ref().unwrap();
    assert_eq!(read.get("position").unwrap().count(), Some(6));
}
