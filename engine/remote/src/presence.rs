//! Presence: the description that a process publishes of itself for tools and other programs, as specified in
//! `docs/wire.md`.

use std::time::Duration;

use asmotion_bus::Envelope;
use asmotion_component::{Losses, State, ThreadUse};
use asmotion_datum::Datum;
use asmotion_plan::{End, Part, Plan};
use asmotion_runtime::Run;
use serde::{Deserialize, Serialize};

/// Type name of the message.
pub const PRESENCE: &str = "asmotion/Presence";

/// The topic of a process' presence, for example `presence.onboard`.
pub fn presence_topic(process: &str) -> String {
    format!("presence.{process}")
}

/// The presence of a process, and the robot it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotPresence {
    /// Name of the robot, which is the prefix of its topics; empty if it has none.
    pub robot: String,
    /// The published description.
    pub presence: Presence,
}

impl RobotPresence {
    /// Reads a message; `None` if it is not a presence.
    pub fn of(envelope: &Envelope) -> Option<Self> {
        let presence = envelope.payload.to_datum().ok()?.to::<Presence>().ok()?;
        let topic = presence_topic(&presence.process);
        let robot = envelope.topic.strip_suffix(&topic)?;
        Some(Self {
            robot: robot.trim_end_matches('.').to_owned(),
            presence,
        })
    }

    /// The routing key of a topic or address of this robot.
    pub fn key(&self, name: &str) -> String {
        key(&self.robot, name)
    }
}

/// An operation of a running process, under one of its names.
pub(crate) struct PresentOperationName {
    /// `Component.service.operation`, or `name.operation` of a promoted service.
    pub name: String,
    /// Name of the component that provides it.
    pub component: String,
    /// Whether the service is promoted under this name.
    pub is_promoted: bool,
}

/// The operations of a process: under their own names, and those of promoted services.
pub(crate) fn operations(process: &RobotPresence) -> Vec<PresentOperationName> {
    let mut found = Vec::new();
    for component in &process.presence.components {
        for service in &component.services {
            let own = format!("{}.{}", component.name, service.name);
            let promoted = process.presence.promoted.iter().filter(|it| it.to == own);
            let names = promoted.map(|it| (it.from.clone(), true));
            for (path, is_promoted) in std::iter::once((own.clone(), false)).chain(names) {
                found.extend(service.operations.iter().map(|it| PresentOperationName {
                    name: format!("{path}.{}", it.name),
                    component: component.name.clone(),
                    is_promoted,
                }));
            }
        }
    }
    found
}

/// The routing key of a topic or address of a robot.
pub fn key(robot: &str, name: &str) -> String {
    match robot {
        "" => name.to_owned(),
        robot => format!("{robot}.{name}"),
    }
}

/// The description that a process publishes of itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Presence {
    /// Name of the composite.
    pub composite: String,
    /// Name of the process.
    pub process: String,
    /// `true` in the last message, when the process leaves.
    pub leaves: bool,
    /// Number of versions that the process has changed to while it runs.
    #[serde(skip_serializing_if = "is_zero")]
    pub version: u64,
    /// Components of the process, in the order of the composite.
    pub components: Vec<PresentComponent>,
    /// Topics of these components.
    pub topics: Vec<PresentTopic>,
    /// Connections and wires of these components, including those to other processes.
    pub joined: Vec<PresentConnection>,
    /// Services of these components that are promoted over AMQP: the public name and the `Component.service`.
    pub promoted: Vec<PresentConnection>,
}

/// A connection from an output to an input, a wire from a reference to a service, or the name of a promoted service.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentConnection {
    /// The output, `Component.port`, the reference, `Component.reference`, or the public name.
    pub from: String,
    /// The input, `Component.port`, or the service, `Component.service`.
    pub to: String,
}

/// The description of a component.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentComponent {
    /// Name within the robot.
    pub name: String,
    /// `id` of its `task`, by which tools can name it, too; the name by default.
    pub id: String,
    /// State in the life cycle, for example `Running`.
    pub state: String,
    /// Period in milliseconds; 0 without a period.
    pub period_ms: u64,
    /// Its thread in real time: `own` or `shared`; empty in virtual time and from older programs.
    pub thread: String,
    /// Number of cycles begun.
    pub cycles: u64,
    /// Cycles per second since the previous message.
    pub rate_hz: f64,
    /// Number of missed periods.
    pub overruns: u64,
    /// Number of cycles that exceeded their deadline.
    pub late: u64,
    /// Mean duration of a cycle in milliseconds.
    pub cycle_mean_ms: f64,
    /// Duration of the longest cycle in milliseconds.
    pub cycle_max_ms: f64,
    /// Number of messages lost on the way to the component or dropped by it, and of requests refused because a queue was full.
    pub dropped: u64,
    /// Number of messages ignored because their content was unsuitable.
    pub misfits: u64,
    /// Number of messages that the component has taken and keeps for a later cycle, as a coordinator does for a later step; omitted
    /// if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub waiting: u64,
    /// Input ports, in order of declaration.
    pub inputs: Vec<PresentEndpoint>,
    /// Output ports, in order of declaration.
    pub outputs: Vec<PresentEndpoint>,
    /// Provided services, in order of declaration.
    pub services: Vec<PresentService>,
    /// Required references, in order of declaration.
    pub references: Vec<PresentEndpoint>,
    /// Properties with their current values.
    pub properties: Vec<(String, Datum)>,
    /// Internal state, as the component describes it; empty for most components.
    pub inspection: Vec<(String, Datum)>,
}

/// A port and its message type, or a reference and its interface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentEndpoint {
    /// Name within the component.
    pub name: String,
    /// Name of the message type or interface.
    #[serde(rename = "type")]
    pub kind: String,
    /// Number of messages lost on the way to an input; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub lost: u64,
    /// Number of messages that wait in the queues of an input; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub waiting: u64,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes fields by reference"
)]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// A service. Its operations have addresses of the form `Component.service.operation`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentService {
    /// Name within the component.
    pub name: String,
    /// Name of the interface.
    pub interface: String,
    /// The operations that it provides.
    pub operations: Vec<PresentOperation>,
    /// Number of requests refused because its queue was full; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub refused: u64,
    /// Number of requests that wait; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub waiting: u64,
}

/// An operation of a service.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentOperation {
    /// Name within the interface.
    pub name: String,
    /// Name of the request type.
    pub request: String,
    /// Name of the response type.
    pub response: String,
    /// Whether it is also answered while the component is stopped.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub while_stopped: bool,
}

/// A topic, with the ends in this process.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentTopic {
    /// Name without the robot's prefix.
    pub name: String,
    /// Name of the message type; `None` if it is unknown.
    #[serde(rename = "type")]
    pub kind: Option<String>,
    /// The outputs that publish on it, as `Component.port`.
    pub publishers: Vec<String>,
    /// The inputs that subscribe to it, as `Component.port`.
    pub subscribers: Vec<String>,
}

impl Presence {
    /// Describes a running part of a plan.
    pub fn of(plan: &Plan, part: &Part, process: &str, run: &mut dyn Run) -> Self {
        let names = run.components();
        Self {
            composite: plan.name.clone(),
            process: process.to_owned(),
            leaves: false,
            version: 0,
            components: names
                .iter()
                .map(|name| PresentComponent {
                    id: plan
                        .component(name)
                        .map_or_else(|| name.clone(), |it| it.id.clone()),
                    ..PresentComponent::of(name, run)
                })
                .collect(),
            topics: topics(plan, part),
            joined: joined(plan, part),
            promoted: promoted(plan, part),
        }
    }

    /// Fills in the rates from the previous message, `seconds` before on the clock of the run, or repeats its rates if no time has
    /// passed. Repeats its properties and internal state for components that were too busy to report them.
    #[must_use]
    pub fn after(mut self, before: &Self, seconds: f64) -> Self {
        for component in &mut self.components {
            let mut known = before.components.iter();
            let known = known.find(|known| known.name == component.name);
            let Some(known) = known else { continue };
            if component.properties.is_empty() {
                component.properties.clone_from(&known.properties);
            }
            if component.inspection.is_empty() {
                component.inspection.clone_from(&known.inspection);
            }
            component.rate_hz = if seconds > 0.0 {
                component.cycles.saturating_sub(known.cycles) as f64 / seconds
            } else {
                known.rate_hz
            };
        }
        self
    }
}

fn joined(plan: &Plan, part: &Part) -> Vec<PresentConnection> {
    let routes = plan.connection_routes().into_iter();
    let in_part = routes.filter(|route| route.ends().any(|end| part.has(&end.component)));
    let joined = in_part.map(|route| PresentConnection {
        from: route.from.to_string(),
        to: route.to.to_string(),
    });
    joined.collect()
}

fn promoted(plan: &Plan, part: &Part) -> Vec<PresentConnection> {
    let promoted = plan.services_over_brokers(part);
    let promoted = promoted.map(|it| PresentConnection {
        from: it.name.clone(),
        to: it.inside.clone(),
    });
    promoted.collect()
}

fn topics(plan: &Plan, part: &Part) -> Vec<PresentTopic> {
    let in_part = |ends: &[End]| -> Vec<String> {
        let here = ends.iter().filter(|end| part.has(&end.component));
        here.map(End::to_string).collect()
    };
    let topic = |topic: &asmotion_plan::Topic| PresentTopic {
        name: topic.name.clone(),
        kind: topic.kind.clone(),
        publishers: in_part(&topic.publishers),
        subscribers: in_part(&topic.subscribers),
    };
    let topics = plan.topics.iter().map(topic);
    topics
        .filter(|topic| !topic.publishers.is_empty() || !topic.subscribers.is_empty())
        .collect()
}

impl PresentComponent {
    /// Describes a component.
    pub(crate) fn of(name: &str, run: &mut dyn Run) -> Self {
        let declared = run.declaration(name).unwrap_or_default();
        let typed = |ports: &[asmotion_component::declaration::PortDeclaration]| {
            let typed = ports.iter().map(|port| PresentEndpoint {
                name: port.name.clone(),
                kind: port.schema.name.to_string(),
                lost: 0,
                waiting: 0,
            });
            typed.collect::<Vec<_>>()
        };
        let mut inputs = typed(&declared.inputs);
        for (input, lost) in inputs.iter_mut().zip(run.lost(name)) {
            input.lost = lost;
        }
        for (input, waiting) in inputs.iter_mut().zip(run.waiting(name)) {
            input.waiting = waiting;
        }
        let mut services: Vec<_> = declared.services.iter().map(PresentService::of).collect();
        for (service, refused) in services.iter_mut().zip(run.refused_requests(name)) {
            service.refused = refused;
        }
        for (service, waiting) in services.iter_mut().zip(run.waiting_requests(name)) {
            service.waiting = waiting;
        }
        let Losses { dropped, misfits } = run.losses(name);
        // a component in a long cycle is not asked twice; `after` fills in the previous values
        let properties = run.properties(name);
        let inspection = match &properties {
            Ok(_) => run.inspect(name).unwrap_or_default(),
            Err(_) => Vec::new(),
        };
        Self {
            name: name.to_owned(),
            id: name.to_owned(),
            state: run
                .state(name)
                .as_ref()
                .map(State::to_string)
                .unwrap_or_default(),
            period_ms: u64::try_from(run.period(name).as_millis()).unwrap_or(u64::MAX),
            thread: run
                .thread_use(name)
                .as_ref()
                .map(ThreadUse::to_string)
                .unwrap_or_default(),
            cycles: run.cycles(name),
            rate_hz: 0.0,
            overruns: run.overruns(name),
            late: run.late(name),
            cycle_mean_ms: milliseconds(run.cycle_time(name).mean(run.cycles(name))),
            cycle_max_ms: milliseconds(run.cycle_time(name).longest),
            dropped,
            misfits,
            waiting: run.waiting_inside(name),
            inputs,
            outputs: typed(&declared.outputs),
            services,
            references: declared
                .references
                .iter()
                .map(|reference| PresentEndpoint {
                    name: reference.name.clone(),
                    kind: reference.interface.clone(),
                    lost: 0,
                    waiting: 0,
                })
                .collect(),
            properties: properties.unwrap_or_default(),
            inspection,
        }
    }
}

fn milliseconds(span: Duration) -> f64 {
    span.as_secs_f64() * 1e3
}

impl PresentService {
    fn of(service: &asmotion_component::declaration::ServiceDeclaration) -> Self {
        let operations = service.operations.iter().map(|operation| PresentOperation {
            name: operation.name.clone(),
            request: operation.request.name.to_string(),
            response: operation.response.name.to_string(),
            while_stopped: operation.while_stopped,
        });
        Self {
            name: service.name.clone(),
            interface: service.interface.clone(),
            operations: operations.collect(),
            refused: 0,
            waiting: 0,
        }
    }
}
