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
    offsets: HashMap<SenderId, i64>,
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

    /// Records that the caller of a request that arrived just now still waits. Returns by how much its clock seems to differ
    /// from ours, if that is news.
    pub(crate) fn record_waiting(
        &mut self,
        properties: &BasicProperties,
        timeout: Duration,
    ) -> Option<Duration> {
        let transit = transit(properties, timeout)?;
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

fn caller(properties: &BasicProperties) -> SenderId {
    let source = wire::text(properties, wire::SOURCE).unwrap_or_default();
    let incarnation = wire::number(properties, wire::INCARNATION).unwrap_or(0);
    SenderId::new(source, u64::try_from(incarnation).unwrap_or(0))
}

fn nanoseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}
