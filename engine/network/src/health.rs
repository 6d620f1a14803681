//! Publishes the state of a bus to components.

use asmotion_bus::{Health, LinkState};
use asmotion_component::BusHealth;
use asmotion_port::Time;
use asmotion_runtime::{Effects, HealthTopic, InjectionPorts, SystemTopic};

/// Publishes the health of a bus at the start and at every change.
pub(crate) struct HealthPublisher {
    topic: HealthTopic,
    /// The state as last published.
    published: Option<Health>,
}

impl HealthPublisher {
    pub(crate) fn new(topics: &[SystemTopic]) -> Self {
        Self {
            topic: HealthTopic::new(topics),
            published: None,
        }
    }

    /// Publishes the state if it has changed and the topic has subscribers.
    pub(crate) fn publish(
        &mut self,
        health: impl FnOnce() -> Health,
        ports: &mut InjectionPorts,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        if !self.topic.is_read() {
            return;
        }
        let health = health();
        if self.published.as_ref() == Some(&health) {
            return;
        }
        let (state, reason) = match &health.link {
            LinkState::Up => (BusHealth::UP, ""),
            LinkState::Blocked { reason } => (BusHealth::BLOCKED, &**reason),
            LinkState::Down { reason } => (BusHealth::DOWN, &**reason),
        };
        self.topic.publish(state, reason, ports, now, effects);
        self.published = Some(health);
    }
}
