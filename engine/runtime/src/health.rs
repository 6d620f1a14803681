//! Publishes the state of the bus as a topic of the system.

use std::sync::Arc;

use asmotion_component::{BusHealth, HEALTH_TOPIC};
use asmotion_datum::Sample;
use asmotion_port::Time;

use crate::effects::Effects;
use crate::injection::{InjectionPorts, InjectionTarget};
use crate::topic::SystemTopic;

/// The subscribers of [`HEALTH_TOPIC`] among the topics of a system.
pub struct HealthTopic {
    /// `None` if the topic has no subscribers.
    target: Option<InjectionTarget>,
}

impl HealthTopic {
    /// Finds the topic. `topics` must be in the order in which injection ports were opened for them.
    pub fn new(topics: &[SystemTopic]) -> Self {
        let is_read =
            |topic: &SystemTopic| topic.name == HEALTH_TOPIC && !topic.subscribers.is_empty();
        let position = topics.iter().position(is_read);
        Self {
            target: position.map(InjectionTarget::Topic),
        }
    }

    /// Returns whether the topic has a subscriber.
    pub fn is_read(&self) -> bool {
        self.target.is_some()
    }

    /// Publishes a state of the bus and the reason for it.
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

/// Publishes that the bus is up, for a system that uses no bus and therefore cannot lose it.
pub fn publish_without_bus(
    topics: &[SystemTopic],
    ports: &mut InjectionPorts,
    now: Time,
    effects: &mut dyn Effects,
) {
    HealthTopic::new(topics).publish(BusHealth::UP, "", ports, now, effects);
}
