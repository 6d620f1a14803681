//! When a component cycles and how its life goes: the two tables `task` (TCA) and `activity` (RTT).

use asmotion_component::{OnDeadline, OnException, Overrun, Scheduler};
use asmotion_derive::Table;
use asmotion_diagnostics::Span;

use super::{Amount, DAY_MS};
use crate::at::At;

/// When a component cycles. A `task` goes over a broker, an `activity` has a thread with a scheduling class.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a task",
    elsewhere("activity", "an activity"),
    example = "{ period_ms = 50 }",
    resolved = PlannedPace
)]
pub struct Pace {
    /// The place of the table.
    pub span: Span,
    /// Name of its queue and its log, label of its metrics; the component's name, if absent.
    #[key(within = "task", example = "\"planner\"", written)]
    pub id: Option<At<String>>,
    /// Time between two cycles; 0 is event-driven.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, default = 0)]
    pub period_ms: Option<At<Amount>>,
    /// Time before the first cycle.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, default = 0)]
    pub delay_ms: Option<At<Amount>>,
    /// Whether it cycles as soon as the composite runs.
    #[key(default = true)]
    pub run_on_startup: Option<At<bool>>,
    /// What happens to a cycle that could not begin in time.
    #[key(default)]
    pub overrun: Option<At<Overrun>>,
    /// Whether a stop may cut a cycle short.
    #[key(within = "task", default)]
    pub may_interrupt_if_running: Option<At<bool>>,
    /// Broker that its topics go through; in process, if absent.
    #[key(within = "task", example = "\"main\"", local)]
    pub broker: Option<At<String>>,
    /// Scheduling class of its thread; that of its process, if absent.
    #[key(within = "activity")]
    pub scheduler: Option<At<Scheduler>>,
    /// Priority in that class; that of its process, if absent.
    #[key(within = "activity", range = 1..=99)]
    pub priority: Option<At<u64>>,
    /// Processors it may run on; those of its process, if none is named.
    #[key(within = "activity", range = 0..=1023, example = "[1]")]
    pub cpu: Vec<At<u64>>,
    /// How long a cycle may take.
    #[key(within = "activity", unit = "milliseconds", range = 1..=DAY_MS)]
    pub deadline_ms: Option<At<Amount>>,
    /// What happens when a cycle takes longer.
    #[key(within = "activity", default)]
    pub on_deadline: Option<At<OnDeadline>>,
    /// Component in whose thread, and after which, it cycles (RTT's slave activity).
    #[key(within = "activity", example = "\"RoverDriver\"", local)]
    pub master: Option<At<String>>,
}

/// Transitions of a component that nobody has to ask for.
#[derive(Clone, Debug, Table)]
#[table(of = "`lifecycle`", example = "{ autostart = true }", resolved = PlannedLifecycle)]
pub struct Lifecycle {
    /// Whether it is configured when it is loaded.
    #[key(default = true)]
    pub autoconf: Option<At<bool>>,
    /// Whether it is started when it is configured.
    #[key(default = true)]
    pub autostart: Option<At<bool>>,
    /// What follows an exception.
    #[key(default)]
    pub on_exception: Option<At<OnException>>,
    /// How often it is reset before it is given up.
    #[key(range = 0..=1_000_000, default = 3)]
    pub max_resets: Option<At<u64>>,
}
