//! Events of a protocol, and which follow which.

use std::collections::BTreeSet;

/// An event of a protocol: an out function and the value that it sends.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SentEvent {
    /// Name of the out function.
    pub function: String,
    /// The value; empty if the message has none.
    pub value: String,
}

/// A message before an event.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PrecedingEvent {
    /// A message arrived, in the same step or before: the Boolean function that tells this.
    Received(String),
    /// The component sent an event.
    Sent(SentEvent),
}

/// Two events that follow each other: no other message is received or sent in between.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EventSuccession {
    /// The message before; `None` if there is none since the start.
    pub before: Option<PrecedingEvent>,
    /// The event that follows.
    pub after: SentEvent,
}

/// The events that a protocol can send, whatever the component receives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PossibleEvents {
    /// The events.
    pub events: BTreeSet<SentEvent>,
    /// Which can follow which.
    pub successions: BTreeSet<EventSuccession>,
}

/// The last messages after a step that sent these events.
pub(super) fn after_step(
    last: &BTreeSet<PrecedingEvent>,
    sent: BTreeSet<SentEvent>,
) -> BTreeSet<PrecedingEvent> {
    if sent.is_empty() {
        last.clone()
    } else {
        sent.into_iter().map(PrecedingEvent::Sent).collect()
    }
}

/// The successions of the events of a step, after the last messages.
pub(super) fn successions(
    last: &BTreeSet<PrecedingEvent>,
    sent: &BTreeSet<SentEvent>,
) -> Vec<EventSuccession> {
    let before: Vec<Option<PrecedingEvent>> = if last.is_empty() {
        vec![None]
    } else {
        last.iter().cloned().map(Some).collect()
    };
    let pairs = sent.iter().flat_map(|after| {
        let before = before.iter().cloned();
        before.map(|before| EventSuccession {
            before,
            after: after.clone(),
        })
    });
    pairs.collect()
}
