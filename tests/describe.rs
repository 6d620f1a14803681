//! `asmotion describe`: tables for people, AsyncAPI for their tools.

use serde_json::Value;
use std::process::Command;

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

/// Every `$ref` in a document.
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

/// What AsyncAPI 3.0.0 asks of every document.
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
        let lawful = |it: char| it.is_ascii_alphanumeric() || "._-".contains(it);
        assert!(key.chars().all(lawful), "{key}");
    }
}

#[test]
fn documents_are_whole() {
    for folder in ["navigation", "courier"] {
        check(&asyncapi(&format!(
            "specs/{folder}/{folder}.composite.toml"
        )));
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
