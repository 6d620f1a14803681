//! Lateness of requests, estimated without trust in the clocks of two machines.

use std::collections::HashMap;
use std::time::Duration;

use amqprs::BasicProperties;
use asmotion_bus::SenderId;

use crate::wire;

/// Limit of remembered callers.
const CALLERS: usize = 1024;

/// Estimates which requests may have been given up by their callers.
///
/// A request can wait in the socket of a broker that does not read, where no expiration counts. It carries the instant at
/// which its caller gives up, by the caller's clock; that clock may differ from ours by any amount. So a request whose
/// deadline seems to have passed is neither executed nor rejected: its caller, if it still waits, sends an enquiry about it.
/// The enquiry also shows how far the clocks differ, and later requests of this caller are judged by that.
#[derive(Default)]
pub(crate) struct LatenessEstimate {
    /// For each caller, how long ago a request that was not late seemed to have been sent, in nanoseconds.
    offsets: HashMap<Caller, i64>,
}

/// A caller of one AMQP user. Its name is a claim, which must not affect the requests of other users.
#[derive(PartialEq, Eq, Hash)]
struct Caller {
    user: String,
    sender: SenderId,
}

impl LatenessEstimate {
    /// Returns how much of its timeout a request has left; `None` if its caller may have given up.
    pub(crate) fn time_left(
        &self,
        properties: &BasicProperties,
        timeout: Duration,
    ) -> Option<Duration> {
        let Some(transit) = transit(properties, timeout) else {
            return Some(timeout);
        };
        let offset = self.offsets.get(&caller(properties)).copied();
        let passed = transit.saturating_sub(offset.unwrap_or(0));
        // negative if the caller's clock is ahead
        let passed = Duration::from_nanos(u64::try_from(passed).unwrap_or(0));
        timeout.checked_sub(passed)
    }

    /// Returns whether the clock of a request's caller is known.
    pub(crate) fn knows_clock_of(&self, properties: &BasicProperties) -> bool {
        self.offsets.contains_key(&caller(properties))
    }

    /// Records that the caller of a request still waited when it arrived, which was so long ago. Returns by how much its clock
    /// seems to differ from ours, if that is news.
    pub(crate) fn record_waiting(
        &mut self,
        properties: &BasicProperties,
        timeout: Duration,
        since_arrival: Duration,
    ) -> Option<Duration> {
        let transit = transit(properties, timeout)?.saturating_sub(nanoseconds(since_arrival));
        if self.offsets.len() >= CALLERS {
            self.offsets.clear();
        }
        let known = self.offsets.insert(caller(properties), transit);
        known
            .is_none()
            .then(|| Duration::from_nanos(transit.unsigned_abs()))
    }
}

/// Returns how long ago a request seems to have been sent, in nanoseconds; negative if the caller's clock is ahead.
fn transit(properties: &BasicProperties, timeout: Duration) -> Option<i64> {
    let deadline = wire::number(properties, wire::DEADLINE)?;
    let sent = deadline.saturating_sub(nanoseconds(timeout));
    Some(wire::unix_now().saturating_sub(sent))
}

fn caller(properties: &BasicProperties) -> Caller {
    let source = wire::text(properties, wire::SOURCE).unwrap_or_default();
    let incarnation = wire::number(properties, wire::INCARNATION).unwrap_or(0);
    Caller {
        user: properties.user_id().cloned().unwrap_or_default(),
        sender: SenderId::new(source, u64::try_from(incarnation).unwrap_or(0)),
    }
}

fn nanoseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Headers;

    const TIMEOUT: Duration = Duration::from_secs(5);

    /// A request of the component `Coordinator` of this user, sent just now by a clock that is this many seconds behind.
    fn request(user: &str, behind_s: i64) -> BasicProperties {
        let deadline = wire::unix_now() + nanoseconds(TIMEOUT) - behind_s * 1_000_000_000;
        let headers = Headers::default()
            .text(wire::SOURCE, "Coordinator")
            .number(wire::DEADLINE, deadline);
        BasicProperties::default()
            .with_user_id(user)
            .with_headers(headers.into_table())
            .finish()
    }

    #[test]
    fn a_clock_is_known_for_the_requests_of_its_user_alone() {
        let mut estimate = LatenessEstimate::default();
        let behind = request("robot", 10);
        assert_eq!(estimate.time_left(&behind, TIMEOUT), None);
        let news = estimate.record_waiting(&behind, TIMEOUT, Duration::ZERO);
        assert_eq!(news.map(|offset| offset.as_secs()), Some(10));
        assert_eq!(
            estimate.record_waiting(&behind, TIMEOUT, Duration::ZERO),
            None
        );
        assert!(estimate.time_left(&request("robot", 10), TIMEOUT).is_some());
        assert_eq!(estimate.time_left(&request("robot", 20), TIMEOUT), None);
        let other = request("dash", 10);
        assert!(!estimate.knows_clock_of(&other));
        assert_eq!(estimate.time_left(&other, TIMEOUT), None);
    }

    #[test]
    fn the_time_for_which_a_request_was_held_is_no_difference_of_clocks() {
        let mut estimate = LatenessEstimate::default();
        // it arrived 4 s ago
        let held = request("robot", 14);
        estimate.record_waiting(&held, TIMEOUT, Duration::from_secs(4));
        let left = estimate.time_left(&request("robot", 12), TIMEOUT).unwrap();
        assert!(left < Duration::from_millis(3500), "{left:?}");
    }
}
