//! When a component cycles and how its life goes: the two tables `task` (TCA) and `activity` (RTT).

use asmotion_component::{OnDeadline, OnException, Overrun, Scheduler};
use asmotion_diagnostics::Span;

use super::Amount;
use crate::At;

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
