//! What is under way to a client: limited in time, so that a client that is frozen does not see the past when it continues.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::ticker::{TICK, interval_number};

/// Limit on requests for an acknowledgement that the client has not answered.
const MAX_UNANSWERED: usize = 2;
/// Shortest interval between such requests. An acknowledgement costs as much as half a message.
const INTERVAL: Duration = TICK.saturating_mul(6);

/// The numbers of the messages whose acknowledgement was asked for and has not arrived. After the second one nothing is sent, so that
/// what is under way was sent within two intervals.
#[derive(Default)]
pub(crate) struct UnderWay {
    unanswered: VecDeque<u64>,
    /// Number of the interval of the last request: all clients ask at the same time.
    asked: Option<u64>,
}

impl UnderWay {
    /// Returns whether another message may be sent.
    pub(crate) fn has_room(&self) -> bool {
        self.unanswered.len() < MAX_UNANSWERED
    }

    /// Returns whether the message with this number, which is sent now, has to ask for an acknowledgement.
    pub(crate) fn ask(&mut self, number: u64, now: Instant) -> bool {
        let interval = interval_number(INTERVAL, now);
        if self.asked == Some(interval) {
            return false;
        }
        self.asked = Some(interval);
        self.unanswered.push_back(number);
        true
    }

    /// The client has received the message with this number, which was sent, and so all before it. Returns whether that was news.
    pub(crate) fn acknowledge(&mut self, number: u64) -> bool {
        let before = self.unanswered.len();
        self.unanswered.retain(|asked| *asked > number);
        self.unanswered.len() < before
    }

    /// Returns whether an acknowledgement is awaited.
    pub(crate) fn is_awaited(&self) -> bool {
        !self.unanswered.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_that_answers_nothing_has_a_fifth_of_a_second_under_way() {
        let mut under_way = UnderWay::default();
        let begun = Instant::now();
        let mut sent = Vec::new();
        for number in 1..=50 {
            let now = begun + TICK * number;
            if under_way.has_room() {
                under_way.ask(number.into(), now);
                sent.push(u64::from(number));
            }
        }
        assert!(
            TICK * sent.len() as u32 <= Duration::from_millis(210),
            "{sent:?}"
        );
        assert!(!under_way.acknowledge(0) && !under_way.has_room());
        // the last one has asked
        assert!(under_way.acknowledge(*sent.last().unwrap()));
        assert!(under_way.has_room() && !under_way.is_awaited());
    }
}
