//! What a subscription remembers of the messages that arrived: which they were, and when the oldest of those that may come again
//! were sent.
//!
//! The transit times of a stream show how long its messages wait. Those of a new stream, and of senders that give no time, can
//! only be bounded. A message that was in the queue when the subscription began to consume it again was sent after the last one
//! whose acknowledgement the broker has certainly read. A message that arrives while the broker's answers to the probes of the
//! connection are late may have waited since the last probe that was answered: in the broker, in a socket, or in this process
//! while it was stopped. That ends with the messages that were in the queue when the broker answered on the channel. The late
//! answer itself can overtake messages on their way through the client, so they are counted once more when it has come.

use std::time::{Duration, Instant};

use crate::duplicate_filter::DuplicateFilter;
use crate::link::ProbeAnswers;
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
    /// The answers that the last message was compared with.
    answers: ProbeAnswers,
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
            answers: ProbeAnswers::beginning_at(now),
            backlog: Backlog { since, left },
        }
    }

    /// Called when the queue is consumed again, with the number of messages in it and the answers on its connection so far.
    pub(crate) fn begin_session(&mut self, backlog: u32, answers: ProbeAnswers, now: Instant) {
        self.answers = answers;
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

    /// Called before messages are judged, and after a silence. Returns whether answers are, or were, late by `limit`, so that an
    /// unknown number of messages may have waited: then they have to be counted from now on, after which
    /// [`limit_backlog`](Self::limit_backlog) is called.
    pub(crate) fn compare_with_answers(
        &mut self,
        answers: ProbeAnswers,
        limit: Duration,
        now: Instant,
    ) -> bool {
        let before = std::mem::replace(&mut self.answers, answers);
        if let Some((at, last)) = self.acknowledged
            && at <= answers.last
        {
            self.unconfirmed = last;
            self.acknowledged = None;
        }
        let ended = match answers.silences.saturating_sub(before.silences) {
            0 => None,
            1 => Some(answers.before_silence),
            _ => Some(answers.before_silence.min(before.last)),
        };
        let lasting = (now.duration_since(answers.last) > limit).then_some(answers.last);
        let since = match (ended, lasting) {
            (Some(ended), _) => ended,
            (None, Some(lasting)) if self.backlog.left.is_some() => lasting,
            (None, _) => return false,
        };
        let since = if self.backlog.left == Some(0) {
            since
        } else {
            self.backlog.since.min(since)
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

        /// Compares with the answer to the probe that was sent at `probe`, which came just now or long ago.
        fn compare(&mut self, probe: u64, now: u64) -> bool {
            let (probe, now) = (self.at(probe), self.at(now));
            let last = probe;
            let answers = ProbeAnswers {
                last,
                ..self.arrivals.answers
            };
            self.arrivals.compare_with_answers(answers, LIMIT, now)
        }

        /// Compares with the answer to the probe that was sent at `probe` and has just come, after a silence.
        fn compare_after_silence(&mut self, probe: u64, now: u64) -> bool {
            let (probe, now) = (self.at(probe), self.at(now));
            let mut answers = self.arrivals.answers;
            assert!(answers.record(probe, LIMIT, now));
            self.arrivals.compare_with_answers(answers, LIMIT, now)
        }

        fn begin_session(&mut self, backlog: u32, at: u64) {
            let (answers, begun) = (self.arrivals.answers, self.at(at));
            self.arrivals.begin_session(backlog, answers, begun);
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
    fn an_answer_that_overtakes_messages_makes_them_no_younger() {
        let mut it = Subscription::new();
        assert!(!it.compare(250, 300));
        assert_eq!(it.unmarked(300), 0);
        // the process was stopped until 5000; the answers to two probes have come when the first of the waiting messages does
        assert!(it.compare_after_silence(5001, 5003));
        assert!(!it.compare(5100, 5110));
        assert_eq!(it.unmarked(5110), 4860);
        it.arrivals.limit_backlog(1);
        assert_eq!((it.unmarked(5111), it.unmarked(5111)), (4861, 0));
        // it was silent before the answer as well: the messages are counted again, because the broker may have counted too early
        assert!(it.compare(5100, 9000));
        it.arrivals.limit_backlog(0);
        assert!(it.compare_after_silence(9001, 9003));
        assert_eq!(it.unmarked(9004), 3904);
        // nothing had waited
        it.arrivals.limit_backlog(0);
        assert_eq!(it.unmarked(9500), 0);
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
            it.begin_session(3, session);
            assert_eq!(it.unmarked(session), u128::from(session) - 100);
        }
        // a queue that was empty
        it.begin_session(0, 11_000);
        assert_eq!(it.unmarked(11_001), 0);
        it.begin_session(1, 12_000);
        assert_eq!((it.unmarked(12_001), it.unmarked(12_001)), (1001, 0));
    }
}
