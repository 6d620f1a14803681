//! Observes a run of a composite and follows each component that has a protocol.

use super::acceptor::ProtocolAcceptor;
use super::events::{EventSuccession, PossibleEvents, PrecedingEvent, SentEvent};
use super::observed::{MessageEnd, ObservedCycle, ObservedMessage, ProtocolDeviation};
use crate::error::ModelError;
use crate::network::{providers, writers};
use crate::protocol_text::{names_of, protocol_of};
use asmotion_component::{CallError, Time};
use asmotion_datum::{Datum, Sample, Schema};
use asmotion_diagnostics::Loader;
use asmotion_plan::{Component, End, Part, Plan, Terminal};
use asmotion_runtime::{Event, Observer};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

/// Follows the components of a composite during a run. Clones share what they have seen.
#[derive(Clone)]
pub struct ProtocolObserver(Arc<Mutex<Observation>>);

struct Observation {
    components: BTreeMap<String, FollowedComponent>,
    /// Input ports of followed components, by the port that writes to them.
    readers: BTreeMap<End, Vec<End>>,
    /// Input ports of followed components, by the topic that they subscribe to.
    subscribers: BTreeMap<String, Vec<End>>,
    /// Services of followed components, by the reference that calls them.
    called: BTreeMap<End, Vec<End>>,
    /// Types of the ports of followed components: a message can leave out fields with their initial values.
    types: BTreeMap<End, Schema>,
}

struct FollowedComponent {
    acceptor: ProtocolAcceptor,
    /// Messages that have arrived since the last cycle began.
    arrived: Vec<ObservedMessage>,
    current: Option<ObservedCycle>,
    found: ComponentConformance,
}

/// The observations of a component.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComponentConformance {
    /// Number of cycles that the protocol allows.
    pub cycles: u64,
    /// Events that were sent.
    pub sent: BTreeSet<SentEvent>,
    /// Events that the protocol can send; `None` if it has too many states to find out.
    pub possible: Option<PossibleEvents>,
    /// Which events followed which.
    pub followed: BTreeSet<EventSuccession>,
    /// The first cycle that the protocol does not allow, and its time; nothing after it was examined.
    pub deviation: Option<(Time, ProtocolDeviation)>,
}

impl ComponentConformance {
    /// Returns the events that the protocol can send, and that were not observed. A message without a value counts for each
    /// value of its function.
    pub fn never_sent(&self) -> BTreeSet<SentEvent> {
        let is_sent = |event: &&SentEvent| {
            self.sent.contains(event)
                || self.sent.contains(&SentEvent {
                    value: String::new(),
                    ..(*event).clone()
                })
        };
        let possible = self.possible.iter().flat_map(|it| &it.events);
        possible.filter(|it| !is_sent(it)).cloned().collect()
    }

    /// Returns the messages that can follow each other according to the protocol, and that never did, although the events were sent. A
    /// protocol that allows more than its component does has such successions: either the runs do not provoke them, or the protocol
    /// can be stricter. A message without a value counts for each value of its function.
    pub fn never_followed(&self) -> BTreeSet<EventSuccession> {
        let never_sent = self.never_sent();
        let is_like = |seen: &SentEvent, event: &SentEvent| {
            seen.function == event.function && (seen.value.is_empty() || seen.value == event.value)
        };
        let has_followed = |succession: &EventSuccession| {
            self.followed.iter().any(|seen| {
                is_like(&seen.after, &succession.after)
                    && match (&seen.before, &succession.before) {
                        (Some(PrecedingEvent::Sent(seen)), Some(PrecedingEvent::Sent(event))) => {
                            is_like(seen, event)
                        }
                        (seen, event) => seen == event,
                    }
            })
        };
        let possible = self.possible.iter().flat_map(|it| &it.successions);
        let of_sent = possible.filter(|it| {
            let is_known = |event: &SentEvent| !never_sent.contains(event);
            let is_before_known = match &it.before {
                Some(PrecedingEvent::Sent(event)) => is_known(event),
                Some(PrecedingEvent::Received(_)) | None => true,
            };
            is_before_known && is_known(&it.after)
        });
        of_sent.filter(|it| !has_followed(it)).cloned().collect()
    }
}

impl ProtocolObserver {
    /// Prepares to follow the components of a part of a plan that have a protocol. `protocols` returns the text of the protocol
    /// that comes with a component of the catalogue.
    ///
    /// # Errors
    /// A protocol has errors, or names something that its component does not have.
    pub fn new(
        plan: &Plan,
        part: &Part,
        loader: &dyn Loader,
        protocols: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Self, ModelError> {
        let mut observation = Observation {
            components: BTreeMap::new(),
            readers: BTreeMap::new(),
            subscribers: BTreeMap::new(),
            called: BTreeMap::new(),
            types: BTreeMap::new(),
        };
        for component in plan.components.iter().filter(|it| part.has(&it.name)) {
            let Some(protocol) = protocol_of(component, protocols) else {
                continue;
            };
            let (path, files) = protocol.files(loader);
            let mut acceptor =
                ProtocolAcceptor::open(&component.name, &names_of(component), &path, &files)?;
            observation.connect(plan, part, component);
            let found = ComponentConformance {
                possible: acceptor.possible_events(),
                ..ComponentConformance::default()
            };
            let followed = FollowedComponent {
                acceptor,
                arrived: Vec::new(),
                current: None,
                found,
            };
            observation
                .components
                .insert(component.name.clone(), followed);
        }
        Ok(Self(Arc::new(Mutex::new(observation))))
    }

    /// Returns what was observed so far of each component, including its current cycle.
    pub fn found(&self) -> BTreeMap<String, ComponentConformance> {
        let mut observation = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for component in observation.components.values_mut() {
            component.end_cycle(Time::ZERO);
            component.found.followed = component.acceptor.followed().clone();
        }
        let components = observation.components.iter();
        components
            .map(|(name, it)| (name.clone(), it.found.clone()))
            .collect()
    }
}

impl Observation {
    /// Notes what the component receives from whom. What a topic takes by the bus arrives when it comes back.
    fn connect(&mut self, plan: &Plan, part: &Part, component: &Component) {
        let end = |name: &str| End {
            component: component.name.clone(),
            name: name.to_owned(),
        };
        for port in component.inputs.iter().chain(&component.outputs) {
            if let Some(schema) = plan.types.get(&port.kind) {
                self.types.insert(end(&port.name), schema.clone());
            }
        }
        for port in &component.inputs {
            let input = end(&port.name);
            let ends = if part.takes_the_bus_inside() {
                connected(plan, &input)
            } else {
                writers(plan, &input).ends
            };
            for writer in ends {
                self.readers.entry(writer).or_default().push(input.clone());
            }
            let topics = plan.topics.iter();
            for topic in topics.filter(|it| it.subscribers.contains(&input)) {
                let subscribers = self.subscribers.entry(topic.name.clone());
                subscribers.or_default().push(input.clone());
            }
        }
        for wire in &plan.wires {
            for service in providers(plan, &wire.reference).ends {
                if service.component == component.name {
                    let called = self.called.entry(wire.reference.clone()).or_default();
                    if !called.contains(&service) {
                        called.push(service);
                    }
                }
            }
        }
    }

    fn arrive(&mut self, inputs: &[End], content: &Datum) {
        for input in inputs {
            let content = self.complete(input, content);
            if let Some(component) = self.components.get_mut(&input.component) {
                component.arrived.push(ObservedMessage {
                    end: MessageEnd::Port(input.name.clone()),
                    content,
                });
            }
        }
    }

    /// The content of a message at a port, with the fields that it leaves out.
    fn complete(&self, port: &End, content: &Datum) -> Datum {
        let schema = self.types.get(port);
        let complete = schema.and_then(|schema| schema.complete(content.clone()).ok());
        complete.unwrap_or_else(|| content.clone())
    }

    fn send(&mut self, component: &str, end: MessageEnd, content: Datum) {
        let component = self.components.get_mut(component);
        if let Some(cycle) = component.and_then(|it| it.current.as_mut()) {
            cycle.sent.push(ObservedMessage { end, content });
        }
    }
}

/// The ports that write to an input port without a topic.
fn connected(plan: &Plan, input: &End) -> Vec<End> {
    let into = plan.connections.to_end(&Terminal::Port(input.clone()));
    into.filter_map(|it| match &it.from {
        Terminal::Port(from) => Some(from.clone()),
        Terminal::Topic(_) | Terminal::Mqueue(_) => None,
    })
    .collect()
}

impl FollowedComponent {
    fn begin_cycle(&mut self, at: Time) {
        self.end_cycle(at);
        self.current = Some(ObservedCycle {
            received: std::mem::take(&mut self.arrived),
            sent: Vec::new(),
        });
    }

    fn end_cycle(&mut self, at: Time) {
        let Some(cycle) = self.current.take() else {
            return;
        };
        if self.found.deviation.is_some() {
            return;
        }
        match self.acceptor.follow(&cycle) {
            Ok(sent) => {
                self.found.cycles += 1;
                self.found.sent.extend(sent);
            }
            Err(deviation) => self.found.deviation = Some((at, deviation)),
        }
    }

    /// A component that is started again begins its protocol anew.
    fn restart(&mut self, at: Time) {
        self.end_cycle(at);
        self.acceptor.restart();
    }
}

impl Observer for ProtocolObserver {
    fn observe(&mut self, at: Time, event: &Event<'_>) {
        let mut observation = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let observation = &mut *observation;
        if let Event::Cycle { component, .. } = event {
            if let Some(followed) = observation.components.get_mut(*component) {
                followed.begin_cycle(at);
            }
        } else if let Event::Published {
            component,
            port,
            sample,
            ..
        } = event
        {
            let writer = End {
                component: (*component).to_owned(),
                name: (*port).to_owned(),
            };
            let inputs = observation.readers.get(&writer).cloned();
            if inputs.is_none() && !observation.components.contains_key(*component) {
                return;
            }
            let content = content(*sample);
            observation.arrive(&inputs.unwrap_or_default(), &content);
            let content = observation.complete(&writer, &content);
            observation.send(component, MessageEnd::Port(writer.name), content);
        } else if let Event::Injected { target, sample, .. } = event {
            let ports = target.rsplit_once('.').map(|(component, name)| End {
                component: component.to_owned(),
                name: name.to_owned(),
            });
            let subscribers = observation.subscribers.get(*target).cloned();
            let inputs = subscribers.unwrap_or_else(|| ports.into_iter().collect());
            observation.arrive(&inputs, &content(*sample));
        } else if let Event::Called {
            component,
            reference,
            operation,
            argument,
            ..
        } = event
        {
            let caller = End {
                component: (*component).to_owned(),
                name: (*reference).to_owned(),
            };
            let argument = content(*argument);
            for service in observation.called.get(&caller).cloned().unwrap_or_default() {
                if let Some(followed) = observation.components.get_mut(&service.component) {
                    followed.arrived.push(ObservedMessage {
                        end: MessageEnd::Operation {
                            service: service.name.clone(),
                            operation: (*operation).to_owned(),
                        },
                        content: argument.clone(),
                    });
                }
            }
            let end = MessageEnd::Operation {
                service: caller.name,
                operation: (*operation).to_owned(),
            };
            observation.send(component, end, argument);
        } else if let Event::Answered {
            component,
            service,
            operation,
            result,
            ..
        } = event
        {
            let answer = match result {
                Ok(_) => "OK",
                Err(CallError::Fault(fault)) => fault.code.as_str(),
                // an answer of the runtime, not of the component
                Err(
                    CallError::Timeout
                    | CallError::Unavailable
                    | CallError::Stopped
                    | CallError::Cancelled,
                ) => return,
            };
            let end = MessageEnd::Operation {
                service: (*service).to_owned(),
                operation: (*operation).to_owned(),
            };
            observation.send(component, end, Datum::text(answer));
        } else if let Event::LifeCycle { component, to, .. } = event
            && to.is_running()
            && let Some(followed) = observation.components.get_mut(*component)
        {
            followed.restart(at);
        }
    }
}

/// The content of a sample; null if it cannot be described.
fn content(sample: &dyn Sample) -> Datum {
    sample.to_datum().unwrap_or_default()
}
