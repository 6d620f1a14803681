//! `asmotion describe`: tables for users, AsyncAPI documents for tools.

use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn describe(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = command.arg("describe").args(arguments).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

fn asyncapi(composite: &str) -> Value {
    serde_json::from_str(&describe(&[composite, "--asyncapi"])).unwrap()
}

/// The navigation composite with additional text, in a separate file.
fn navigation_with(more: &str) -> (tempfile::TempDir, String) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let specs = root.join("specs/navigation");
    for entry in std::fs::read_dir(&specs).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    let composite = folder.path().join("navigation.composite.toml");
    let mut file = std::fs::OpenOptions::new();
    let mut file = file.append(true).open(&composite).unwrap();
    file.write_all(more.as_bytes()).unwrap();
    (folder, composite.to_str().unwrap().to_owned())
}

/// All `$ref`s in a document.
fn references<'v>(value: &'v Value, found: &mut Vec<&'v str>) {
    match value {
        Value::Object(members) => {
            found.extend(members.get("$ref").and_then(Value::as_str));
            members.values().for_each(|it| references(it, found));
        }
        Value::Array(elements) => elements.iter().for_each(|it| references(it, found)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// Checks the requirements of AsyncAPI 3.0.0.
fn check(document: &Value) {
    assert_eq!(document["asyncapi"], "3.0.0");
    assert!(document["info"]["title"].is_string() && document["info"]["version"].is_string());
    let mut found = Vec::new();
    references(document, &mut found);
    assert!(!found.is_empty());
    for reference in found {
        let pointer = reference.strip_prefix('#').unwrap();
        assert!(document.pointer(pointer).is_some(), "{reference}");
    }
    for (name, channel) in document["channels"].as_object().unwrap() {
        let binding = &channel["bindings"]["amqp"];
        assert_eq!(binding["is"], "routingKey", "{name}");
        assert!(binding["exchange"]["name"].is_string(), "{name}");
        assert_ne!(
            channel["address"].as_str().map(|it| it.ends_with(".bus")),
            Some(true)
        );
        assert_eq!(binding["bindingVersion"], "0.3.0", "{name}");
    }
    for (name, operation) in document["operations"].as_object().unwrap() {
        let action = operation["action"].as_str();
        assert!(matches!(action, Some("send" | "receive")), "{name}");
        let channel = operation["channel"]["$ref"].as_str().unwrap();
        for message in operation["messages"].as_array().unwrap() {
            let of_channel = format!("{channel}/messages/");
            assert!(
                message["$ref"].as_str().unwrap().starts_with(&of_channel),
                "{name}"
            );
        }
    }
    let keys =
        ["messages", "schemas"].map(|kind| document["components"][kind].as_object().unwrap());
    for key in keys.into_iter().flat_map(|members| members.keys()) {
        let is_valid = |it: char| it.is_ascii_alphanumeric() || "._-".contains(it);
        assert!(key.chars().all(is_valid), "{key}");
    }
}

#[test]
fn exchanges_are_those_of_the_brokers_and_promoted_services_have_their_names() {
    let (_folder, composite) = navigation_with(
        "[brokers.main]
        url = \"amqp://localhost\"
        exchange = \"fleet\"
        [[promote]]
        service = \"TrajectoryPlanner.planning\"
        as = \"plans\"
        binding = \"amqp\"
        ",
    );
    let document = asyncapi(&composite);
    check(&document);
    let exchange = |channel: &str| {
        document["channels"][channel]["bindings"]["amqp"]["exchange"]["name"].clone()
    };
    assert_eq!(exchange("goal"), "fleet");
    assert_eq!(
        exchange("TrajectoryPlanner.planning.plan"),
        "fleet.services"
    );
    assert_eq!(exchange("plans.plan"), "fleet.services");
    assert_eq!(
        document["channels"]["plans.plan"]["address"],
        "navigation.plans.plan"
    );
    assert_eq!(document["operations"]["plans.plan"]["action"], "receive");
}

#[test]
fn documents_are_whole() {
    for folder in ["navigation", "courier"] {
        check(&asyncapi(&format!(
            "specs/{folder}/{folder}.composite.toml"
        )));
    }
}

/// A folder with the published schema of AsyncAPI and a validator, installed once. Prints a notice and returns `None`
/// if the packages cannot be downloaded.
fn published() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("asyncapi");
    if folder.join("node_modules/ajv").is_dir() {
        return Some(folder);
    }
    std::fs::create_dir_all(&folder).ok()?;
    let mut npm = Command::new("npm");
    npm.args(["install", "--silent", "--no-audit", "--no-fund", "--prefix"]);
    npm.arg(&folder).args(["@asyncapi/specs@6", "ajv@8"]);
    let installed = npm.stdin(Stdio::null()).output();
    let installed = installed.is_ok_and(|it| it.status.success());
    if !installed {
        let notice = "    Skipped: without npm and its index, documents are not held against AsyncAPI's schema";
        let _ = writeln!(std::io::stderr(), "{notice}");
    }
    installed.then_some(folder)
}

#[test]
fn documents_are_as_the_published_schema_wants_them() {
    let Some(folder) = published() else { return };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/asyncapi/validate.js");
    let valid = |document: &str| {
        let mut node = Command::new("node");
        node.arg(&script).current_dir(&folder);
        node.stdin(Stdio::piped()).stderr(Stdio::piped());
        let mut node = node.spawn().unwrap();
        let mut stdin = node.stdin.take().unwrap();
        stdin.write_all(document.as_bytes()).unwrap();
        drop(stdin);
        let output = node.wait_with_output().unwrap();
        (
            output.status.success(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    for folder in ["navigation", "courier", "youbot"] {
        let composite = format!("specs/{folder}/{folder}.composite.toml");
        let document = describe(&[&composite, "--asyncapi"]);
        let (is_valid, said) = valid(&document);
        assert!(is_valid, "{composite}: {said}");
        let wrong = document.replace("\"send\"", "\"shout\"");
        assert!(!valid(&wrong).0, "{composite}: a wrong document is valid");
    }
}

#[test]
fn services_of_a_specification_are_described() {
    let document = describe(&["specs/courier/courier.composite.toml", "--asyncapi"]);
    insta::assert_snapshot!("describe_courier_asyncapi", document);
}

#[test]
fn topics_and_services_are_shown_in_tables() {
    let tables = describe(&["specs/navigation/navigation.composite.toml"]);
    insta::assert_snapshot!("describe_navigation", tables);
}

const COUNTER: &str = "asm counter
import StandardLibrary
signature:
	monitored amount: Integer
	controlled total: Integer
definitions:
	main rule r_Main = if isDef(amount) then total := amount endif
";

/// Nothing but the specification knows the type of `add`; that of a part of a request is not known.
const COUNTED: &str = r#"
schema = "composite/1"
[composite]
name = "counted"
[components.Counter]
implementation = { asm = "counter.asm" }
task = { period_ms = 50 }
services = { counting = "test/Counting" }
bind.monitored.amount = { service = "counting.add" }
"#;

/// The words of the row of an operation, without its callers.
fn row<'t>(tables: &'t str, operation: &str) -> Vec<&'t str> {
    let mut rows = tables.lines().map(str::split_whitespace);
    let row = rows.find(|words| words.clone().next() == Some(operation));
    let row = row.unwrap_or_else(|| panic!("{operation}: {tables}"));
    row.skip(1).take(2).collect()
}

#[test]
fn operations_of_a_specification_have_the_types_of_their_interface_or_domains() {
    let tables = describe(&["specs/youbot/youbot.composite.toml"]);
    let of = |operation| row(&tables, operation);
    let move_to = ["geometry_msgs/Pose", "std_msgs/Empty"];
    assert_eq!(of("Locomotor.move.moveTo"), move_to, "{tables}");
    let notify = of("Operator.notifying.notify");
    assert_eq!(of("Locomotor.notifying.notify"), notify, "{tables}");

    // an operation without a reply has a dash
    let tables = describe(&["specs/courier/courier.composite.toml"]);
    assert_eq!(row(&tables, "Dispatcher.dispatch.job"), ["int64", "int64"]);
    assert_eq!(row(&tables, "Dispatcher.dispatch.done"), ["int64", "-"]);

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("counter.asm"), COUNTER).unwrap();
    let path = folder.path().join("counted.composite.toml");
    for (source, request) in [
        ("counting.add", "int64"),
        ("counting.add\", field = \"n", "-"),
    ] {
        std::fs::write(&path, COUNTED.replace("counting.add", source)).unwrap();
        let tables = describe(&[path.to_str().unwrap()]);
        let found = row(&tables, "Counter.counting.add");
        assert_eq!(found, [request, "-"], "{source}: {tables}");
    }
}

#[test]
fn a_message_has_its_schema_and_a_topic_its_key() {
    let composite = "specs/navigation/navigation.composite.toml";
    let document: Value =
        serde_json::from_str(&describe(&[composite, "--asyncapi", "--robot", "rover1"])).unwrap();
    assert_eq!(document["channels"]["odom"]["address"], "rover1.odom");
    let schemas = &document["components"]["schemas"];
    let grid = &schemas["nav_msgs.OccupancyGrid"]["properties"];
    assert_eq!(grid["data"]["items"]["minimum"], -128);
    let reply = &document["operations"]["TrajectoryPlanner.planning.plan"]["reply"];
    let replies = "#/channels/TrajectoryPlanner.planning.plan.reply";
    assert_eq!(reply["channel"]["$ref"], replies);
    assert_eq!(
        reply["messages"][0]["$ref"],
        format!("{replies}/messages/result.nav_msgs.Path")
    );
}

const DESK: &str = r#"
schema = "composite/1"
[composite]
name = "desk"
[brokers.main]
url = "amqp://guest:guest@127.0.0.1:5672/%2f"
[components.Operator]
implementation = { rust = "nav::Operator" }
task = { broker = "main" }
"#;

#[test]
fn brokers_are_servers_without_who_goes_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("desk.composite.toml");
    std::fs::write(&path, DESK).unwrap();
    let document = asyncapi(path.to_str().unwrap());
    check(&document);
    let expected = serde_json::json!({ "main": {
        "host": "127.0.0.1:5672", "pathname": "/%2f", "protocol": "amqp", "protocolVersion": "0.9.1",
    } });
    assert_eq!(document["servers"], expected);
    assert!(!document.to_string().contains("guest"));
}

#[test]
fn an_operation_without_answer_has_no_reply_and_payloads_are_those_of_the_module() {
    let document = asyncapi("specs/courier/courier.composite.toml");
    let operation = |name: &str| &document["operations"][format!("Dispatcher.dispatch.{name}")];
    assert!(operation("done").get("reply").is_none() && operation("job").get("reply").is_some());
    assert!(
        document["channels"]
            .get("Dispatcher.dispatch.done.reply")
            .is_none()
    );
    let message = &document["components"]["messages"]["result.int64"];
    assert_eq!(message["payload"]["type"], "integer");
    assert_eq!(
        document["channels"]["presence"]["address"],
        "courier.presence.{process}"
    );
}

#[test]
fn a_document_in_yaml_says_the_same() {
    let arguments = [
        "specs/courier/courier.composite.toml",
        "--asyncapi",
        "--format",
        "yaml",
    ];
    let document = describe(&arguments);
    assert!(
        document.starts_with("\"asyncapi\": \"3.0.0\"\n"),
        "{document}"
    );
    assert!(
        document.contains("\n  \"Dispatcher.dispatch.job\":\n    \"action\": \"receive\"\n"),
        "{document}"
    );
}
