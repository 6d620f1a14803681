//! How topics are sent over a bus: as the connections at both ends want what they carry.

use std::num::NonZeroUsize;

use bus::{Assurance, Outage, Sending};
use component::Kind;

use super::{Part, policy};
use crate::plan::{End, Plan, Terminal};

/// How each topic that this part writes to is sent.
pub(super) fn of_topics<'p>(
    plan: &'p Plan,
    part: &'p Part,
) -> impl Iterator<Item = (&'p str, Sending)> {
    let written = plan.topics.iter().filter(|topic| {
        let mut publishers = topic.publishers.iter();
        publishers.any(|end| part.has(&end.component))
    });
    written.map(|topic| {
        let joins = |terminal: &Terminal| match terminal {
            Terminal::Topic(name) => *name == topic.name,
            Terminal::Port(_) => false,
        };
        let connections = plan.connections.iter();
        let connections = connections.filter(|it| joins(&it.from) || joins(&it.to));
        let kinds = connections.map(|connection| policy(&connection.policy).kind);
        (topic.name.as_str(), of(kinds))
    })
}

/// How a port is sent that others are connected to.
pub(super) fn of_port(plan: &Plan, port: &End) -> Sending {
    let from = plan.connections.iter().filter(|connection| {
        let to_port = matches!(connection.to, Terminal::Port(_));
        to_port && connection.from == Terminal::Port(port.clone())
    });
    of(from.map(|connection| policy(&connection.policy).kind))
}

/// A state is sent again and again, and the newest counts. Messages of a sequence are confirmed; while the bus is away as
/// many are kept as a buffer holds, or, where the oldest would be dropped in any case, the newest.
fn of(kinds: impl IntoIterator<Item = Kind>) -> Sending {
    let mut kinds = kinds.into_iter().peekable();
    // ports on a topic by themselves keep a sequence
    let mut state = kinds.peek().is_some();
    let mut buffer = None;
    for kind in kinds {
        match kind {
            Kind::Data => {}
            Kind::Circular(_) => state = false,
            Kind::Buffer(size) => buffer = buffer.max(NonZeroUsize::new(size)),
        }
    }
    match buffer {
        Some(size) => Sending::events(size),
        None if state => Sending::state(),
        None => Sending {
            assurance: Assurance::Confirmed,
            outage: Outage::KeepLatest,
            ..Sending::default()
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_sent_once_and_a_sequence_confirmed() {
        assert_eq!(of([Kind::Data, Kind::Data]), Sending::state());
        let buffer = of([Kind::Data, Kind::Buffer(8), Kind::Buffer(32)]);
        assert_eq!(buffer.outage, Outage::Queue(NonZeroUsize::new(32).unwrap()));
        for sequence in [of([]), of([Kind::Data, Kind::Circular(4)])] {
            assert_eq!(sequence.assurance, Assurance::Confirmed);
            assert_eq!(sequence.outage, Outage::KeepLatest);
        }
    }
}
