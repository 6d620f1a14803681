//! What a subscription remembers of the messages that arrived: which they were, and when the oldest of those that may come again
//! were sent.
//!
//! The transit times of a stream show how long its messages wait. Those of a new stream, and of senders that give no time, can
//! only be bounded. A message that was in the queue when the subscription began to consume it again was sent after the last one
//! whose acknowledgement the broker has certainly read. A message that arrives while the broker's answers to the probes of the
//! connection are late may have waited since the last probe that was answered: in the broker, in a socket, or in this process
//! while it was stopped. That ends with the messages that were in the queue when the broker answered on the channel.

use std::time::{Duration, Instant};

use crate::duplicate_filter::DuplicateFilter;
use crate::wire::MessageIdentity;

/// Messages that may have waited, as long as the subscription lasts.
pub(crate) struct Arrivals {
    pub repeats: DuplicateFilter,
    /// Beginning of the subscription.
    origin: Instant,
    /// Time before which the last message was not sent.
    last: Instant,
    /// Time before which no message was sent whose acknowledgement may not have reached the broker.
    unconfirmed: Instant,
    /// Time of an acknowledgement, and the time before which no later message was sent.
    acknowledged: Option<(Instant, Instant)>,
    backlog: Backlog,
}

/// The next messages, which may have waited for an unknown time.
#[derive(Debug, Clone, Copy)]
struct Backlog {
    /// Time before which none of them was sent.
    since: Instant,
    /// Their number; `None` until it has been counted.
    left: Option<u64>,
}

impl Arrivals {
    /// Nothing has arrived since the subscription began.
    pub(crate) fn beginning_at(now: Instant) -> Self {
        let (since, left) = (now, Some(0));
        Self {
            repeats: DuplicateFilter::default(),
            origin: now,
            last: now,
            unconfirmed: now,
            acknowledged: None,
            backlog: Backlog { since, left },
        }
    }

    /// Called when the queue is consumed again, with the number of messages in it.
    pub(crate) fn begin_session(&mut self, backlog: u32, now: Instant) {
        if backlog == 0 {
            self.unconfirmed = now;
        }
        self.acknowledged = None;
        self.backlog = Backlog {
            since: self.unconfirmed,
            left: Some(backlog.into()),
        };
    }

    /// Records that the messages so far have been acknowledged.
    pub(crate) fn record_acknowledgement(&mut self, now: Instant) {
        self.acknowledged.get_or_insert((now, self.last));
    }

    /// Called before messages are judged, with the time at which the last answered probe was sent. Returns whether that is
    /// longer ago than `limit`, so that an unknown number of messages may have waited: then they have to be counted, after which
    /// [`limit_backlog`](Self::limit_backlog) is called.
    pub(crate) fn compare_with_probe(
        &mut self,
        answered_probe: Instant,
        limit: Duration,
        now: Instant,
    ) -> bool {
        if let Some((at, last)) = self.acknowledged
            && at <= answered_probe
        {
            self.unconfirmed = last;
            self.acknowledged = None;
        }
        if now.duration_since(answered_probe) <= limit || self.backlog.left.is_none() {
            return false;
        }
        let since = if self.backlog.left == Some(0) {
            answered_probe
        } else {
            self.backlog.since.min(answered_probe)
        };
        self.backlog = Backlog { since, left: None };
        true
    }

    /// Called with the number of the next messages that may have waited.
    pub(crate) fn limit_backlog(&mut self, count: u64) {
        self.backlog.left = Some(count);
    }

    /// Returns how long the next message, sent at `sent` by its sender's clock, has waited on its way. For one whose stream or
    /// sender does not show it, that is the longest possible time.
    pub(crate) fn waited(
        &mut self,
        identity: &MessageIdentity,
        sent: Option<u64>,
        now: Instant,
    ) -> Duration {
        let is_in_backlog = self.backlog.left != Some(0);
        self.backlog.left = self.backlog.left.map(|left| left.saturating_sub(1));
        let waited = match (sent, self.repeats.transit(identity)) {
            (Some(sent), Some(transit)) if transit.is_known() || !is_in_backlog => {
                transit.waited(sent, self.origin, now)
            }
            (Some(_) | None, Some(_) | None) if is_in_backlog => {
                now.duration_since(self.backlog.since)
            }
            (Some(_) | None, Some(_) | None) => Duration::ZERO,
        };
        self.last = now.checked_sub(waited).unwrap_or(self.origin);
        waited
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::StreamId;

    const LIMIT: Duration = Duration::from_millis(500);

    /// A subscription, and times in ms since its beginning.
    struct Subscription {
        arrivals: Arrivals,
        origin: Instant,
    }

    impl Subscription {
        fn new() -> Self {
            let origin = Instant::now();
            let arrivals = Arrivals::beginning_at(origin);
            Self { arrivals, origin }
        }

        fn at(&self, ms: u64) -> Instant {
            self.origin + Duration::from_millis(ms)
        }

        /// Compares with the probe that was sent at `probe`.
        fn compare(&mut self, probe: u64, now: u64) -> bool {
            let (probe, now) = (self.at(probe), self.at(now));
            self.arrivals.compare_with_probe(probe, LIMIT, now)
        }

        /// The longest possible wait in ms of a message without identity that arrives now.
        fn unmarked(&mut self, now: u64) -> u128 {
            let now = self.at(now);
            let waited = self.arrivals.waited(&MessageIdentity::Unknown, None, now);
            waited.as_millis()
        }

        fn numbered(&mut self, sequence: u64, sent: u64, now: u64) -> u128 {
            let name = "s".to_owned();
            let user = "robot".to_owned();
            let stream = StreamId { user, name };
            let identity = MessageIdentity::Numbered { stream, sequence };
            assert!(self.arrivals.repeats.is_new(&identity));
            let (sent, now) = (sent * 1_000_000, self.at(now));
            self.arrivals.waited(&identity, Some(sent), now).as_millis()
        }
    }

    #[test]
    fn messages_after_late_answers_may_have_waited_until_they_are_counted() {
        let mut it = Subscription::new();
        assert!(!it.compare(250, 700));
        assert_eq!(it.unmarked(700), 0);
        // the process was stopped until 5000
        assert!(it.compare(750, 5000));
        assert_eq!((it.unmarked(5000), it.unmarked(5001)), (4250, 4251));
        // asked for once; the answer to a probe does not end it
        assert!(!it.compare(750, 5002) && !it.compare(5001, 5003));
        assert_eq!(it.unmarked(5003), 4253);
        it.arrivals.limit_backlog(2);
        assert_eq!(it.unmarked(5004), 4254);
        // stopped again before the last one
        assert!(it.compare(5001, 7000));
        it.arrivals.limit_backlog(1);
        assert_eq!((it.unmarked(7000), it.unmarked(7000)), (6250, 0));
    }

    #[test]
    fn a_stream_that_is_known_shows_its_own_times() {
        let mut it = Subscription::new();
        assert_eq!(it.numbered(1, 100, 105), 0);
        assert!(it.compare(100, 5000));
        assert_eq!((it.numbered(2, 200, 5000), it.unmarked(5000)), (4794, 4900));
        assert_eq!(it.numbered(3, 4995, 5000), 0);
    }

    #[test]
    fn messages_that_come_again_are_as_old_as_the_last_that_cannot() {
        let mut it = Subscription::new();
        assert!(!it.compare(0, 100));
        assert_eq!(it.unmarked(100), 0);
        let acknowledged = it.at(101);
        it.arrivals.record_acknowledgement(acknowledged);
        // sent after the acknowledgement, which the broker has therefore read
        assert!(!it.compare(250, 300));
        assert_eq!(it.unmarked(300), 0);
        let acknowledged = it.at(301);
        it.arrivals.record_acknowledgement(acknowledged);
        // the link is lost twice; the last message may come again each time
        for session in [9000, 10_000] {
            let begun = it.at(session);
            it.arrivals.begin_session(3, begun);
            assert_eq!(it.unmarked(session), u128::from(session) - 100);
        }
        // a queue that was empty
        let begun = it.at(11_000);
        it.arrivals.begin_session(0, begun);
        assert_eq!(it.unmarked(11_001), 0);
        let begun = it.at(12_000);
        it.arrivals.begin_session(1, begun);
        assert_eq!((it.unmarked(12_001), it.unmarked(12_001)), (1001, 0));
    }
}
