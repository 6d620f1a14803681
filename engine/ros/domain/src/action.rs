//! The types of services and actions, as a peer needs them.

use asmotion_datum::{Codec, Datum, Schema};
use asmotion_ros_interface::InterfaceName;
use serde_json::{Value, json};

use crate::peer::{catalogue, hex};

fn named(name: &str) -> InterfaceName {
    name.parse().expect("the name of an interface")
}

fn message(name: &str) -> Value {
    json!(catalogue().schema(&named(name)).unwrap())
}

fn kind(schema: &Value, type_name: String) -> Value {
    json!({ "schema": schema, "type": type_name })
}

/// The schema and the name in DDS of the request and the response of a service, such as `std_srvs/srv/SetBool`.
pub fn service_kinds(of: &str) -> [Value; 2] {
    let name = named(of);
    let schemas = catalogue().schemas(&name).unwrap();
    let [request, response] = <[Schema; 2]>::try_from(schemas).expect("a service");
    let type_name = |part| {
        let (package, name) = (name.package(), name.name());
        format!("{package}::srv::dds_::{name}_{part}_")
    };
    [
        kind(&json!(request), type_name("Request")),
        kind(&json!(response), type_name("Response")),
    ]
}

/// The types of the services and topics of an action, such as `nav2_msgs/action/Spin`, and an empty result in CDR.
pub fn action_kinds(of: &str) -> (Value, String) {
    let name = named(of);
    let schemas = catalogue().schemas(&name).unwrap();
    let [goal, result, feedback] = <[Schema; 3]>::try_from(schemas).expect("an action");
    let empty = result.complete(Datum::Record(Vec::new())).unwrap();
    let empty = hex(&Codec::Cdr.encode(&empty, &result).unwrap());
    let [id, time] = [
        "unique_identifier_msgs/msg/UUID",
        "builtin_interfaces/msg/Time",
    ]
    .map(message);
    let record = |fields: &[(&str, &Value)]| {
        let fields = fields.iter();
        let fields =
            fields.map(|(name, schema)| json!({"name": name, "doc": "", "schema": schema}));
        json!({"name": "", "shape": {"record": fields.collect::<Vec<_>>()}})
    };
    let plain = |shape: &str| json!({"name": "", "shape": shape});
    let of = |schema: Value, part: &str| {
        let (package, name) = (name.package(), name.name());
        kind(&schema, format!("{package}::action::dds_::{name}_{part}_"))
    };
    let [cancel, cancelled] = service_kinds("action_msgs/srv/CancelGoal");
    let status = message("action_msgs/msg/GoalStatusArray");
    let kinds = json!({
        "goal": of(record(&[("goal_id", &id), ("goal", &json!(goal))]), "SendGoal_Request"),
        "accepted": of(record(&[("accepted", &plain("bool")), ("stamp", &time)]), "SendGoal_Response"),
        "ask": of(record(&[("goal_id", &id)]), "GetResult_Request"),
        "result": of(record(&[("status", &plain("i8")), ("result", &json!(result))]), "GetResult_Response"),
        "cancel": cancel,
        "cancelled": cancelled,
        "feedback": of(record(&[("goal_id", &id), ("feedback", &json!(feedback))]), "FeedbackMessage"),
        "status": kind(&status, "action_msgs::msg::dds_::GoalStatusArray_".to_owned()),
    });
    (kinds, empty)
}
