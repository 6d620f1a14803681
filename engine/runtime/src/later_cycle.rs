//! The cycle that a component has requested for a later time.

use asmotion_port::Time;
use serde::{Deserialize, Serialize};

/// The cycle that a component has requested for a later time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LaterCycle {
    /// Time of the requested cycle.
    requested: Option<Time>,
    /// Time at which the executor wakes the component next because of a request. Requests for later times need no other
    /// wake-up until then, so that a component with a new request in each cycle does not fill the executor's queue.
    planned: Option<Time>,
}

impl LaterCycle {
    /// Adds a request; the earliest one counts.
    pub(crate) fn request(&mut self, at: Time) {
        self.requested = Some(self.requested.map_or(at, |known| known.min(at)));
    }

    /// Drops the request.
    pub(crate) fn forget(&mut self) {
        self.requested = None;
    }

    /// Time of the requested cycle.
    pub(crate) fn time(&self) -> Option<Time> {
        self.requested
    }

    /// Removes a request that is due. Returns whether there was one.
    pub(crate) fn take_due(&mut self, now: Time) -> bool {
        self.planned.take_if(|at| *at <= now);
        self.requested.take_if(|at| *at <= now).is_some()
    }

    /// Returns the time at which the executor has to wake the component, unless it does so earlier anyway.
    pub(crate) fn plan(&mut self) -> Option<Time> {
        let at = self.requested?;
        if self.planned.is_some_and(|planned| planned <= at) {
            return None;
        }
        self.planned = Some(at);
        self.planned
    }

    /// Returns whether there is neither a request nor a planned wake-up.
    pub(crate) fn is_idle(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(nanos: i64) -> Time {
        Time::from_nanos(nanos)
    }

    #[test]
    fn the_earliest_request_counts_and_ends_when_it_is_due() {
        let mut later = LaterCycle::default();
        later.request(at(30));
        later.request(at(20));
        later.request(at(40));
        assert_eq!(later.plan(), Some(at(20)));
        assert!(!later.take_due(at(19)));
        assert!(later.take_due(at(20)));
        assert!(later.is_idle());
    }

    #[test]
    fn later_requests_use_the_wake_up_that_is_planned() {
        let mut later = LaterCycle::default();
        later.request(at(20));
        assert_eq!(later.plan(), Some(at(20)));
        for next in 21..1000 {
            later.forget();
            later.request(at(next));
            assert_eq!(later.plan(), None);
        }
        assert!(!later.take_due(at(20)));
        assert_eq!(later.plan(), Some(at(999)));
        // an earlier one needs its own
        later.request(at(500));
        assert_eq!(later.plan(), Some(at(500)));
    }
}
