//! Connects ports to Orocos components over POSIX message queues.

use std::time::Duration;

use asmotion_component::Policy;
use asmotion_component::declaration::{Declaration, PortDeclaration};
use asmotion_mqueue::{
    FullQueuePolicy, QueueCapacity, QueueLayout, QueueName, QueueReader, QueueWriter,
};
use asmotion_runtime::System;

use super::StartError;
use asmotion_composite::model::ConnectionType;

/// Connects an output port to a queue.
pub(super) fn to(
    system: &mut System,
    from: &asmotion_plan::End,
    queue: &str,
    policy: &asmotion_plan::Policy,
) -> Result<(), StartError> {
    let layout = layout(system, from, Declaration::output)?;
    let number = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
    let (keep, messages) = match policy.kind {
        ConnectionType::Data => (FullQueuePolicy::Last, 1),
        ConnectionType::Buffer => (FullQueuePolicy::Oldest, number(policy.size)),
        ConnectionType::Circular => (FullQueuePolicy::Newest, number(policy.size)),
    };
    let size = layout.size_or(policy.data_size.map_or(0, number));
    let capacity = QueueCapacity { messages, size };
    let writer =
        QueueName::new(queue).and_then(|name| QueueWriter::open(name, layout, capacity, keep));
    let writer = writer.map_err(|error| refused(from, error))?;
    let writer = writer.max_age(policy.max_age_ms.map(Duration::from_millis));
    Ok(system.connect_sink(&from.to_string(), Box::new(writer))?)
}

/// Connects an input port to a queue.
pub(super) fn from(
    system: &mut System,
    queue: &str,
    to: &asmotion_plan::End,
    policy: &Policy,
) -> Result<(), StartError> {
    let layout = layout(system, to, Declaration::input)?;
    let name = QueueName::new(queue).map_err(|error| refused(to, error))?;
    let reader = QueueReader::new(name, layout).claimed();
    let reader = reader.map_err(|error| refused(to, error))?;
    let reader = reader.max_age(policy.max_age);
    Ok(system.connect_source(Box::new(reader), &to.to_string(), policy)?)
}

fn layout(
    system: &System,
    end: &asmotion_plan::End,
    port: impl for<'d> Fn(&'d Declaration, &str) -> Option<&'d PortDeclaration>,
) -> Result<QueueLayout, StartError> {
    let declared = system.id(&end.component);
    let declared = declared.and_then(|id| system.declaration(id));
    let port = declared.and_then(|declared| port(declared, &end.name));
    let port = port.ok_or_else(|| refused(end, "port not found"))?;
    QueueLayout::of(&port.schema).map_err(|error| refused(end, error))
}

fn refused(end: &asmotion_plan::End, reason: impl ToString) -> StartError {
    StartError::Queue {
        port: end.to_string(),
        reason: reason.to_string(),
    }
}
