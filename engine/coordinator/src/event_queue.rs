//! Events that wait for the following steps.

use asmotion_component::BufferKind;
use asmotion_lang::value::Value;
use std::collections::VecDeque;

/// Capacity for messages whose connections have no queue of their own, and for outcomes of calls; when full, the oldest is
/// dropped.
const DEFAULT_SIZE: usize = 256;

/// The events of a location in order of arrival: messages, and outcomes of calls. Neither takes the other's place.
#[derive(Debug, Default)]
pub(crate) struct EventQueue {
    /// Each event with the position of the out location whose call it reports on; `None` for a message.
    events: VecDeque<(Option<usize>, Value)>,
    /// Number of messages among the events.
    messages: usize,
}

impl EventQueue {
    /// Queues a message. Returns how many messages were dropped, according to the queue of the input's connections.
    pub fn push_message(&mut self, value: Value, queue: BufferKind) -> u64 {
        let (size, drops_newest) = match queue {
            BufferKind::Data => (DEFAULT_SIZE, false),
            BufferKind::Buffer(size) => (size, true),
            BufferKind::Circular(size) => (size, false),
        };
        let is_full = self.messages >= size.max(1);
        if is_full && drops_newest {
            return 1;
        }
        self.events.push_back((None, value));
        self.messages += 1;
        if is_full {
            self.remove_first(Option::is_none);
        }
        u64::from(is_full)
    }

    /// Queues the outcome of a call that an update of the out location at this position made. Returns how many outcomes were
    /// dropped.
    pub fn push_outcome(&mut self, output: usize, value: Value) -> u64 {
        let is_full = self.events.len() - self.messages >= DEFAULT_SIZE;
        self.events.push_back((Some(output), value));
        if is_full {
            self.remove_first(Option::is_some);
        }
        u64::from(is_full)
    }

    fn remove_first(&mut self, is_one: fn(&Option<usize>) -> bool) {
        let found = self.events.iter().position(|(output, _)| is_one(output));
        let removed = found.and_then(|position| self.events.remove(position));
        self.count_removed(&removed);
    }

    fn count_removed(&mut self, removed: &Option<(Option<usize>, Value)>) {
        if let Some((None, _)) = removed {
            self.messages -= 1;
        }
    }

    /// Removes the next event.
    pub fn pop(&mut self) -> Option<Value> {
        let next = self.events.pop_front();
        self.count_removed(&next);
        next.map(|(_, value)| value)
    }

    /// Removes the outcomes of calls that updates of the out location at this position made.
    pub fn remove_outcomes(&mut self, output: usize) {
        self.events.retain(|(of, _)| *of != Some(output));
    }

    /// Removes all messages. Returns their number.
    pub fn remove_messages(&mut self) -> u64 {
        self.events.retain(|(of, _)| of.is_some());
        std::mem::take(&mut self.messages) as u64
    }

    pub fn len(&self) -> usize {
        self.events.len()
    }

    pub fn is_empty(&self) -> bool {
        self.events.is_empty()
    }

    pub fn iter(&self) -> impl Iterator<Item = &(Option<usize>, Value)> {
        self.events.iter()
    }
}

impl FromIterator<(Option<usize>, Value)> for EventQueue {
    fn from_iter<I: IntoIterator<Item = (Option<usize>, Value)>>(events: I) -> Self {
        let events = VecDeque::from_iter(events);
        let messages = events.iter().filter(|(of, _)| of.is_none()).count();
        Self { events, messages }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pushed(queue: BufferKind) -> (Vec<i64>, u64) {
        let (mut events, mut dropped) = (EventQueue::default(), 0);
        dropped += events.push_outcome(0, Value::Int(100));
        for number in 0..4 {
            dropped += events.push_message(Value::Int(number), queue);
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
    fn messages_never_drop_outcomes_nor_outcomes_messages() {
        let mut events = EventQueue::default();
        let message = events.push_message(Value::Int(0), BufferKind::Buffer(1));
        let outcomes: u64 = (0..300)
            .map(|n| events.push_outcome(1, Value::Int(n)))
            .sum();
        assert_eq!((message, outcomes), (0, 300 - DEFAULT_SIZE as u64));
        assert_eq!(
            (events.len(), events.remove_messages()),
            (DEFAULT_SIZE + 1, 1)
        );
        events.remove_outcomes(1);
        assert!(events.is_empty());
    }
}
