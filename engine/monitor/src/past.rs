//! What a tab can go back to: the moments of a run that is over.

use std::collections::BTreeMap;

use asmotion_component::Time;

use crate::log_entry::LogFilter;
use crate::step_guards::KnownStep;

/// A run that is over.
pub(crate) trait Past: Send + Sync {
    /// Time of its last event.
    fn end(&self) -> Time;

    /// The step of a component with this number and time in seconds; `None` if there is none.
    fn known_step(&self, component: &str, number: u64, t: f64) -> Option<KnownStep>;

    /// The message about a moment, as JSON.
    fn moment(&self, request: &MomentRequest<'_>) -> String;
}

/// A moment that a tab shows.
#[cfg_attr(
    not(feature = "recording"),
    allow(dead_code, reason = "this build has no run that is over")
)]
pub(crate) struct MomentRequest<'a> {
    /// Time of the run, in seconds.
    pub t: f64,
    /// Time around it that the tab shows, in seconds.
    pub span: f64,
    /// Whether the tab needs the steps and log entries around it.
    pub window: bool,
    /// The part of the log that the tab needs; `None` for all of it.
    pub log: Option<LogFilter>,
    /// Whether the tab needs the components.
    pub components: bool,
    /// Outputs whose samples the tab shows.
    pub outputs: Vec<&'a str>,
    /// Numbers of the samples that the tab has.
    pub has: &'a BTreeMap<String, u64>,
}
