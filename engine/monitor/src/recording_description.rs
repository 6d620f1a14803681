//! What only the description of a recording has.

use std::collections::BTreeMap;

use serde::Serialize;

/// The part of a description that only a recording has.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct RecordingDescription {
    /// Path of the first file.
    pub file: String,
    /// Duration of the run, in seconds.
    pub end: f64,
    /// What is missing, in words.
    pub problem: Option<String>,
    /// Changes of the control state by component: time, state before and after.
    pub changes: BTreeMap<String, Vec<(f64, String, String)>>,
    /// Warnings and errors: time, level and text.
    pub marks: Vec<(f64, &'static str, String)>,
    /// Violated properties: time, component, and what is violated, in words.
    pub violations: Vec<(f64, String, String)>,
    /// Driven paths by output: time, x, y and yaw.
    pub trails: BTreeMap<String, Vec<[f64; 4]>>,
}
