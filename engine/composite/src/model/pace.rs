//! Scheduling and lifecycle of components: the tables `task` (TCA) and `activity` (RTT).

use asmotion_component::{OnDeadline, OnException, Overrun, Scheduler, ThreadUse};
use asmotion_derive::Table;
use asmotion_diagnostics::Span;

use super::limits::DAY_MS;
use super::setting::{Amount, Setting};
use crate::at::At;

/// Schedule of a component. A `task` can use a broker; an `activity` has a thread with a scheduling class.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a task",
    elsewhere("activity", "an activity"),
    example = "{ period_ms = 50 }",
    resolved = PlannedPace
)]
pub struct Pace {
    /// Source location of the table.
    pub span: Span,
    /// Unique name of the component outside its composite: in queues, messages, logs and tools; the component name by default.
    #[key(within = "task", example = "\"planner\"", written)]
    pub id: Option<At<String>>,
    /// Period; 0 makes the component event-driven.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, default = 0)]
    pub period_ms: Option<At<Amount>>,
    /// Delay before the first cycle.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, default = 0)]
    pub delay_ms: Option<At<Amount>>,
    /// Start cycling as soon as the composite runs.
    #[key(default = true)]
    pub run_on_startup: Option<At<bool>>,
    /// Handling of cycles that could not start in time.
    #[key(default)]
    pub overrun: Option<At<Overrun>>,
    /// Allow a stop to interrupt a cycle.
    #[key(within = "task", default)]
    pub may_interrupt_if_running: Option<At<bool>>,
    /// Broker for its topics; communication is local by default.
    #[key(within = "task", example = "\"main\"", local)]
    pub broker: Option<At<String>>,
    /// Scheduling class of the thread; that of the process by default.
    #[key(within = "activity")]
    pub scheduler: Option<At<Scheduler>>,
    /// Scheduling priority; that of the process by default.
    #[key(within = "activity", range = 1..=99)]
    pub priority: Option<At<u64>>,
    /// Processor affinity; that of the process by default.
    #[key(within = "activity", range = 0..=1023, example = "[1]")]
    pub cpu: Vec<At<u64>>,
    /// Thread in real time: its own, or the executor threads that components share; its own by default if it has a scheduling
    /// class, processors or a deadline.
    pub thread: Option<At<ThreadUse>>,
    /// Maximum duration of a cycle.
    #[key(within = "activity", unit = "milliseconds", range = 1..=DAY_MS)]
    pub deadline_ms: Option<At<Amount>>,
    /// Reaction to an exceeded deadline.
    #[key(within = "activity", default)]
    pub on_deadline: Option<At<OnDeadline>>,
    /// Component in whose thread it runs, immediately after it (RTT's slave activity).
    #[key(within = "activity", example = "\"RoverDriver\"", local)]
    pub master: Option<At<String>>,
}

/// Automatic lifecycle transitions.
#[derive(Clone, Debug, Table)]
#[table(of = "`lifecycle`", example = "{ autostart = true }", resolved = PlannedLifecycle)]
pub struct Lifecycle {
    /// Configure the component when it is loaded.
    #[key(default = true)]
    pub autoconf: Option<At<bool>>,
    /// Start the component once configured.
    #[key(default = true)]
    pub autostart: Option<At<bool>>,
    /// Reaction to an exception.
    #[key(default)]
    pub on_exception: Option<At<OnException>>,
    /// Maximum number of resets after exceptions.
    #[key(range = 0..=1_000_000, default = 3)]
    pub max_resets: Option<At<u64>>,
    /// Samples written to outputs after the last cycle, by output name; in place of those that the component declares.
    #[key(example = "{ twist = { } }")]
    pub safe: Vec<Setting>,
}
