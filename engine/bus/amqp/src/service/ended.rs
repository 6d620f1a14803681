//! Requests that have ended, which a provider remembers so that it executes none of them again: limited in number, in bytes of
//! their replies, and in age.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Limit of remembered requests.
const REQUESTS: usize = 4096;
/// Limit of bytes of remembered replies.
const REPLY_BYTES: usize = 8 << 20;
/// Limit of the time for which a request is remembered. A caller sends a request again at most until its timeout.
const AGE: Duration = Duration::from_secs(600);

/// Ended requests, oldest first.
#[derive(Debug)]
pub(super) struct EndedRequests<Id> {
    requests: VecDeque<EndedRequest<Id>>,
    /// Size of the remembered replies.
    bytes: usize,
}

#[derive(Debug)]
struct EndedRequest<Id> {
    id: Id,
    /// Size of the remembered reply; zero if there is none.
    size: usize,
    /// Time at which the request is forgotten.
    until: Instant,
}

/// Remembered requests beyond the limits, to be forgotten when another one has ended.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Excess<Id> {
    /// The request to be forgotten.
    pub request: Option<Id>,
    /// Requests of which only the reply has to be forgotten.
    pub replies: Vec<Id>,
}

impl<Id> Default for EndedRequests<Id> {
    fn default() -> Self {
        Self {
            requests: VecDeque::new(),
            bytes: 0,
        }
    }
}

impl<Id: Clone> EndedRequests<Id> {
    /// Adds a request that has ended now, with a reply of this size. It is remembered until its deadline, if nothing exceeds the
    /// limits before. Returns what has to be forgotten.
    pub(super) fn add(
        &mut self,
        id: Id,
        size: usize,
        deadline: Instant,
        now: Instant,
    ) -> Excess<Id> {
        let until = deadline.min(now + AGE);
        self.requests.push_back(EndedRequest { id, size, until });
        self.bytes += size;
        let request = if self.requests.len() > REQUESTS {
            self.requests.pop_front()
        } else {
            None
        };
        let request = request.map(|oldest| {
            self.bytes -= oldest.size;
            oldest.id
        });
        let mut replies = Vec::new();
        for oldest in &mut self.requests {
            if self.bytes <= REPLY_BYTES {
                break;
            }
            if oldest.size > 0 {
                self.bytes -= std::mem::take(&mut oldest.size);
                replies.push(oldest.id.clone());
            }
        }
        Excess { request, replies }
    }

    /// Removes the requests whose time is over, and returns them.
    pub(super) fn take_expired(&mut self, now: Instant) -> Vec<Id> {
        let mut expired = Vec::new();
        let bytes = &mut self.bytes;
        self.requests.retain(|ended| {
            let is_kept = now < ended.until;
            if !is_kept {
                *bytes -= ended.size;
                expired.push(ended.id.clone());
            }
            is_kept
        });
        expired
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAY: Duration = Duration::from_secs(24 * 3600);

    fn nothing<Id>() -> Excess<Id> {
        Excess {
            request: None,
            replies: Vec::new(),
        }
    }

    #[test]
    fn the_oldest_replies_are_forgotten_beyond_a_number_of_bytes() {
        let (mut ended, now) = (EndedRequests::default(), Instant::now());
        let half = REPLY_BYTES / 2;
        for (id, size) in [(1, half), (2, 0), (3, half)] {
            assert_eq!(ended.add(id, size, now + DAY, now), nothing());
        }
        let replies = |excess: Excess<i32>| {
            assert_eq!(excess.request, None, "the request itself is remembered");
            excess.replies
        };
        assert_eq!(replies(ended.add(4, 1, now + DAY, now)), [1]);
        assert_eq!(replies(ended.add(5, half, now + DAY, now)), [3]);
        // one that is too large alone
        let large = replies(ended.add(6, REPLY_BYTES + 1, now + DAY, now));
        assert_eq!(large, [4, 5, 6]);
        assert_eq!(ended.bytes, 0);
    }

    #[test]
    fn the_oldest_request_is_forgotten_beyond_a_number_of_them() {
        let (mut ended, now) = (EndedRequests::default(), Instant::now());
        for id in 0..REQUESTS {
            assert_eq!(ended.add(id, 1, now + DAY, now), nothing());
        }
        let excess = ended.add(REQUESTS, 1, now + DAY, now);
        assert_eq!((excess.request, excess.replies), (Some(0), Vec::new()));
        assert_eq!((ended.requests.len(), ended.bytes), (REQUESTS, REQUESTS));
    }

    #[test]
    fn a_request_is_forgotten_at_its_deadline_and_a_day_long_one_before() {
        let (mut ended, now) = (EndedRequests::default(), Instant::now());
        let second = Duration::from_secs(1);
        for (id, deadline) in [(1, DAY), (2, second), (3, 2 * second)] {
            assert_eq!(ended.add(id, 10, now + deadline, now), nothing());
        }
        assert_eq!(ended.take_expired(now), [0; 0]);
        assert_eq!(ended.take_expired(now + second), [2]);
        assert_eq!(ended.take_expired(now + AGE), [1, 3]);
        assert_eq!(ended.bytes, 0);
    }
}
