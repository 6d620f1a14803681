//! Activities: what drives a component's cycles (RTT `Activity`, TCA's `period`, `delay`, `runOnStartup`).

use std::time::Duration;

use asmotion_derive::Word;
use asmotion_port::Time;
use serde::{Deserialize, Serialize};

/// The activity of a component: the trigger of its cycles, and its timing and scheduling.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Activity {
    /// The trigger of the next cycle.
    pub drive: Drive,
    /// Time from the start to the first cycle, for phasing (TCA `delay`; default: 0).
    pub delay: Duration,
    /// Whether the component is configured when the system starts (RTT `AutoConf`; default: `true`).
    pub configure_on_startup: bool,
    /// Whether the component is started with the system (TCA `runOnStartup`, RTT `AutoStart`; default: `true`).
    pub run_on_startup: bool,
    /// Whether a stop asks a cycle under way to return early (TCA `mayInterruptIfRunning`). The cycle checks
    /// [`Cycle::interrupted`](crate::Cycle::interrupted); it is never aborted.
    pub may_interrupt: bool,
    /// Treatment of periods that a slow cycle missed.
    pub overrun: Overrun,
    /// Deadline of each cycle; `None` for no limit.
    pub deadline: Option<Deadline>,
    /// Reaction to a failed cycle.
    pub on_exception: OnException,
    /// Limit on the restarts by [`OnException::Reset`] over the component's lifetime; `None` for no limit.
    pub max_resets: Option<u32>,
    /// Scheduling class of the thread.
    pub scheduler: Scheduler,
    /// Priority in the scheduling class, 1 to 99; ignored by [`Scheduler::Other`].
    pub priority: u8,
    /// The processors that the thread may run on; empty for all.
    pub cpus: Vec<usize>,
    /// The thread of the cycles in real time; `None` for the one that the other settings require
    /// ([`Activity::thread_use`]).
    pub thread: Option<ThreadUse>,
}

/// The thread in which a live system runs the cycles of a component. A slave runs in its master's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum ThreadUse {
    /// A thread of its own, which the operating system schedules beside all others.
    Own,
    /// One of the executor threads, in turn with the other components that share them.
    Shared,
}

/// The scheduling class of a thread. If the operating system does not permit it, `Event::Denied` is reported. A slave
/// runs in its master's thread, and so in its class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Scheduler {
    /// The default time-sharing class (RTT ORO_SCHED_OTHER).
    #[default]
    Other,
    /// Real-time: runs before all threads of lower priority until it blocks (RTT ORO_SCHED_RT).
    Fifo,
    /// Real-time: takes turns with threads of the same priority.
    #[word("rr")]
    RoundRobin,
}

/// A scheduling setting that the operating system refused; the component runs without it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{setting} is not permitted: {reason}; {help}")]
pub struct Denied {
    /// The refused setting, for example `FIFO 80`.
    pub setting: String,
    /// The operating system's reason.
    pub reason: String,
    /// A remedy.
    pub help: String,
}

/// Reaction to a failed cycle. The component is stopped and cleaned up in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum OnException {
    /// The component stays in its exception state; the others continue.
    #[default]
    Stop,
    /// The component is reset, configured and started again, at most `max_resets` times.
    Reset,
    /// All components stop, in the order of the end of a run.
    Escalate,
}

/// The trigger of a component's cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// The clock, at absolute times without drift.
    Period(Duration),
    /// New data on a port, a request, a reply, or the start of the component.
    Event,
    /// An explicit request (`Run::trigger`).
    Manual,
    /// The end of the master's cycle (`System::add_slave`).
    Slave,
}

/// Treatment of the periods that a slow cycle missed. They are counted in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Overrun {
    /// Missed periods are skipped; the next cycle is at the next whole period.
    #[default]
    Skip,
    /// Missed cycles are executed one after the other, without a pause.
    CatchUp,
    /// The component fails.
    Fail,
}

/// Limit on the duration of a cycle. A cycle that exceeds it is counted and reported (`Event::Late`) in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Deadline {
    /// The limit, from the beginning of the cycle to its end.
    pub within: Duration,
    /// Reaction to a cycle that exceeds the limit.
    pub on_deadline: OnDeadline,
}

/// Reaction to a cycle that exceeds its deadline. The cycle's outputs have been committed by then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum OnDeadline {
    /// The late cycle is only reported.
    #[default]
    Report,
    /// The component is stopped.
    Stop,
    /// The component fails.
    Fail,
}

impl Overrun {
    /// Returns the number of periods missed by a cycle that was due at `due` and ran from `begin` to `end`, and the
    /// time at which the next cycle is due.
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
            // periods missed before this cycle are being made up for, and have been counted
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
            thread: None,
        }
    }

    /// Returns the thread that a live system uses: one of its own for a component with a scheduling class, processors or a
    /// deadline, and otherwise an executor thread. [`thread`](Self::thread) overrides a deadline, but not a class or processors,
    /// which only a thread can have.
    pub fn thread_use(&self) -> ThreadUse {
        let is_scheduled = self.scheduler != Scheduler::Other || !self.cpus.is_empty();
        match self.thread {
            Some(ThreadUse::Own) => ThreadUse::Own,
            Some(ThreadUse::Shared) | None if is_scheduled => ThreadUse::Own,
            None if self.deadline.is_some() => ThreadUse::Own,
            Some(ThreadUse::Shared) | None => ThreadUse::Shared,
        }
    }

    /// A cycle every `period`; a period of zero means event-driven, as in TCA.
    pub fn periodic(period: Duration) -> Self {
        Self::new(Drive::of_period(period))
    }

    /// A cycle on new data.
    pub fn event() -> Self {
        Self::new(Drive::Event)
    }

    /// A cycle on each call of `Run::trigger`.
    pub fn manual() -> Self {
        Self::new(Drive::Manual)
    }

    /// Sets the time from the start to the first cycle.
    #[must_use]
    pub fn delay(self, delay: Duration) -> Self {
        Self { delay, ..self }
    }

    /// Sets whether the component is configured when the system starts.
    #[must_use]
    pub fn configure_on_startup(self, configure_on_startup: bool) -> Self {
        Self {
            configure_on_startup,
            ..self
        }
    }

    /// Sets whether the component is started with the system.
    #[must_use]
    pub fn run_on_startup(self, run_on_startup: bool) -> Self {
        Self {
            run_on_startup,
            ..self
        }
    }

    /// Sets whether a stop asks a cycle under way to return early.
    #[must_use]
    pub fn may_interrupt(self, may_interrupt: bool) -> Self {
        Self {
            may_interrupt,
            ..self
        }
    }

    /// Sets the treatment of missed periods.
    #[must_use]
    pub fn overrun(self, overrun: Overrun) -> Self {
        Self { overrun, ..self }
    }

    /// Sets the deadline of each cycle.
    #[must_use]
    pub fn deadline(self, within: Duration, on_deadline: OnDeadline) -> Self {
        let deadline = Some(Deadline {
            within,
            on_deadline,
        });
        Self { deadline, ..self }
    }

    /// Sets the scheduling class.
    #[must_use]
    pub fn scheduler(self, scheduler: Scheduler) -> Self {
        Self { scheduler, ..self }
    }

    /// Sets the priority in the scheduling class, 1 to 99.
    #[must_use]
    pub fn priority(self, priority: u8) -> Self {
        Self { priority, ..self }
    }

    /// Sets the processors that the thread may run on.
    #[must_use]
    pub fn cpus(self, cpus: impl Into<Vec<usize>>) -> Self {
        Self {
            cpus: cpus.into(),
            ..self
        }
    }

    /// Sets the thread of the cycles in real time.
    #[must_use]
    pub fn thread(self, thread: impl Into<Option<ThreadUse>>) -> Self {
        let thread = thread.into();
        Self { thread, ..self }
    }

    /// Sets the reaction to a failed cycle.
    #[must_use]
    pub fn on_exception(self, on_exception: OnException) -> Self {
        Self {
            on_exception,
            ..self
        }
    }

    /// Sets the limit on restarts; `None` for no limit.
    #[must_use]
    pub fn max_resets(self, max_resets: Option<u32>) -> Self {
        Self { max_resets, ..self }
    }
}

impl Drive {
    /// Periodic, or event-driven if the period is zero.
    pub fn of_period(period: Duration) -> Self {
        if period.is_zero() {
            Self::Event
        } else {
            Self::Period(period)
        }
    }

    /// The same drive with another period; zero makes it event-driven. A slave stays a slave.
    pub fn with_period(self, period: Duration) -> Self {
        match self {
            Self::Period(_) | Self::Event | Self::Manual => Self::of_period(period),
            Self::Slave => Self::Slave,
        }
    }

    /// The period; `None` unless periodic.
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

    /// Missed periods and the next due time for a period of 10 ms, all in milliseconds.
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
