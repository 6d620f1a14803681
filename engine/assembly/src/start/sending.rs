//! Publish options of topics sent over a bus, derived from the connections at both ends.

use std::num::NonZeroUsize;
use std::time::Duration;

use asmotion_bus::{Assurance, Outage, PublishOptions};
use asmotion_component::BufferKind;
use asmotion_datum::Codec;

use super::policy;
use asmotion_composite::model::{self, PlannedSending};
use asmotion_plan::{Connection, End, Part, Plan, Terminal};

/// Returns the options of the topics published by this part.
pub(crate) fn of_topics<'p>(
    plan: &'p Plan,
    part: &'p Part,
) -> impl Iterator<Item = (&'p str, PublishOptions)> {
    let written = plan.topics.iter().filter(|topic| {
        let mut publishers = topic.publishers.iter();
        publishers.any(|end| part.has(&end.component))
    });
    written.map(|topic| {
        let end = Terminal::Topic(topic.name.clone());
        let read = plan.connections.from_end(&end);
        let connections = plan.connections.to_end(&end).chain(read);
        let publisher = topic.publishers.iter().find(|end| part.has(&end.component));
        let limits = topic.subscribers.iter().map(|reader| {
            let mut read = plan.connections.to_end(&Terminal::Port(reader.clone()));
            read.find(|it| it.from == end).and_then(age_limit)
        });
        let sending = of_connections(plan, connections.clone(), publisher).max_age(longest(limits));
        (topic.name.as_str(), as_written(&topic.sending, sending))
    })
}

/// Returns the options of a port with direct connections to other parts.
pub(crate) fn of_port(plan: &Plan, port: &End) -> PublishOptions {
    let end = Terminal::Port(port.clone());
    let from = plan.connections.from_end(&end);
    let from = from.filter(|connection| matches!(connection.to, Terminal::Port(_)));
    let limits = from.clone().map(age_limit);
    of_connections(plan, from, Some(port)).max_age(longest(limits))
}

/// Returns the age beyond which the reader of a connection does not use a sample, if there is one. A reader that holds stale
/// samples uses each of them.
fn age_limit(connection: &Connection) -> Option<Duration> {
    policy::of(connection).discarded_after()
}

/// Returns the age beyond which no reader uses a sample; `None` if one uses it at any age, or if there is no reader.
fn longest(limits: impl Iterator<Item = Option<Duration>>) -> Option<Duration> {
    let limits: Option<Vec<Duration>> = limits.collect();
    limits?.into_iter().max()
}

/// Derives the options from a set of connections.
fn of_connections<'p>(
    plan: &Plan,
    connections: impl Iterator<Item = &'p Connection> + Clone,
    publisher: Option<&End>,
) -> PublishOptions {
    let init = connections.clone().any(|connection| connection.policy.init);
    let kinds = connections.map(|connection| policy::of(connection).kind);
    of(kinds).init(init).with_codec(codec(plan, publisher))
}

/// Returns the codec of the publisher's broker.
fn codec(plan: &Plan, publisher: Option<&End>) -> Codec {
    let name = publisher.and_then(|end| plan.broker_of(&end.component));
    let broker = plan.brokers.iter().find(|it| Some(&*it.name) == name);
    broker.map_or_else(Codec::default, |broker| broker.codec)
}

/// Overrides derived options with the settings of the topic.
fn as_written(topic: &PlannedSending, mut sending: PublishOptions) -> PublishOptions {
    sending.assurance = match topic.confirm {
        None => sending.assurance,
        Some(true) => Assurance::Confirmed,
        Some(false) => Assurance::Once,
    };
    let size = topic.size.and_then(|size| usize::try_from(size).ok());
    sending.outage = match (topic.outage, size.and_then(NonZeroUsize::new)) {
        (None, _) | (Some(model::Outage::Queue), None) => sending.outage,
        (Some(model::Outage::Drop), _) => Outage::Drop,
        (Some(model::Outage::Latest), _) => Outage::KeepLatest,
        (Some(model::Outage::Queue), Some(size)) => Outage::Queue(size),
    };
    match topic.codec {
        None => sending,
        Some(codec) => sending.with_codec(codec),
    }
}

/// Derives the options from the connection types.
///
/// A last value is sent repeatedly, so an unconfirmed latest message suffices. Queued messages are confirmed; during an
/// outage as many messages are kept as the queue holds, or only the newest if the queue overwrites the oldest anyway.
fn of(kinds: impl IntoIterator<Item = BufferKind>) -> PublishOptions {
    let mut kinds = kinds.into_iter().peekable();
    // ports on a topic without an explicit connection use a queue
    let mut state = kinds.peek().is_some();
    let mut buffer = None;
    for kind in kinds {
        match kind {
            BufferKind::Data => {}
            BufferKind::Circular(_) => state = false,
            BufferKind::Buffer(size) => buffer = buffer.max(NonZeroUsize::new(size)),
        }
    }
    match buffer {
        Some(size) => PublishOptions::events(size),
        None if state => PublishOptions::state(),
        None => PublishOptions {
            assurance: Assurance::Confirmed,
            outage: Outage::KeepLatest,
            ..PublishOptions::default()
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_goes_before_what_follows() {
        let mut topic = PlannedSending {
            name: "event".to_owned(),
            confirm: None,
            outage: None,
            size: None,
            codec: None,
        };
        assert_eq!(
            as_written(&topic, PublishOptions::state()),
            PublishOptions::state()
        );
        topic.confirm = Some(true);
        topic.outage = Some(model::Outage::Queue);
        topic.size = Some(7);
        topic.codec = Some(Codec::Json);
        let seven = NonZeroUsize::new(7).unwrap();
        let wanted = PublishOptions::events(seven).with_codec(Codec::Json);
        assert_eq!(as_written(&topic, PublishOptions::state()), wanted);
        topic.outage = Some(model::Outage::Drop);
        assert_eq!(as_written(&topic, wanted).outage, Outage::Drop);
    }

    #[test]
    fn a_message_is_discarded_once_no_reader_uses_it() {
        let (short, long) = (
            Some(Duration::from_millis(200)),
            Some(Duration::from_millis(500)),
        );
        for (limits, expected) in [
            (vec![], None),
            (vec![short], short),
            (vec![short, long, short], long),
            (vec![short, None], None),
        ] {
            assert_eq!(longest(limits.into_iter()), expected);
        }
    }

    #[test]
    fn a_state_is_sent_once_and_a_sequence_confirmed() {
        assert_eq!(
            of([BufferKind::Data, BufferKind::Data]),
            PublishOptions::state()
        );
        let buffer = of([
            BufferKind::Data,
            BufferKind::Buffer(8),
            BufferKind::Buffer(32),
        ]);
        assert_eq!(buffer.outage, Outage::Queue(NonZeroUsize::new(32).unwrap()));
        for sequence in [of([]), of([BufferKind::Data, BufferKind::Circular(4)])] {
            assert_eq!(sequence.assurance, Assurance::Confirmed);
            assert_eq!(sequence.outage, Outage::KeepLatest);
        }
    }
}
