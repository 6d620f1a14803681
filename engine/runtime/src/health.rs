//! The state of the bus as a topic of the system.

use std::sync::Arc;

use asmotion_component::{BusHealth, HEALTH_TOPIC};
use asmotion_datum::Sample;
use asmotion_port::Time;

use crate::effects::Effects;
use crate::injection::{InjectionPorts, InjectionTarget};
use crate::topic::SystemTopic;

/// The subscribers of [`HEALTH_TOPIC`] among some topics.
pub struct HealthTopic {
    /// Absent, if there are no subscribers.
    target: Option<InjectionTarget>,
}

impl HealthTopic {
    /// Finds the topic, in the order in which injection ports have been opened for these topics.
    pub fn new(topics: &[SystemTopic]) -> Self {
        let is_read =
            |topic: &SystemTopic| topic.name == HEALTH_TOPIC && !topic.subscribers.is_empty();
        let position = topics.iter().position(is_read);
        Self {
            target: position.map(InjectionTarget::Topic),
        }
    }

    /// Whether anything reads it.
    pub fn is_read(&self) -> bool {
        self.target.is_some()
    }

    /// Tells the subscribers a state of the bus and its reason.
    pub fn publish(
        &self,
        state: &str,
        reason: &str,
        ports: &mut InjectionPorts,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        let Some(target) = self.target else {
            return;
        };
        let sample: Arc<dyn Sample> = Arc::new(BusHealth {
            state: state.to_owned(),
            reason: reason.to_owned(),
            since: now.nanos(),
        });
        ports.inject(target, &sample, now, effects);
    }
}

/// Tells components that are on no bus that it is up: they cannot lose it.
pub fn publish_without_bus(
    topics: &[SystemTopic],
    ports: &mut InjectionPorts,
    now: Time,
    effects: &mut dyn Effects,
) {
    HealthTopic::new(topics).publish(BusHealth::UP, "", ports, now, effects);
}
