//! `asmotion shell`: sessions of a user or from a pipe, in a running system.

use std::path::Path;
use std::process::{Command, Stdio};

use asmotion_broker::{SharedBroker, Vhost};

use crate::person::person;
use crate::processes::{Running, through};

/// The youBot's driver and its proxy, on the broker of a test.
fn arm(broker: &SharedBroker, vhost: &Vhost<'_>) -> Running {
    let composite =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/youbot/youbot.composite.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    // longer than a test on a busy machine; no test reads its output, which would fill a pipe
    command.arg("run").arg(composite).args(["--for", "900"]);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    Running::start(&mut through(command, broker, vhost, Some("robot")))
}

fn url(broker: &SharedBroker, vhost: &Vhost<'_>) -> String {
    let (user, address) = (broker.user(), broker.address());
    format!("amqp://{user}@{address}/{}", vhost.name())
}

/// The output for these input lines: standard output, standard error.
fn talk(broker: &SharedBroker, url: &str, lines: &str) -> (String, String) {
    let mut shell = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    shell.args(["shell", "--bus", url]);
    shell.env("ASMOTION_PASSWORD", broker.password());
    let output = shell.write_stdin(lines).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr))
}

#[test]
fn o14_operations_properties_ports_and_the_life_cycle_from_the_shell() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let url = url(&broker, &vhost);
    let _arm = arm(&broker, &vhost);
    crate::processes::queues(&vhost, "robots.services.youbot.control.robot");

    let (out, err) = talk(
        &broker,
        &url,
        "ls\ncd Driver/SCAyouBotDriver\ngetJointsPositions()\nretrievingStatus.getJointsPositions {}\npeers\n",
    );
    assert!(out.contains("Driver/youBotDriver"), "{out}{err}");
    assert_eq!(out.matches("\"position\"").count(), 2, "{out}{err}");
    let peer = out
        .lines()
        .find(|line| line.contains("commands → commands"));
    assert!(
        peer.is_some_and(|it| it.starts_with("Driver/youBotDriver")),
        "{out}{err}"
    );
    assert!(
        out.contains("notifying → notifying"),
        "the other process is a peer too: {out}"
    );
    assert_eq!(err.matches("error").count(), 0, "{err}");

    let (out, err) = talk(
        &broker,
        &url,
        "cd Driver/youBotDriver\nls\nread jointStatus\nwatch jointStatus 2\nget joints\nset seed = 7\nget seed\n\
         stop\nls\nstart\ncd ..\nget Driver/youBotDriver.seed\nstart Driver/youBotDriver\n\
         set Driver/youBotDriver.seed = many\nDriver/youBotDriver.fly()\nwrite Driver/youBotDriver.commands up\n\
         write Driver/youBotDriver.commands \"up\"\nstar\nread Driver/youBotDrive.jointStatus\nhelp\nquit\nls\n",
    );
    assert_eq!(out.matches("\"current\"").count(), 3, "{out}{err}");
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines.contains(&"5") && lines.contains(&"7"), "{out}{err}");
    assert_eq!(
        lines.iter().filter(|line| **line == "7").count(),
        2,
        "{out}"
    );
    assert!(
        out.contains("Running in process") && out.contains("Stopped in process"),
        "{out}"
    );
    assert!(
        out.contains("sets a property from the next cycle on"),
        "{out}"
    );
    let errors: Vec<&str> = err
        .lines()
        .filter(|line| line.starts_with("error"))
        .collect();
    let outputs = [
        "it is Running",
        "`seed`",
        "nor an operation",
        "is not JSON",
        "takes youbot/JointCommand",
        "did you mean `start`?",
        "did you mean `Driver/youBotDriver`?",
    ];
    assert_eq!(errors.len(), outputs.len(), "{err}");
    for (error, told) in errors.iter().zip(outputs) {
        assert!(error.contains(told), "{told}: {error}");
    }
}

#[test]
fn o14_an_operation_of_a_nested_component_is_called_by_its_path() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let url = url(&broker, &vhost);
    let _arm = arm(&broker, &vhost);
    crate::processes::queues(&vhost, "robots.services.youbot.control.robot");
    let call = |operation: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.args(["call", operation, "--bus", &url]);
        let output = command.env("ASMOTION_PASSWORD", broker.password()).output();
        let output = output.unwrap();
        let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        (output.status.code(), said)
    };
    let address = "youbot.Driver/SCAyouBotDriver.retrievingStatus.getJointsPositions";
    for operation in [
        address,
        "Driver/SCAyouBotDriver.retrievingStatus.getJointsPositions",
        "Driver/SCAyouBotDriver.getJointsPositions",
        "youbot.Driver/SCAyouBotDriver.getJointsPositions",
        "Driver.SCAyouBotDriver.getJointsPositions",
        "youbot.Driver.SCAyouBotDriver.retrievingStatus.getJointsPositions",
    ] {
        let (code, said) = call(operation);
        assert_eq!(code, Some(0), "{operation}: {said}");
        assert!(said.contains("\"position\""), "{operation}: {said}");
    }
    // a level too few, at the beginning, at the end or in the middle
    for operation in [
        "SCAyouBotDriver.getJointsPositions",
        "Driver.getJointsPositions",
        "Driver.retrievingStatus.getJointsPositions",
        "Driver/retrievingStatus.getJointsPositions",
    ] {
        let suggestion = format!("unknown operation `{operation}`; did you mean `{address}`?");
        // on a busy machine the process may not be known in time; then there is nothing to suggest, or no such interface
        let mut outputs = Vec::new();
        let found = (0..10).any(|_| {
            let (code, said) = call(operation);
            let is_suggested = code == Some(1) && said.contains(&suggestion);
            outputs.push((code, said));
            is_suggested
        });
        assert!(found, "{operation}: {outputs:?}");
    }
    // an interface that does not exist is no path
    let (code, said) = call("nav/PlanServic.plan");
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("unknown interface `nav/PlanServic`"),
        "{said}"
    );
    // without a broker
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let command = command.args(["call", address]).env_remove("ASMOTION_BUS");
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("--bus"), "{said}");
}

/// In a real terminal: Tab completes names, and the arrow key recalls a line.
#[test]
fn o14_the_shell_completes_and_remembers() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let url = url(&broker, &vhost);
    let _arm = arm(&broker, &vhost);
    crate::processes::queues(&vhost, "robots.services.youbot.control.robot");
    let seen = person(
        (broker.password(), &url),
        &["shell"],
        &[
            ("> ", "cd Driver/SCA\t\r"),
            ("SCAyouBotDriver> ", "retrievingStatus.g\t()\r"),
            // keys pressed before the prompt are not the shell's
            ("\"position\"", ""),
            ("SCAyouBotDriver> ", "\u{1b}[A\r"),
            ("\"position\"", ""),
            ("SCAyouBotDriver> ", "\u{4}"),
        ],
    );
    let Some((code, screen)) = seen else { return };
    assert_eq!(code, Some(0), "{screen}");
    assert!(screen.contains("getJointsPositions"), "{screen}");
}

#[test]
fn the_shell_wants_a_broker() {
    let mut shell = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = shell
        .arg("shell")
        .env_remove("ASMOTION_BUS")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("no broker selected"), "{said}");
}
