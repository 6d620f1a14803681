//! Activities: what drives a component's cycles (RTT `Activity`, TCA's `period`, `delay`, `runOnStartup`).

use std::time::Duration;

use asmotion_derive::Word;
use asmotion_port::Time;
use serde::{Deserialize, Serialize};

/// What drives cycles, and how.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Activity {
    /// What makes the next cycle due.
    pub drive: Drive,
    /// From start to the first cycle of a periodic activity, for phasing (TCA `delay`).
    pub delay: Duration,
    /// Whether the component is configured with the system (RTT `AutoConf`).
    pub configure_on_startup: bool,
    /// Whether the component starts with the system (TCA `runOnStartup`, RTT `AutoStart`).
    pub run_on_startup: bool,
    /// Whether stopping tells a cycle under way to give up (TCA `mayInterruptIfRunning`);
    /// the cycle sees it in [`Cycle::interrupted`](crate::Cycle::interrupted), and is never torn.
    pub may_interrupt: bool,
    /// What happens to periods that a slow cycle missed.
    pub overrun: Overrun,
    /// How long a cycle may take; as long as it likes, if absent.
    pub deadline: Option<Deadline>,
    /// What happens when the component fails in a cycle.
    pub on_exception: OnException,
    /// How often [`OnException::Reset`] brings it back in all its life; without end, if absent.
    pub max_resets: Option<u32>,
    /// The scheduling class of its thread.
    pub scheduler: Scheduler,
    /// Priority in that class, 1 to 99; of no meaning to [`Scheduler::Other`].
    pub priority: u8,
    /// The processors that its thread may run on; all, if none is named.
    pub cpus: Vec<usize>,
}

/// The scheduling class of a thread, where the system permits it; where not, `Event::Denied`
/// says so. A slave is in its master's thread, and so in its class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Scheduler {
    /// Scheduled like any program (RTT ORO_SCHED_OTHER).
    #[default]
    Other,
    /// Runs before all threads of a lower priority, until it waits (RTT ORO_SCHED_RT).
    Fifo,
    /// Takes turns with threads of its priority.
    #[word("rr")]
    RoundRobin,
}

/// Something of an activity that the system does not permit; the component runs without it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{wish} is not permitted: {reason}; {help}")]
pub struct Denied {
    /// What was wanted: `FIFO 80`.
    pub wish: String,
    /// Why not.
    pub reason: String,
    /// A way out.
    pub help: String,
}

/// What happens when a component fails in a cycle. In any case it is stopped and cleaned up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum OnException {
    /// It stays in its exception; the others go on.
    #[default]
    Stop,
    /// It is reset, configured and started again, at most [`Activity::max_resets`] times.
    Reset,
    /// Everything stops, in reverse order of the start.
    Escalate,
}

/// What makes the next cycle due.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// The clock, at absolute deadlines: no drift.
    Period(Duration),
    /// New data on a port, a request, a reply, or the start.
    Event,
    /// Somebody who asks for it.
    Manual,
    /// The end of the master's cycle (`System::slave`).
    Slave,
}

/// What happens to periods that a slow cycle missed; they are counted in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Overrun {
    /// They are left out; the next cycle is at the next whole period.
    #[default]
    Skip,
    /// They are made up for, one after the other without pause.
    CatchUp,
    /// The component fails.
    Fail,
}

/// How long a cycle may take, from its beginning to its end. One that takes longer is counted and told in any case
/// (`Event::Late`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Deadline {
    /// So long.
    pub within: Duration,
    /// What happens when it takes longer.
    pub on_deadline: OnDeadline,
}

/// What happens to a component whose cycle took longer than its deadline. What the cycle did has happened by then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum OnDeadline {
    /// It is reported, and nothing more.
    #[default]
    Report,
    /// It is stopped.
    Stop,
    /// It fails.
    Fail,
}

impl Overrun {
    /// After a cycle that was due at `due` and ran from `begin` to `end`: how many periods it has missed, and when the
    /// next one is due.
    pub fn after_cycle(self, due: Time, period: Duration, begin: Time, end: Time) -> (u64, Time) {
        let passed = |at: Time| {
            let periods = at.since(due).as_nanos() / period.as_nanos().max(1);
            u64::try_from(periods).unwrap_or(u64::MAX)
        };
        match self {
            Self::Skip | Self::Fail => {
                let missed = passed(end);
                let skipped = u32::try_from(missed).unwrap_or(u32::MAX);
                (
                    missed,
                    due + period.saturating_mul(skipped.saturating_add(1)),
                )
            }
            // What was missed before this cycle is being made up for, and has been counted.
            Self::CatchUp => (passed(end) - passed(begin), due + period),
        }
    }
}

impl Activity {
    fn new(drive: Drive) -> Self {
        Self {
            drive,
            delay: Duration::ZERO,
            configure_on_startup: true,
            run_on_startup: true,
            may_interrupt: false,
            overrun: Overrun::Skip,
            deadline: None,
            on_exception: OnException::Stop,
            max_resets: None,
            scheduler: Scheduler::Other,
            priority: 1,
            cpus: Vec::new(),
        }
    }

    /// A cycle every `period`; a period of zero is event-driven, as in TCA.
    pub fn periodic(period: Duration) -> Self {
        Self::new(Drive::of_period(period))
    }

    /// A cycle whenever something new is there.
    pub fn event() -> Self {
        Self::new(Drive::Event)
    }

    /// A cycle whenever `Run::trigger` asks for one.
    pub fn manual() -> Self {
        Self::new(Drive::Manual)
    }

    /// With the first cycle this long after the start.
    #[must_use]
    pub fn delay(self, delay: Duration) -> Self {
        Self { delay, ..self }
    }

    /// Configured with the system, or later by somebody.
    #[must_use]
    pub fn configure_on_startup(self, configure_on_startup: bool) -> Self {
        Self {
            configure_on_startup,
            ..self
        }
    }

    /// Started with the system, or later by somebody.
    #[must_use]
    pub fn run_on_startup(self, run_on_startup: bool) -> Self {
        Self {
            run_on_startup,
            ..self
        }
    }

    /// Whether stopping tells a cycle under way to give up.
    #[must_use]
    pub fn may_interrupt(self, may_interrupt: bool) -> Self {
        Self {
            may_interrupt,
            ..self
        }
    }

    /// With this answer to missed periods.
    #[must_use]
    pub fn overrun(self, overrun: Overrun) -> Self {
        Self { overrun, ..self }
    }

    /// With this long for each cycle.
    #[must_use]
    pub fn deadline(self, within: Duration, on_deadline: OnDeadline) -> Self {
        let deadline = Some(Deadline {
            within,
            on_deadline,
        });
        Self { deadline, ..self }
    }

    /// In this scheduling class.
    #[must_use]
    pub fn scheduler(self, scheduler: Scheduler) -> Self {
        Self { scheduler, ..self }
    }

    /// With this priority in its scheduling class.
    #[must_use]
    pub fn priority(self, priority: u8) -> Self {
        Self { priority, ..self }
    }

    /// On these processors.
    #[must_use]
    pub fn cpus(self, cpus: impl Into<Vec<usize>>) -> Self {
        Self {
            cpus: cpus.into(),
            ..self
        }
    }

    /// With this answer to exceptions.
    #[must_use]
    pub fn on_exception(self, on_exception: OnException) -> Self {
        Self {
            on_exception,
            ..self
        }
    }

    /// Reset at most this often; without end, if absent.
    #[must_use]
    pub fn max_resets(self, max_resets: Option<u32>) -> Self {
        Self { max_resets, ..self }
    }
}

impl Drive {
    /// Periodic, or event-driven for a period of zero.
    pub fn of_period(period: Duration) -> Self {
        if period.is_zero() {
            Self::Event
        } else {
            Self::Period(period)
        }
    }

    /// Driven by this period from now on; a slave stays one.
    pub fn with_period(self, period: Duration) -> Self {
        match self {
            Self::Period(_) | Self::Event | Self::Manual => Self::of_period(period),
            Self::Slave => Self::Slave,
        }
    }

    /// The period, of what has one.
    pub fn period(self) -> Option<Duration> {
        match self {
            Self::Period(period) => Some(period),
            Self::Event | Self::Manual | Self::Slave => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_port::Span;

    /// Missed periods and the next deadline of a cycle of 10 ms, all in milliseconds.
    fn after(overrun: Overrun, due: u64, begin: u64, end: u64) -> (u64, u64) {
        let at = |ms: u64| Time::ZERO + ms.ms();
        let (missed, next) = overrun.after_cycle(at(due), 10.ms(), at(begin), at(end));
        (missed, next.nanos().unsigned_abs() / 1_000_000)
    }

    #[test]
    fn t6_a_cycle_of_35_ms_at_10_ms_misses_three_periods() {
        for (overrun, next) in [
            (Overrun::Skip, 40),
            (Overrun::Fail, 40),
            (Overrun::CatchUp, 10),
        ] {
            assert_eq!(after(overrun, 0, 0, 35), (3, next), "{overrun:?}");
        }
    }

    #[test]
    fn t6_a_cycle_in_time_misses_none() {
        for overrun in [Overrun::Skip, Overrun::Fail, Overrun::CatchUp] {
            assert_eq!(after(overrun, 20, 23, 29), (0, 30), "{overrun:?}");
        }
    }

    #[test]
    fn t6_what_is_caught_up_is_counted_once() {
        assert_eq!(after(Overrun::CatchUp, 10, 35, 36), (0, 20));
        assert_eq!(after(Overrun::CatchUp, 20, 36, 41), (1, 30));
    }

    #[test]
    fn t6_a_cycle_that_begins_late_skips_to_the_next_whole_period() {
        assert_eq!(after(Overrun::Skip, 0, 12, 13), (1, 20));
    }

    #[test]
    fn t16_a_period_of_zero_is_event_driven() {
        assert_eq!(Activity::periodic(Duration::ZERO), Activity::event());
    }
}
