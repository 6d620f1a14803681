//! When a component cycles and how its life goes: the two tables `task` (TCA) and `activity` (RTT).

use asmotion_diagnostics::Span;

use super::Amount;
use crate::At;
use crate::choice::choice;

/// `task` or `activity`: when a component cycles.
#[derive(Clone, Debug)]
pub struct Pace {
    /// The place of the table.
    pub span: Span,
    /// Whether the table is `task`, which can name a broker.
    pub is_task: bool,
    /// `task.id`: queue name, log name, label of metrics.
    pub id: Option<At<String>>,
    /// Time between two cycles; 0 is event-driven.
    pub period_ms: Option<At<Amount>>,
    /// Time before the first cycle.
    pub delay_ms: Option<At<Amount>>,
    /// Whether it cycles as soon as the composite runs.
    pub run_on_startup: Option<At<bool>>,
    /// Whether a stop may cut a cycle short.
    pub may_interrupt_if_running: Option<At<bool>>,
    /// The broker its topics go through; in process where not given.
    pub broker: Option<At<String>>,
    /// What happens to a cycle that could not begin in time.
    pub overrun: Option<At<Overrun>>,
    /// The scheduling class of its thread.
    pub scheduler: Option<At<Scheduler>>,
    /// The priority in that class.
    pub priority: Option<At<i64>>,
    /// The processors it may run on.
    pub cpu: Vec<At<i64>>,
    /// How long a cycle may take.
    pub deadline_ms: Option<At<Amount>>,
    /// What happens when it takes longer.
    pub on_deadline: Option<At<OnDeadline>>,
    /// The component in whose thread, and after which, it cycles (RTT's slave activity).
    pub master: Option<At<String>>,
}

choice! {
    /// What happens to a cycle that could not begin in time.
    pub enum Overrun {
        /// It is left out and counted.
        Skip = "skip",
        /// It is made up for.
        CatchUp = "catch_up",
        /// The component fails.
        Fail = "fail",
    }
}

choice! {
    /// The scheduling class of a thread or process.
    pub enum Scheduler {
        /// As any program.
        Other = "other",
        /// First in, first out, by priority.
        Fifo = "fifo",
        /// By turns within a priority.
        RoundRobin = "rr",
    }
}

choice! {
    /// What happens when a cycle takes longer than its deadline.
    pub enum OnDeadline {
        /// It is reported.
        Report = "report",
        /// The component stops.
        Stop = "stop",
        /// The component fails.
        Fail = "fail",
    }
}

/// `lifecycle`: what happens without anybody asking.
#[derive(Clone, Debug)]
pub struct Lifecycle {
    /// Configure when loaded.
    pub autoconf: Option<At<bool>>,
    /// Start when configured.
    pub autostart: Option<At<bool>>,
    /// What follows an exception.
    pub on_exception: Option<At<OnException>>,
    /// How often it is reset before it is given up.
    pub max_resets: Option<At<i64>>,
}

choice! {
    /// What follows an exception of a component.
    pub enum OnException {
        /// It stays where it is; the others go on.
        Stop = "stop",
        /// It is reset and started again.
        Reset = "reset",
        /// The whole composite stops.
        Escalate = "escalate",
    }
}
