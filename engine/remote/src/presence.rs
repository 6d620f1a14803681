//! Presence: what a process says of itself, for tools and for strangers. `docs/wire.md` describes it.

use std::time::Duration;

use asmotion_assembly::Part;
use asmotion_assembly::plan::{self, End, Plan};
use asmotion_bus::Envelope;
use asmotion_component::{Losses, State};
use asmotion_datum::Datum;
use asmotion_runtime::Run;
use serde::{Deserialize, Serialize};

/// The type of the message.
pub const PRESENCE: &str = "asmotion/Presence";

/// The topic of a process' presence: `presence.onboard`.
pub fn presence_topic(process: &str) -> String {
    format!("presence.{process}")
}

/// What a process said, and on whose behalf.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotPresence {
    /// The robot, which its topics are below; empty if it has no name.
    pub robot: String,
    /// What was said.
    pub presence: Presence,
}

impl RobotPresence {
    /// The word in a message; none if it is another one.
    pub fn of(envelope: &Envelope) -> Option<Self> {
        let presence = envelope.payload.to_datum().ok()?.to::<Presence>().ok()?;
        let topic = presence_topic(&presence.process);
        let robot = envelope.topic.strip_suffix(&topic)?;
        Some(Self {
            robot: robot.trim_end_matches('.').to_owned(),
            presence,
        })
    }

    /// A topic or address of this robot, as a whole key.
    pub fn key(&self, name: &str) -> String {
        key(&self.robot, name)
    }
}

/// A topic or address of a robot as a whole key.
pub fn key(robot: &str, name: &str) -> String {
    match robot {
        "" => name.to_owned(),
        robot => format!("{robot}.{name}"),
    }
}

/// What a process says of itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Presence {
    /// The composite it runs.
    pub composite: String,
    /// Its name.
    pub process: String,
    /// Whether this is its last word.
    pub leaves: bool,
    /// Its components, in the order of the composite.
    pub components: Vec<PresentComponent>,
    /// The topics that its components are on.
    pub topics: Vec<PresentTopic>,
    /// What joins its components to each other, and to those of other processes.
    pub joined: Vec<PresentConnection>,
}

/// A writer and its reader, or a caller and its service.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentConnection {
    /// `Component.port`, or `Component.reference`.
    pub from: String,
    /// `Component.port`, or `Component.service`.
    pub to: String,
}

/// A component.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentComponent {
    /// Its name.
    pub name: String,
    /// Its state in its life cycle: `Running`.
    pub state: String,
    /// How often it shall cycle, in milliseconds; 0 where events drive it.
    pub period_ms: u64,
    /// How many cycles it has begun.
    pub cycles: u64,
    /// Cycles a second, since the word before.
    pub rate_hz: f64,
    /// How many periods it has missed.
    pub overruns: u64,
    /// How many of its cycles took longer than their deadline.
    pub late: u64,
    /// How long its cycles took, in milliseconds: in the mean.
    pub cycle_mean_ms: f64,
    /// The longest of them.
    pub cycle_max_ms: f64,
    /// How many messages it has dropped, because too many waited.
    pub dropped: u64,
    /// How many it has left out, because they did not fit.
    pub misfits: u64,
    /// Input ports.
    pub inputs: Vec<PresentEndpoint>,
    /// Output ports.
    pub outputs: Vec<PresentEndpoint>,
    /// Services.
    pub services: Vec<PresentService>,
    /// References.
    pub references: Vec<PresentEndpoint>,
    /// Properties, as they are.
    pub properties: Vec<(String, Datum)>,
}

/// A port and its message type, or a reference and its interface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentEndpoint {
    /// Its name.
    pub name: String,
    /// Its type.
    #[serde(rename = "type")]
    pub kind: String,
}

/// A service; an operation is called at `Component.service.operation`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentService {
    /// Its name.
    pub name: String,
    /// Its interface.
    pub interface: String,
    /// Its operations.
    pub operations: Vec<PresentOperation>,
}

/// An operation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentOperation {
    /// Its name.
    pub name: String,
    /// The type of what is sent.
    pub request: String,
    /// The type of what is answered.
    pub response: String,
}

/// A topic, as far as it is in this process.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PresentTopic {
    /// Its name.
    pub name: String,
    /// The type of its messages, if anybody says.
    #[serde(rename = "type")]
    pub kind: Option<String>,
    /// `Component.port` of who writes to it.
    pub publishers: Vec<String>,
    /// Of who reads it.
    pub subscribers: Vec<String>,
}

impl Presence {
    /// What there is to say of a running part of a plan.
    pub fn of(plan: &Plan, part: &Part, process: &str, run: &mut dyn Run) -> Self {
        let names = run.components();
        Self {
            composite: plan.name.clone(),
            process: process.to_owned(),
            leaves: false,
            components: names
                .iter()
                .map(|name| PresentComponent::of(name, run))
                .collect(),
            topics: topics(plan, part),
            joined: joined(plan, part),
        }
    }

    /// Fills in the rates, from what was said so many seconds before; and the properties of those that were too busy to
    /// say them, as they were.
    #[must_use]
    pub fn after(mut self, before: Option<&Self>, seconds: f64) -> Self {
        for component in &mut self.components {
            let known = before.iter().flat_map(|before| &before.components);
            let known = known.into_iter().find(|known| known.name == component.name);
            let Some(known) = known else { continue };
            if component.properties.is_empty() {
                component.properties.clone_from(&known.properties);
            }
            if seconds > 0.0 {
                let cycles = component.cycles.saturating_sub(known.cycles);
                #[allow(clippy::cast_precision_loss, reason = "a rate is no exact number")]
                let rate = cycles as f64 / seconds;
                component.rate_hz = rate;
            }
        }
        self
    }
}

fn joined(plan: &Plan, part: &Part) -> Vec<PresentConnection> {
    let ways = plan.ways().into_iter();
    let here = ways.filter(|way| way.ends().any(|end| part.has(&end.component)));
    let joined = here.map(|way| PresentConnection {
        from: way.from.to_string(),
        to: way.to.to_string(),
    });
    joined.collect()
}

fn topics(plan: &Plan, part: &Part) -> Vec<PresentTopic> {
    let here = |ends: &[End]| -> Vec<String> {
        let here = ends.iter().filter(|end| part.has(&end.component));
        here.map(End::to_string).collect()
    };
    let topic = |topic: &plan::Topic| PresentTopic {
        name: topic.name.clone(),
        kind: topic.kind.clone(),
        publishers: here(&topic.publishers),
        subscribers: here(&topic.subscribers),
    };
    let topics = plan.topics.iter().map(topic);
    topics
        .filter(|topic| !topic.publishers.is_empty() || !topic.subscribers.is_empty())
        .collect()
}

impl PresentComponent {
    /// What there is to say of a component.
    pub(crate) fn of(name: &str, run: &mut dyn Run) -> Self {
        let declared = run.declaration(name).unwrap_or_default();
        let typed = |ports: &[asmotion_component::declaration::PortDeclaration]| {
            let typed = ports.iter().map(|port| PresentEndpoint {
                name: port.name.clone(),
                kind: port.schema.name.to_string(),
            });
            typed.collect()
        };
        let Losses { dropped, misfits } = run.losses(name);
        Self {
            name: name.to_owned(),
            state: run
                .state(name)
                .as_ref()
                .map(State::to_string)
                .unwrap_or_default(),
            period_ms: u64::try_from(run.period(name).as_millis()).unwrap_or(u64::MAX),
            cycles: run.cycles(name),
            rate_hz: 0.0,
            overruns: run.overruns(name),
            late: run.late(name),
            cycle_mean_ms: milliseconds(run.cycle_time(name).mean(run.cycles(name))),
            cycle_max_ms: milliseconds(run.cycle_time(name).longest),
            dropped,
            misfits,
            inputs: typed(&declared.inputs),
            outputs: typed(&declared.outputs),
            services: declared.services.iter().map(PresentService::of).collect(),
            references: (declared.references.iter())
                .map(|reference| PresentEndpoint {
                    name: reference.name.clone(),
                    kind: reference.interface.clone(),
                })
                .collect(),
            // one whose cycle takes long says them the next time
            properties: run.properties(name).unwrap_or_default(),
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
        });
        Self {
            name: service.name.clone(),
            interface: service.interface.clone(),
            operations: operations.collect(),
        }
    }
}
