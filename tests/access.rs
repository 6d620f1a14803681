//! Access to a broker: passwords from the environment and from a file, certificates on both sides; secrets are never
//! printed.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use asmotion_broker::{TestBroker, Vhost};

/// An `asmotion` command without a password in its environment.
fn asmotion(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(arguments).env_remove("ASMOTION_PASSWORD");
    command.env_remove("ASMOTION_BUS");
    command
}

/// A short mission that writes a trace.
fn mission(bus: &str, trace: &Path) -> Command {
    let composite =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation/navigation.composite.toml");
    let mut command = asmotion(&["run", "--goal", "3.4,4.7", "--for", "120", "--bus", bus]);
    command.arg(composite).arg("--trace").arg(trace);
    command
}

/// Creates a user with its own password and all permissions.
fn user(broker: &TestBroker, vhost: &Vhost<'_>) -> (String, &'static str) {
    let (user, password) = (format!("{}-ann", vhost.name()), "correct-horse-battery");
    broker.add_user(&user, password).unwrap();
    vhost.permit(&user, ".*", ".*", ".*").unwrap();
    (user, password)
}

fn text(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

fn credentials(folder: &Path, text: &str) -> PathBuf {
    let file = folder.join("credentials");
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_process_without_a_broker_says_that_the_variable_is_not_read() {
    let composite = "specs/navigation/navigation.composite.toml";
    let run = |address: Option<&str>| {
        let mut command = asmotion(&["run", composite, "--process", "onboard"]);
        command.current_dir(env!("CARGO_MANIFEST_DIR"));
        let output = command.envs(address.map(|it| ("ASMOTION_BUS", it)));
        let output = output.output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        text(&output)
    };
    let said = run(None);
    assert!(
        said.contains("add `--bus amqp://user@host:port/vhost`, or"),
        "{said}"
    );
    let said = run(Some("amqp://rover:secret@desk:5672/cell"));
    assert!(
        said.contains(
            "add `--bus $ASMOTION_BUS`, which only the commands on a running system read"
        ) && !said.contains("secret"),
        "{said}"
    );
}

#[test]
fn a_password_from_the_environment_or_a_file_lets_in_and_is_told_nowhere() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, password) = user(&broker, &vhost);
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("trace");
    let bus = format!("amqp://{user}@{}/{}", broker.address(), vhost.name());

    let from_environment = mission(&bus, &trace)
        .env("ASMOTION_PASSWORD", password)
        .output();
    let file = credentials(folder.path(), &format!("{user}\n{password}\n"));
    let mut list = asmotion(&["topic", "list", "--bus", &bus, "--credentials"]);
    let from_file = list.arg(&file).output();
    let mut printed = String::new();
    for output in [from_environment.unwrap(), from_file.unwrap()] {
        printed += &text(&output);
        assert!(output.status.success(), "{printed}");
    }

    let without = asmotion(&["topic", "list", "--bus", &bus])
        .output()
        .unwrap();
    assert_eq!(without.status.code(), Some(2));
    let refusal = text(&without);
    assert!(
        refusal.contains("set ASMOTION_PASSWORD, or name a file with `--credentials`"),
        "{refusal}"
    );
    let wrong_password = "wrong-horse-battery";
    let mut wrong = mission(&bus, &trace);
    let wrong = wrong
        .env("ASMOTION_PASSWORD", wrong_password)
        .output()
        .unwrap();
    assert_eq!(wrong.status.code(), Some(2));
    printed += &text(&wrong);
    let half = credentials(folder.path(), wrong_password);
    let mut list = asmotion(&["topic", "list", "--bus", &bus, "--credentials"]);
    let half = list.arg(&half).output().unwrap();
    assert_eq!(half.status.code(), Some(2), "{}", text(&half));
    printed += &text(&half);

    let recorded = std::fs::read_to_string(&trace).unwrap();
    assert!(recorded.contains("publish RoverDriver.odom"));
    for secret in [password, wrong_password] {
        assert!(!printed.contains(secret), "{printed}");
        assert!(!recorded.contains(secret));
    }
}

#[test]
fn certificates_on_both_sides_let_in_where_they_fit() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("trace");
    let (port, user) = (broker.encrypted_port(), broker.user());
    let bus = format!("amqps://{user}@localhost:{port}/{}", vhost.name());
    let (certificate, key) = broker.client_identity();
    let known = |mut command: Command, ours: bool| {
        command.env("ASMOTION_PASSWORD", broker.password());
        command.arg("--ca").arg(broker.authority());
        if ours {
            command.arg("--certificate").arg(&certificate);
            command.arg("--key").arg(&key);
        }
        command.output().unwrap()
    };
    let list = || asmotion(&["topic", "list", "--bus", &bus]);
    for output in [known(mission(&bus, &trace), true), known(list(), true)] {
        assert!(output.status.success(), "{}", text(&output));
    }
    let nobody = known(list(), false);
    assert_eq!(nobody.status.code(), Some(2), "{}", text(&nobody));
    let mut other_list = list();
    let other_list = other_list
        .env("ASMOTION_PASSWORD", broker.password())
        .output();
    let other_list = other_list.unwrap();
    assert_eq!(other_list.status.code(), Some(2));
    assert!(
        text(&other_list).contains("UnknownIssuer"),
        "{}",
        text(&other_list)
    );
    let mut half = list();
    let half = half
        .arg("--certificate")
        .arg(&certificate)
        .output()
        .unwrap();
    assert_eq!(half.status.code(), Some(2));
    assert!(text(&half).contains("--key <FILE>"), "{}", text(&half));
}
