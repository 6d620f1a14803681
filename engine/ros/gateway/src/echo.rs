//! Loop suppression: messages that a bridge has brought from a topic of ROS to a topic of the composite do not return to the same
//! topic of ROS through the bridge's own subscription. (The other way round, a node does not receive its own messages.)

use std::collections::VecDeque;

use asmotion_datum::Datum;

/// Messages that a bridge remembers of a topic; more than a queue between two of its cycles holds by default.
const REMEMBERED: usize = 256;

/// A message that a bridge has written to a topic and not received again.
struct Written {
    message: Datum,
    /// A later message has been received before it.
    is_passed: bool,
}

/// The messages that a bridge has written to a topic and not received again.
#[derive(Default)]
pub(crate) struct Echoes(VecDeque<Written>);

impl Echoes {
    /// Notes a message that the bridge writes to the topic.
    pub(crate) fn written(&mut self, message: &Datum) {
        if self.0.len() == REMEMBERED {
            self.0.pop_front();
        }
        self.0.push_back(Written {
            message: message.clone(),
            is_passed: false,
        });
    }

    /// Returns whether a message that arrives on the topic is one that the bridge has written.
    ///
    /// A topic keeps the order of a writer, so earlier ones have been dropped on the way, unless another writer has sent an equal
    /// message. Therefore they are forgotten when they are passed for the second time.
    pub(crate) fn is_echo(&mut self, message: &Datum) -> bool {
        let Some(at) = self.0.iter().position(|it| it.message == *message) else {
            return false;
        };
        self.0.remove(at);
        let mut index = 0;
        self.0.retain_mut(|earlier| {
            let is_earlier = index < at;
            index += 1;
            !is_earlier || !std::mem::replace(&mut earlier.is_passed, true)
        });
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
        // 1 was dropped on the way; 7 and the second 3 are from another writer
        let found: Vec<_> = [2, 7, 3, 1, 3].map(echo).into();
        assert_eq!(
            found,
            [(2, true), (7, false), (3, true), (1, false), (3, false)]
        );
    }

    /// Of two writers that write `pong`, the second message counts as that of the other one.
    #[test]
    fn an_equal_message_of_another_writer_is_an_echo_in_place_of_the_later_one() {
        let mut echoes = Echoes::default();
        for word in ["last", "pong"] {
            echoes.written(&Datum::text(word));
        }
        let found = ["pong", "last", "pong"].map(|word| echoes.is_echo(&Datum::text(word)));
        assert_eq!(found, [true, true, false]);
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
