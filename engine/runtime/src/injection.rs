//! Injection ports: connections from outside the system into its input ports and topics.

use std::sync::Arc;

use asmotion_component::suggestion_among;
use asmotion_datum::{DatumError, Sample};
use asmotion_port::{
    AnySender, ChannelOpener, ConnectionId, Lock, LossCounter, Policy, PushOutcome, ReadingEnd,
    SampleSnapshot, Time,
};
use serde::{Deserialize, Serialize};

use crate::component_end::ComponentEnd;
use crate::component_unit::ComponentUnit;
use crate::connections::ConnectionTable;
use crate::effects::Effects;
use crate::event::Event;
use crate::run_error::RunError;
use crate::topic::SystemTopic;

/// Capacity, in samples, of the queue between an injection port and its component's next cycle.
pub(crate) const WAITING: usize = 64;

/// A connection from outside the system into one input port. Used by one thread at a time.
pub struct InjectionPort {
    /// Full name of the input, `component.port`.
    name: String,
    component: usize,
    connection: ConnectionId,
    /// Whether a sample triggers the component.
    trigger: bool,
    /// The port's type, for error messages.
    expected: String,
    /// `None` if the component has been removed.
    sender: Option<Box<dyn AnySender>>,
    dropped: u64,
    /// The input's counter of lost messages.
    losses: LossCounter,
}

/// Injection ports, indexed by port and by topic.
pub struct InjectionPorts {
    /// One for each input of the system; empty if these are the ports of topics only.
    ports: Vec<InjectionPort>,
    /// Topics, each with an injection port for every subscriber, under the subscriber's policy.
    topics: Vec<(String, Vec<InjectionPort>)>,
}

/// The target of an injected sample.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub enum InjectionTarget {
    /// The input port at this position.
    Port(usize),
    /// All subscribers of the topic at this position.
    Topic(usize),
}

impl InjectionPorts {
    pub(crate) fn new(
        units: &mut [ComponentUnit],
        topics: &[SystemTopic],
        connections: &mut ConnectionTable,
    ) -> Self {
        let mut ports = Vec::new();
        for unit in &mut *units {
            let inputs = unit.body.inputs.len();
            let policy = Policy::buffer(WAITING);
            ports.extend((0..inputs).filter_map(|index| {
                InjectionPort::open_undeclared(unit, index, &policy, connections.next_id())
            }));
        }
        Self {
            ports,
            ..Self::of_topics(units, topics, connections)
        }
    }

    /// Opens injection ports for the subscribers of topics, and for no other inputs.
    pub(crate) fn of_topics(
        units: &mut [ComponentUnit],
        topics: &[SystemTopic],
        connections: &mut ConnectionTable,
    ) -> Self {
        let topics = topics
            .iter()
            .map(|topic| {
                let injections = topic.subscribers.iter().filter_map(|(end, policy)| {
                    let unit = units.get_mut(end.unit)?;
                    InjectionPort::open(unit, end.index, policy, connections.next_id())
                });
                (topic.name.clone(), injections.collect())
            })
            .collect();
        Self {
            ports: Vec::new(),
            topics,
        }
    }

    /// The target of a sample for an input port, `Component.port`.
    ///
    /// # Errors
    /// There is no such port, or it cannot read the sample.
    pub(crate) fn port(
        &self,
        name: &str,
        sample: &Arc<dyn Sample>,
    ) -> Result<InjectionTarget, RunError> {
        let Some(index) = self
            .ports
            .iter()
            .position(|injection| injection.sender.is_some() && injection.name == name)
        else {
            return Err(RunError::Unknown {
                kind: "input",
                name: name.to_owned(),
                nearest: suggestion_among(
                    name,
                    self.ports
                        .iter()
                        .filter(|injection| injection.sender.is_some())
                        .map(|injection| &*injection.name),
                ),
            });
        };
        self.ports[index].accepts(sample)?;
        Ok(InjectionTarget::Port(index))
    }

    /// The target of a sample for a topic.
    ///
    /// # Errors
    /// There is no such topic, or a subscriber cannot read the sample.
    pub(crate) fn topic(
        &self,
        name: &str,
        sample: &Arc<dyn Sample>,
    ) -> Result<InjectionTarget, RunError> {
        let Some(index) = self.topics.iter().position(|(topic, _)| topic == name) else {
            return Err(RunError::Unknown {
                kind: "topic",
                name: name.to_owned(),
                nearest: suggestion_among(name, self.topics.iter().map(|(topic, _)| &**topic)),
            });
        };
        let injections = &self.topics[index].1;
        injections
            .iter()
            .try_for_each(|injection| injection.accepts(sample))?;
        Ok(InjectionTarget::Topic(index))
    }

    /// Puts a sample into its target and reports it to the observers.
    pub fn inject(
        &mut self,
        target: InjectionTarget,
        sample: &Arc<dyn Sample>,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        let name = match target {
            InjectionTarget::Port(port) => &self.ports[port].name,
            InjectionTarget::Topic(topic) => &self.topics[topic].0,
        };
        effects.emit(
            now,
            &Event::Injected {
                target: name,
                source: None,
                sample: &**sample,
            },
        );
        for injection in self.target_ports(target) {
            injection.send(sample, now, now, effects);
        }
    }

    /// Adds the ports into the inputs of a new component, and those of the topics to which it subscribes.
    pub(crate) fn add(&mut self, ports: Vec<InjectionPort>, topics: Vec<(String, InjectionPort)>) {
        self.ports.extend(ports);
        for (topic, port) in topics {
            match self.topics.iter_mut().find(|(known, _)| *known == topic) {
                Some((_, ports)) => ports.push(port),
                None => self.topics.push((topic, vec![port])),
            }
        }
    }

    /// Closes the ports into a component that is removed. They keep their positions, to which planned samples refer.
    pub(crate) fn close(&mut self, component: usize) {
        for port in &mut self.ports {
            if port.component == component {
                port.sender = None;
            }
        }
        for (_, ports) in &mut self.topics {
            ports.retain(|port| port.component != component);
        }
    }

    /// The connections into an input by a topic.
    pub(crate) fn by_topic(&self, topic: &str, input: &str) -> Vec<ConnectionId> {
        let topics = self.topics.iter().filter(|(known, _)| known == topic);
        let ports = topics.flat_map(|(_, ports)| ports);
        let ports = ports.filter(|port| port.name == input);
        ports.map(InjectionPort::connection).collect()
    }

    /// Closes the ports into an input that no longer subscribes to a topic.
    pub(crate) fn close_topic(&mut self, topic: &str, input: &str) {
        for (known, ports) in &mut self.topics {
            if known == topic {
                ports.retain(|port| port.name != input);
            }
        }
    }

    /// Iterates over all injection ports in order of creation.
    pub(crate) fn all(&self) -> impl Iterator<Item = &InjectionPort> {
        let of_topics = self.topics.iter().flat_map(|(_, ports)| ports);
        self.ports.iter().chain(of_topics)
    }

    /// Iterates over all injection ports in order of creation.
    pub(crate) fn all_mut(&mut self) -> impl Iterator<Item = &mut InjectionPort> {
        let of_topics = self.topics.iter_mut().flat_map(|(_, ports)| ports);
        self.ports.iter_mut().chain(of_topics)
    }

    /// Returns whether the target exists.
    pub(crate) fn contains(&self, target: InjectionTarget) -> bool {
        match target {
            InjectionTarget::Port(port) => port < self.ports.len(),
            InjectionTarget::Topic(topic) => topic < self.topics.len(),
        }
    }

    fn target_ports(&mut self, target: InjectionTarget) -> &mut [InjectionPort] {
        match target {
            InjectionTarget::Port(port) => std::slice::from_mut(&mut self.ports[port]),
            InjectionTarget::Topic(topic) => self.topics[topic].1.as_mut_slice(),
        }
    }
}

impl InjectionPort {
    /// Opens a connection into an input port. Returns `None` if the policy asks for zeros that the type does not have.
    pub(crate) fn open(
        unit: &mut ComponentUnit,
        index: usize,
        policy: &Policy,
        connection: ConnectionId,
    ) -> Option<Self> {
        Self::open_end(unit, index, policy, connection, |end| end)
    }

    /// Opens a connection that is not part of the system's declaration.
    pub(crate) fn open_undeclared(
        unit: &mut ComponentUnit,
        index: usize,
        policy: &Policy,
        connection: ConnectionId,
    ) -> Option<Self> {
        Self::open_end(unit, index, policy, connection, ReadingEnd::undeclared)
    }

    fn open_end(
        unit: &mut ComponentUnit,
        index: usize,
        policy: &Policy,
        connection: ConnectionId,
        marked: impl Fn(ReadingEnd) -> ReadingEnd,
    ) -> Option<Self> {
        let port = unit.body.declaration.inputs.get(index)?;
        let name = format!("{}.{}", unit.name, port.name);
        let expected = port.schema.to_string();
        let input = unit.body.inputs.get_mut(index)?;
        let opener = input.opener();
        let policy = policy.for_external();
        let opened = match policy.lock {
            Lock::LockFree if !policy.pull => opener.open_on_demand(connection, &policy),
            Lock::LockFree | Lock::Locked | Lock::Unsync => opener.open(connection, &policy, None),
        };
        let (sender, reading_end) = opened.ok()?;
        input.connect(marked(reading_end));
        Some(Self {
            name,
            component: unit.index,
            connection,
            trigger: policy.trigger,
            expected,
            sender: Some(sender),
            dropped: 0,
            losses: opener.losses(),
        })
    }

    /// Opens a connection into an input of a component that other threads may own: the input's thread connects the reading
    /// end. Returns `None` if the policy asks for zeros that the type does not have.
    pub(crate) fn opened(
        end: &ComponentEnd,
        expected: String,
        policy: &Policy,
        connection: ConnectionId,
        opener: &dyn ChannelOpener,
    ) -> Option<(Self, ReadingEnd)> {
        let (sender, reading_end) = opener.open(connection, &policy.for_external(), None).ok()?;
        let port = Self {
            name: end.name.clone(),
            component: end.unit,
            connection,
            trigger: policy.trigger,
            expected,
            sender: Some(sender),
            dropped: 0,
            losses: opener.losses(),
        };
        Some((port, reading_end))
    }

    /// Full name of the input, `component.port`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the connection into the input port.
    pub fn connection(&self) -> ConnectionId {
        self.connection
    }

    /// Returns the name of the reading component.
    pub(crate) fn component_name(&self) -> &str {
        self.name
            .rsplit_once('.')
            .map_or(&*self.name, |(component, _)| component)
    }

    /// Returns the number of samples dropped so far.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Sets the number of samples dropped so far.
    pub(crate) fn set_dropped(&mut self, dropped: u64) {
        self.dropped = dropped;
    }

    /// Sends the unread samples of the connection again, without side effects.
    ///
    /// # Errors
    ///
    /// An error if a sample does not have the type of the port.
    pub(crate) fn refill(&mut self, waiting: &[SampleSnapshot]) -> Result<(), DatumError> {
        let Some(sender) = &mut self.sender else {
            return Ok(());
        };
        for sample in waiting {
            let value = Arc::new(sample.value.clone());
            sender.send_sample(value, sample.at, sample.order)?;
        }
        Ok(())
    }

    fn accepts(&self, sample: &Arc<dyn Sample>) -> Result<(), RunError> {
        let checked = self.sender.as_ref().map(|sender| sender.check(sample));
        let checked = checked.unwrap_or(Ok(()));
        checked.map_err(|source| RunError::Mismatch {
            target: self.name.clone(),
            expected: self.expected.clone(),
            source: Box::new(source),
        })
    }

    /// Puts a sample into this port alone and reports it to the observers.
    pub fn inject(&mut self, sample: &Arc<dyn Sample>, now: Time, effects: &mut dyn Effects) {
        self.emit(sample, None, now, effects);
        self.send(sample, now, now, effects);
    }

    /// Puts a sample that `source` wrote at the instant `written` into this port alone and reports it to the observers. Age
    /// limits of connections count from `written`.
    pub fn inject_written(
        &mut self,
        sample: &Arc<dyn Sample>,
        (source, written): (&str, Time),
        now: Time,
        effects: &mut dyn Effects,
    ) {
        self.emit(sample, Some(source), now, effects);
        self.send(sample, written, now, effects);
    }

    fn emit(
        &self,
        sample: &Arc<dyn Sample>,
        source: Option<&str>,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        let event = Event::Injected {
            target: &self.name,
            source,
            sample: &**sample,
        };
        effects.emit(now, &event);
    }

    fn send(
        &mut self,
        sample: &Arc<dyn Sample>,
        written: Time,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        let order = effects.next_order();
        let Some(sender) = &mut self.sender else {
            return self.count_dropped(1, None, now, effects);
        };
        let delivery = sender.send_sample(Arc::clone(sample), written, order);
        if self.trigger
            && matches!(
                delivery,
                Ok(PushOutcome::Stored | PushOutcome::DroppedOldest)
            )
        {
            effects.trigger(self.component);
        }
        if delivery != Ok(PushOutcome::Stored) {
            self.count_dropped(1, delivery.as_ref().err(), now, effects);
        }
    }

    /// Counts samples that could not be put into the port, with the reason if it is known.
    pub fn count_dropped(
        &mut self,
        count: u64,
        reason: Option<&DatumError>,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        self.dropped += count;
        self.losses.add(count);
        effects.emit(
            now,
            &Event::Dropped {
                component: "",
                port: "outside",
                to: &self.name,
                total: self.dropped,
                reason,
            },
        );
    }
}
