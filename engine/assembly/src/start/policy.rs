//! Converts connection policies of the plan to those of the engine.

use std::time::Duration;

use asmotion_component::{BufferKind, Policy};

use asmotion_composite::model;

pub(crate) fn of(connection: &asmotion_plan::Connection) -> Policy {
    let policy = &connection.policy;
    let size = usize::try_from(policy.size).unwrap_or(usize::MAX);
    Policy {
        kind: match policy.kind {
            model::ConnectionType::Data => BufferKind::Data,
            model::ConnectionType::Buffer => BufferKind::Buffer(size),
            model::ConnectionType::Circular => BufferKind::Circular(size),
        },
        lock: policy.lock,
        sharing: policy.buffer,
        queue: connection.queue.clone().unwrap_or_default(),
        init: policy.init,
        pull: policy.pull,
        max_threads: policy.max_threads.and_then(|max| usize::try_from(max).ok()),
        max_age: policy.max_age_ms.map(Duration::from_millis),
        on_stale: policy.on_stale,
        mandatory: policy.mandatory,
        trigger: policy.delivery == model::Delivery::Event,
    }
}
