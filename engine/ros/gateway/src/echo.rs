//! Loop suppression: messages that a bridge has brought from a topic of ROS to a topic of the composite do not return to the same
//! topic of ROS through the bridge's own subscription. (The other way round, a node does not receive its own messages.)

use std::collections::VecDeque;

use asmotion_datum::Datum;

/// Messages that a bridge remembers of a topic; more than a queue between two of its cycles holds by default.
const REMEMBERED: usize = 256;

/// The messages that a bridge has written to a topic and not received again.
#[derive(Default)]
pub(crate) struct Echoes(VecDeque<Datum>);

impl Echoes {
    /// Notes a message that the bridge writes to the topic.
    pub(crate) fn written(&mut self, message: &Datum) {
        if self.0.len() == REMEMBERED {
            self.0.pop_front();
        }
        self.0.push_back(message.clone());
    }

    /// Returns whether a message that arrives on the topic is one that the bridge has written. Earlier ones are then forgotten:
    /// a topic keeps the order of a writer, so they have been dropped on the way.
    pub(crate) fn is_echo(&mut self, message: &Datum) -> bool {
        let Some(at) = self.0.iter().position(|written| written == message) else {
            return false;
        };
        self.0.drain(..=at);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_an_echo_once() {
        let mut echoes = Echoes::default();
        for value in [1, 2, 3] {
            echoes.written(&Datum::Int(value));
        }
        let echo = |value| (value, echoes.is_echo(&Datum::Int(value)));
        // 1 was dropped on the way; 7 is from another writer
        let found: Vec<_> = [2, 7, 1, 3, 3].map(echo).into();
        assert_eq!(
            found,
            [(2, true), (7, false), (1, false), (3, true), (3, false)]
        );
    }

    #[test]
    fn few_messages_are_remembered() {
        let mut echoes = Echoes::default();
        for value in 0..10_000 {
            echoes.written(&Datum::Int(value));
        }
        assert_eq!(echoes.0.len(), REMEMBERED);
    }
}
