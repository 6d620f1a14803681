//! The types of an action as DDS sees them, equal for clients and servers.

use asmotion_datum::{OutlineKey, Schema, Shape};
use asmotion_ros_interface::{InterfaceKind, InterfaceName};

use super::MOST_EVENTS;
use crate::error::EndpointError;
use crate::names;
use crate::participant::Inner;
use crate::qos::Qos;
use crate::service::{Part, ServiceType};

/// The services and topics of an action.
pub(super) struct ActionKinds {
    pub send_goal: ServiceType,
    pub cancel_goal: ServiceType,
    pub get_result: ServiceType,
    pub feedback: Part,
    pub status: Part,
    pub status_hash: Option<String>,
    /// The result alone.
    pub result: Schema,
}

impl ActionKinds {
    /// An action that is defined.
    pub(super) fn of(inner: &Inner, of: &InterfaceName) -> Result<Self, EndpointError> {
        inner.check_kind(of, InterfaceKind::Action, "action")?;
        let catalogue = inner.catalogue();
        let message = InterfaceKind::Message;
        let id = catalogue.schema(&known("unique_identifier_msgs", message, "UUID")?)?;
        let time = catalogue.schema(&known("builtin_interfaces", message, "Time")?)?;
        let schemas = <[Schema; 3]>::try_from(catalogue.schemas(of)?);
        let Ok([goal, result, feedback]) = schemas else {
            let (of, needed) = (of.clone(), "action");
            return Err(EndpointError::Kind { of, needed });
        };
        for schema in [&goal, &result, &feedback] {
            inner.carried(of, schema)?;
        }
        let part = |part: &str, schema| Part {
            schema,
            type_name: names::part_type(of, part),
        };
        let service = |name: &str, request, response| ServiceType {
            request: part(&format!("{name}_Request"), record(request)),
            response: part(&format!("{name}_Response"), record(response)),
            hash: None,
        };
        let (flag, number) = (Schema::plain(Shape::Bool), Schema::plain(Shape::I8));
        let status = known("action_msgs", message, "GoalStatusArray")?;
        let cancel = known("action_msgs", InterfaceKind::Service, "CancelGoal")?;
        Ok(Self {
            send_goal: service(
                "SendGoal",
                vec![("goal_id", id.clone()), ("goal", goal)],
                vec![("accepted", flag), ("stamp", time)],
            ),
            cancel_goal: ServiceType::of(inner, &cancel)?,
            get_result: service(
                "GetResult",
                vec![("goal_id", id.clone())],
                vec![("status", number), ("result", result.clone())],
            ),
            feedback: part(
                "FeedbackMessage",
                record(vec![("goal_id", id), ("feedback", feedback)]),
            ),
            status: Part {
                schema: catalogue.schema(&status)?,
                type_name: names::message_type(&status),
            },
            status_hash: inner.hash(&status),
            result,
        })
    }
}

/// The quality of service of feedback.
pub(super) fn feedback_qos() -> Qos {
    Qos::default().depth(MOST_EVENTS)
}

fn known(package: &str, kind: InterfaceKind, name: &str) -> Result<InterfaceName, EndpointError> {
    let made = InterfaceName::new(package, kind, name);
    made.map_err(|error| EndpointError::Dds {
        topic: name.to_owned(),
        reason: error.to_string(),
    })
}

fn record(fields: Vec<(&'static str, Schema)>) -> Schema {
    let fields = fields.into_iter();
    let keys = fields.map(|(name, schema)| OutlineKey::new(name, "", schema));
    Schema::plain(Shape::Record(keys.collect()))
}
