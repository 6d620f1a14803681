//! Topics on the bus: sends samples of the system.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::{BusError, Payload, PublishOptions, Publisher, SenderId};
use asmotion_datum::{DatumError, DatumProblem, Sample, Schema};
use asmotion_port::{AnySender, PushOutcome, Time};
use asmotion_runtime::{ComponentEnd, CycleCause, System, SystemTopic};

use crate::identity::BusIdentity;
use crate::remote_ends::{outer_topic, port_topic};

/// Publishes topics, and outputs read by other processes, on the bus. If the bus connects the topic's local ends too, the process
/// also receives its own messages.
pub(crate) fn publish_all<'e>(
    system: &mut System,
    topics: &[SystemTopic],
    publish_options: &BTreeMap<String, PublishOptions>,
    exposed: impl Iterator<Item = &'e (ComponentEnd, PublishOptions)>,
    identity: &BusIdentity,
) -> Result<(), BusError> {
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
    Ok(())
}

/// Publishes an output on the bus as well.
fn publish(
    system: &mut System,
    end: &ComponentEnd,
    topic: &str,
    options: PublishOptions,
    identity: &BusIdentity,
) -> Result<(), BusError> {
    let (source, cause) = (system.external_name(end), system.cycle_cause(end));
    let schema = system.output_schema(end);
    let sender = open(topic, source, schema, cause, options, identity)?;
    system.connect_output(end, sender, outer_topic(topic));
    Ok(())
}

/// Opens the way of the samples of an output to a topic. `source` is the name of its component outside.
pub(crate) fn open(
    topic: &str,
    source: Arc<str>,
    schema: &Schema,
    cause: Arc<CycleCause>,
    options: PublishOptions,
    identity: &BusIdentity,
) -> Result<Box<dyn AnySender>, BusError> {
    let origin = SenderId::new(source, identity.incarnation);
    let publisher = identity.bus.publisher(topic, &origin, schema, options)?;
    Ok(Box::new(BusSender { publisher, cause }))
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
