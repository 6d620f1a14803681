//! Events that wait for the following steps.

use asmotion_component::{BufferKind, Time};
use asmotion_lang::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Capacity for messages whose connections have no queue of their own, and for outcomes of calls; when full, the oldest is
/// dropped.
const DEFAULT_SIZE: usize = 256;

/// The events of a location in order of arrival: messages, and outcomes of calls. Neither takes the other's place.
#[derive(Debug, Default)]
pub(crate) struct EventQueue {
    events: VecDeque<WaitingEvent>,
    /// Number of messages among the events.
    messages: usize,
}

/// Identifies a message among those of a port or an operation: several functions can be bound to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Arrival {
    /// Time of the cycle in which it arrived.
    pub at: Time,
    /// Position among the messages of this cycle.
    pub position: usize,
}

/// The source of an event that waits for a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum EventSource {
    Message(Arrival),
    /// The outcome of a call that an update of the out location at this position made.
    Outcome(usize),
}

/// An event that waits for a step.
#[derive(Clone, Debug)]
pub(crate) struct WaitingEvent {
    pub source: EventSource,
    pub value: Value,
    /// The last time at which the connection of a message allows its use; `None` without a limit.
    pub expiry: Option<Time>,
}

impl EventQueue {
    /// Queues a message. Returns the message that was dropped for it, according to the queue of the input's connections.
    pub fn push_message(
        &mut self,
        value: Value,
        arrival: Arrival,
        expiry: Option<Time>,
        queue: BufferKind,
    ) -> Option<Arrival> {
        let (size, drops_newest) = match queue {
            BufferKind::Data => (DEFAULT_SIZE, false),
            BufferKind::Buffer(size) => (size, true),
            BufferKind::Circular(size) => (size, false),
        };
        let is_full = self.messages >= size.max(1);
        if is_full && drops_newest {
            return Some(arrival);
        }
        self.events.push_back(WaitingEvent {
            source: EventSource::Message(arrival),
            value,
            expiry,
        });
        self.messages += 1;
        let dropped = is_full.then(|| self.remove_first(WaitingEvent::is_message));
        dropped.flatten()?.arrival()
    }

    /// Queues the outcome of a call that an update of the out location at this position made. Returns how many outcomes were
    /// dropped.
    pub fn push_outcome(&mut self, output: usize, value: Value) -> u64 {
        let is_full = self.events.len() - self.messages >= DEFAULT_SIZE;
        self.events.push_back(WaitingEvent {
            source: EventSource::Outcome(output),
            value,
            expiry: None,
        });
        if is_full {
            self.remove_first(|event| !event.is_message());
        }
        u64::from(is_full)
    }

    fn remove_first(&mut self, is_one: fn(&WaitingEvent) -> bool) -> Option<WaitingEvent> {
        let found = self.events.iter().position(is_one);
        let removed = found.and_then(|position| self.events.remove(position));
        self.count_removed(removed.as_ref());
        removed
    }

    fn count_removed(&mut self, removed: Option<&WaitingEvent>) {
        self.messages -= usize::from(removed.is_some_and(WaitingEvent::is_message));
    }

    /// Removes the next event.
    pub fn pop(&mut self) -> Option<Value> {
        let next = self.events.pop_front();
        self.count_removed(next.as_ref());
        next.map(|event| event.value)
    }

    /// Removes the messages that are too old, and adds them to `removed`.
    pub fn remove_expired(&mut self, now: Time, removed: &mut Vec<Arrival>) {
        let before = self.events.len();
        self.events.retain(|event| {
            let stays = event.expiry.is_none_or(|expiry| now <= expiry);
            if !stays {
                removed.extend(event.arrival());
            }
            stays
        });
        // outcomes do not expire
        self.messages -= before - self.events.len();
    }

    /// Removes the outcomes of calls that updates of the out location at this position made.
    pub fn remove_outcomes(&mut self, output: usize) {
        self.events
            .retain(|event| event.source != EventSource::Outcome(output));
    }

    /// Removes all messages. Returns their number.
    pub fn remove_messages(&mut self) -> u64 {
        self.events.retain(|event| !event.is_message());
        std::mem::take(&mut self.messages) as u64
    }

    pub fn len(&self) -> usize {
        self.events.len()
    }

    /// Returns the number of messages.
    pub fn messages(&self) -> usize {
        self.messages
    }

    /// Returns the number of outcomes of calls.
    pub fn outcomes(&self) -> usize {
        self.events.len() - self.messages
    }

    pub fn is_empty(&self) -> bool {
        self.events.is_empty()
    }

    pub fn iter(&self) -> impl Iterator<Item = &WaitingEvent> {
        self.events.iter()
    }
}

impl WaitingEvent {
    pub fn is_message(&self) -> bool {
        self.arrival().is_some()
    }

    fn arrival(&self) -> Option<Arrival> {
        match self.source {
            EventSource::Message(arrival) => Some(arrival),
            EventSource::Outcome(_) => None,
        }
    }
}

impl FromIterator<WaitingEvent> for EventQueue {
    fn from_iter<I: IntoIterator<Item = WaitingEvent>>(events: I) -> Self {
        let events = VecDeque::from_iter(events);
        let messages = events.iter().filter(|event| event.is_message()).count();
        Self { events, messages }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn arrival(position: i64) -> Arrival {
        let (at, position) = (Time::ZERO, position as usize);
        Arrival { at, position }
    }

    fn pushed(queue: BufferKind) -> (Vec<i64>, u64) {
        let (mut events, mut dropped) = (EventQueue::default(), 0);
        dropped += events.push_outcome(0, Value::Int(100));
        for number in 0..4 {
            let message = events.push_message(Value::Int(number), arrival(number), None, queue);
            dropped += u64::from(message.is_some());
        }
        let number = |value: Value| {
            if let Value::Int(number) = value {
                number
            } else {
                -1
            }
        };
        let all = std::iter::from_fn(|| events.pop().map(number)).collect();
        assert_eq!(events.messages, 0);
        (all, dropped)
    }

    #[test]
    fn the_kind_of_the_queue_decides_which_message_is_dropped_and_never_an_outcome() {
        assert_eq!(pushed(BufferKind::Data), (vec![100, 0, 1, 2, 3], 0));
        assert_eq!(pushed(BufferKind::Buffer(4)), (vec![100, 0, 1, 2, 3], 0));
        assert_eq!(pushed(BufferKind::Buffer(3)), (vec![100, 0, 1, 2], 1));
        assert_eq!(pushed(BufferKind::Circular(3)), (vec![100, 1, 2, 3], 1));
    }

    #[test]
    fn messages_expire_and_outcomes_do_not() {
        let mut events = EventQueue::default();
        let at = |ms| Some(Time::ZERO + Duration::from_millis(ms));
        for (number, expiry) in [(1, at(10)), (2, None), (3, at(30)), (4, at(20))] {
            let arrival = arrival(number);
            events.push_message(Value::Int(number), arrival, expiry, BufferKind::Buffer(4));
        }
        events.push_outcome(0, Value::Int(5));
        let now = Time::ZERO + Duration::from_millis(20);
        let mut expired = Vec::new();
        events.remove_expired(now, &mut expired);
        assert_eq!((&*expired, events.messages), (&[arrival(1)][..], 3));
        let later = Time::ZERO + Duration::from_millis(21);
        events.remove_expired(later, &mut expired);
        assert_eq!(expired, [arrival(1), arrival(4)]);
        assert_eq!(events.messages, 2);
        let left: Vec<_> = std::iter::from_fn(|| events.pop()).collect();
        assert_eq!(left, [Value::Int(2), Value::Int(3), Value::Int(5)]);
    }

    #[test]
    fn messages_never_drop_outcomes_nor_outcomes_messages() {
        let mut events = EventQueue::default();
        let message = events.push_message(Value::Int(0), arrival(0), None, BufferKind::Buffer(1));
        let outcomes: u64 = (0..300)
            .map(|n| events.push_outcome(1, Value::Int(n)))
            .sum();
        assert_eq!((message, outcomes), (None, 300 - DEFAULT_SIZE as u64));
        assert_eq!(
            (events.outcomes(), events.remove_messages()),
            (DEFAULT_SIZE, 1)
        );
        events.remove_outcomes(1);
        assert!(events.is_empty());
    }
}
