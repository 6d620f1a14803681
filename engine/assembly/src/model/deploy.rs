//! Deployment: which process runs what, what is written down, who is started again.

use asmotion_component::Scheduler;
use asmotion_derive::Word;
use asmotion_diagnostics::Span;

use crate::At;

/// `[deploy]`.
#[derive(Clone, Debug)]
pub struct Deploy {
    /// The place of the table.
    pub span: Span,
    /// The processes.
    pub processes: Vec<Process>,
    /// When a process is started again.
    pub restart: Option<Restart>,
    /// What is written down.
    pub record: Option<Record>,
}

/// A process and the components in it.
#[derive(Clone, Debug)]
pub struct Process {
    /// Its name.
    pub name: At<String>,
    /// The machine it runs on.
    pub host: Option<At<String>>,
    /// The components in it.
    pub components: Vec<At<String>>,
    /// The scheduling class of its components that name none.
    pub scheduler: Option<At<Scheduler>>,
    /// The priority in it of those that name none.
    pub priority: Option<At<i64>>,
    /// The processors that its components may run on that name none.
    pub cpu: Vec<At<i64>>,
}

/// When a process is started again.
#[derive(Clone, Debug)]
pub struct Restart {
    /// After what.
    pub policy: Option<At<RestartPolicy>>,
    /// How often within the window.
    pub max: Option<At<i64>>,
    /// The window.
    pub window_s: Option<At<i64>>,
    /// The waits; the last one repeats.
    pub backoff_ms: Vec<At<i64>>,
}

/// After what a process is started again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum RestartPolicy {
    /// Never.
    #[default]
    Never,
    /// After a failure.
    OnFailure,
    /// After every end.
    Always,
}

/// What of a run is written down.
#[derive(Clone, Debug)]
pub struct Record {
    /// The place of the table.
    pub span: Span,
    /// Where to.
    pub dir: Option<At<String>>,
    /// Which topics; `*` is all.
    pub topics: Vec<At<String>>,
    /// Calls and replies.
    pub calls: Option<At<bool>>,
    /// States of the ASM components.
    pub asm_states: Option<At<bool>>,
    /// How large a file grows.
    pub rotate_mb: Option<At<i64>>,
}
