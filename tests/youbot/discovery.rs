//! Facts that a composite leaves out: the ports behind a proxy, and the names of providers.

use super::bench::Bench;
use asmotion_datum::Datum;

/// The driver with a proxy that lists its services only.
const UNLISTED: &str = r#"
schema = "composite/1"
promote = [
  { service = "Facade.sendingCommand", as = "sendingCommand" },
  { service = "Facade.retrievingStatus", as = "retrievingStatus" },
  { service = "Facade.settingPeriod", as = "settingPeriod" },
  { reference = "Facade.notifying", as = "notifying" },
]
[composite]
name = "driver"
[components.Robot]
implementation = { rust = "youbot::DummyDriver" }
activity   = { period_ms = 100 }
properties = { seed = 42 }
[components.Facade]
implementation = { builtin = "port-proxy", target = "Robot" }
activity   = { period_ms = 20 }
services   = { sendingCommand = "youbot/SendingCommands", retrievingStatus = "youbot/RetrievingStatus", settingPeriod = "youbot/SettingPeriod" }
references = { notifying = "youbot/Notifying" }
notify     = { reference = "notifying", busy = "command_written" }
"#;

const SCRIPT: &[&str] = &[
    "1 move 0.5 0.2 -0.3 0.4 0.1",
    "3 read",
    "3.5 period 0.05",
    "4 read",
];

fn replies(bench: &Bench) -> Vec<(String, Result<Datum, String>)> {
    let replies = bench.run(5).replies.into_iter();
    replies.map(|(name, _, result)| (name, result)).collect()
}

#[test]
fn j17_a_proxy_discovers_the_ports_of_its_target() {
    let listed = Bench {
        script: SCRIPT,
        ..Bench::default()
    };
    let discovered = Bench {
        driver: UNLISTED.to_owned(),
        script: SCRIPT,
        ..Bench::default()
    };
    assert_eq!(discovered.findings(), [""; 0]);
    let expected = replies(&listed);
    assert_eq!(expected.len(), 4);
    assert!(expected.iter().all(|(_, result)| result.is_ok()));
    assert_eq!(replies(&discovered), expected);
    let expanded = discovered.expanded();
    for port in ["commands", "period", "jointStatus"] {
        let mapped = format!("port = \"Driver/Robot.{port}\"");
        assert!(expanded.contains(&mapped), "{expanded}");
    }
}

#[test]
fn j17_the_proxy_of_an_unknown_robot_adapts_to_its_ports() {
    let six = UNLISTED
        .replace("youbot::DummyDriver", "test::SixJoints")
        .replace("properties = { seed = 42 }\n", "");
    let robot = |driver: String| Bench {
        driver,
        script: &["1 move 0.1 0.2 0.3 0.4 0.5 0.6", "2 read"],
        ..Bench::default()
    };
    // this robot has no input for a period
    let found = robot(six.clone()).findings();
    assert_eq!(found, ["C150"]);
    let without_period = six
        .replace(", settingPeriod = \"youbot/SettingPeriod\"", "")
        .replace(
            "  { service = \"Facade.settingPeriod\", as = \"settingPeriod\" },\n",
            "",
        );
    let mut bench = robot(without_period);
    bench.application = bench.application.replace(
        "  { reference = \"Client.period\", service = \"Driver.settingPeriod\", timeout_ms = 1000 },\n",
        "",
    );
    bench.application = bench
        .application
        .replace("period = \"youbot/SettingPeriod\", ", "");
    assert_eq!(bench.findings(), [""; 0]);
    let replies = replies(&bench);
    let read = replies[1].1.as_ref().unwrap().get("position").unwrap();
    let position: Vec<f64> = read.to().unwrap();
    assert_eq!(position, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
}

#[test]
fn j17_a_connection_that_is_written_is_not_made_again() {
    let written = UNLISTED.replace(
        "promote = [",
        "connections = [{ from = \"Robot.jointStatus\", to = \"Facade.jointStatus\", policy = { type = \"buffer\", size = 7 } }]\npromote = [",
    );
    let bench = Bench {
        driver: written,
        ..Bench::default()
    };
    assert_eq!(bench.findings(), [""; 0]);
    let expanded = bench.expanded();
    assert!(expanded.contains("size = 7"), "{expanded}");
    assert_eq!(
        expanded.matches("Driver/Facade.jointStatus").count(),
        1,
        "{expanded}"
    );
}

#[test]
fn c21_a_wire_finds_its_provider_by_interface() {
    let named = Bench {
        script: SCRIPT,
        ..Bench::default()
    };
    let mut typed = Bench {
        script: SCRIPT,
        ..Bench::default()
    };
    let interfaces = [
        ("Driver.sendingCommand", "youbot/SendingCommands"),
        ("Driver.settingPeriod", "youbot/SettingPeriod"),
        ("Driver.retrievingStatus", "youbot/RetrievingStatus"),
    ];
    for (service, interface) in interfaces {
        let by_name = format!("service = \"{service}\"");
        assert!(typed.application.contains(&by_name));
        let by_interface = format!("interface = \"{interface}\"");
        typed.application = typed.application.replace(&by_name, &by_interface);
    }
    assert_eq!(typed.findings(), [""; 0]);
    assert_eq!(typed.expanded(), named.expanded());
    assert_eq!(replies(&typed), replies(&named));
    // a second provider is ambiguous
    typed.application.push_str(
        "[components.Second]\nimplementation = { composite = \"driver.composite.toml\" }\n",
    );
    let found = typed.findings();
    assert_eq!(found.iter().filter(|code| **code == "C151").count(), 3);
}
