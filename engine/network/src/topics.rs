//! Topics on the bus: sends samples of the system, and receives those of other processes.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::{Bus, BusError, Payload, PublishOptions, Publisher, SenderId};
use asmotion_component::HEALTH_TOPIC;
use asmotion_datum::{DatumError, DatumProblem, Sample};
use asmotion_port::{AnySender, PushOutcome, Time};
use asmotion_runtime::{
    ComponentEnd, CycleCause, Effects, InjectionPorts, LiveContext, System, SystemTopic,
};

use crate::health::HealthPublisher;
use crate::identity::BusIdentity;
use crate::remote_ends::port_topic;
use crate::subscription::TopicSubscription;

/// The system's topics on one bus.
pub(crate) struct BusTopics {
    subscriptions: Vec<TopicSubscription>,
    health: HealthPublisher,
    /// Injection ports of the subscribers of [`HEALTH_TOPIC`].
    health_ports: InjectionPorts,
    bus: Arc<dyn Bus>,
}

impl BusTopics {
    /// Connects topics, and outputs read by other processes, to the bus. If the bus connects the topic's local ends
    /// too, the process also receives its own messages.
    pub(crate) fn new<'e>(
        system: &mut System,
        topics: &[SystemTopic],
        publish_options: &BTreeMap<String, PublishOptions>,
        exposed: impl Iterator<Item = &'e (ComponentEnd, PublishOptions)>,
        identity: &BusIdentity,
    ) -> Result<Self, BusError> {
        for topic in topics {
            let sending = publish_options
                .get(&topic.name)
                .copied()
                .unwrap_or_default();
            for end in &topic.publishers {
                publish(system, end, &topic.name, sending, identity)?;
            }
        }
        for (end, sending) in exposed {
            publish(system, end, &port_topic(end.name()), *sending, identity)?;
        }
        let own = (!system.leaves_topics_to_adapters()).then_some(identity.incarnation);
        let is_health = |topic: &&SystemTopic| topic.name == HEALTH_TOPIC;
        let mut subscriptions = Vec::new();
        for topic in topics.iter().filter(|topic| !is_health(topic)) {
            for (end, policy) in &topic.subscribers {
                let subscription =
                    TopicSubscription::new(system, &topic.name, end, policy, own, identity)?;
                subscriptions.extend(subscription);
            }
        }
        let health: Vec<SystemTopic> = topics
            .iter()
            .filter(is_health)
            .map(|it| it.filtered(|_| true))
            .collect();
        Ok(Self {
            subscriptions,
            health: HealthPublisher::new(&health),
            health_ports: system.injection_topics(&health),
            bus: Arc::clone(&identity.bus),
        })
    }

    /// From now on, receiving threads put messages into ports.
    pub(crate) fn start_live(&self, context: &LiveContext) {
        for subscription in &self.subscriptions {
            subscription.start_live(context);
        }
    }

    /// Moves arrived messages into ports, and publishes the state of the bus.
    pub(crate) fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        let bus = &self.bus;
        self.health
            .publish(|| bus.health(), &mut self.health_ports, now, effects);
        for subscription in &self.subscriptions {
            subscription.deliver(now, effects);
        }
    }
}

/// Publishes an output on the bus as well.
fn publish(
    system: &mut System,
    end: &ComponentEnd,
    topic: &str,
    options: PublishOptions,
    identity: &BusIdentity,
) -> Result<(), BusError> {
    let origin = SenderId::new(system.external_name(end), identity.incarnation);
    let cause = system.cycle_cause(end);
    let schema = system.output_schema(end);
    let publisher = identity.bus.publisher(topic, &origin, schema, options)?;
    let sender = BusSender { publisher, cause };
    system.connect_output(end, Box::new(sender), format!("bus topic {topic}"));
    Ok(())
}

/// Adapts a publisher to the reading end of a connection.
struct BusSender {
    publisher: Box<dyn Publisher>,
    /// The cause of the component's current cycle.
    cause: Arc<CycleCause>,
}

impl AnySender for BusSender {
    fn check(&self, _: &Arc<dyn Sample>) -> Result<(), DatumError> {
        Ok(())
    }

    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        at: Time,
        _: u64,
    ) -> Result<PushOutcome, DatumError> {
        let payload = Payload::Sample(sample);
        let cause = self.cause.current();
        match self.publisher.publish_traced(at.nanos(), payload, cause) {
            Ok(()) => Ok(PushOutcome::Stored),
            Err(error) => Err(DatumError::new(DatumProblem::Mismatch(error.to_string()))),
        }
    }
}
