//! Activities: what drives a component's cycles (RTT `Activity`, TCA's `period`, `delay`, `runOnStartup`).

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// What drives cycles, and how.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Activity {
    /// What makes the next cycle due.
    pub drive: Drive,
    /// From start to the first cycle of a periodic activity, for phasing (TCA `delay`).
    pub delay: Duration,
    /// Whether the component starts with the system (TCA `runOnStartup`).
    pub run_on_startup: bool,
    /// Whether stopping tells a cycle under way to give up (TCA `mayInterruptIfRunning`);
    /// the cycle sees it in [`Cycle::interrupted`](crate::Cycle::interrupted), and is never torn.
    pub may_interrupt: bool,
    /// What happens to periods that a slow cycle missed.
    pub overrun: Overrun,
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
}

/// What happens to periods that a slow cycle missed; they are counted in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
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

impl Activity {
    fn new(drive: Drive) -> Self {
        Self {
            drive,
            delay: Duration::ZERO,
            run_on_startup: true,
            may_interrupt: false,
            overrun: Overrun::Skip,
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

    /// A cycle whenever [`trigger`](crate::Run::trigger) asks for one.
    pub fn manual() -> Self {
        Self::new(Drive::Manual)
    }

    /// With the first cycle this long after the start.
    #[must_use]
    pub fn delay(self, delay: Duration) -> Self {
        Self { delay, ..self }
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

    /// The period, of what has one.
    pub fn period(self) -> Option<Duration> {
        match self {
            Self::Period(period) => Some(period),
            Self::Event | Self::Manual => None,
        }
    }
}
