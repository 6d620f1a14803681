//! Deployment: which process runs what, what is written down, and when a process is started again.

use asmotion_component::Scheduler;
use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use super::DAY_MS;
use crate::at::At;

/// Which process runs what.
#[derive(Clone, Debug, Table)]
#[table(of = "`deploy`")]
pub struct Deploy {
    /// The place of the table.
    pub span: Span,
    /// The processes; every component is in one of them.
    #[key(
        needed,
        example = "[{ name = \"onboard\", components = [\"RoverDriver\"] }]"
    )]
    pub processes: Vec<Process>,
    /// When a process is started again.
    pub restart: Option<Restart>,
    /// What of a run is written down.
    pub record: Option<Record>,
}

/// A process and the components in it.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a process",
    example = "{ name = \"onboard\", components = [\"RoverDriver\"] }",
    resolved = PlannedProcess
)]
pub struct Process {
    /// The name that `asmotion up` and `--process` know it by.
    #[key(example = "\"onboard\"", form = thing)]
    pub name: At<String>,
    /// Machine it runs on; any, if absent.
    #[key(example = "\"robot\"")]
    pub host: Option<At<String>>,
    /// The components in it; those of a nested composite go with it.
    #[key(needed, example = "[\"RoverDriver\"]")]
    pub components: Vec<At<String>>,
    /// Scheduling class of its components that name none.
    #[key(default)]
    pub scheduler: Option<At<Scheduler>>,
    /// Priority in it of those that name none.
    #[key(range = 1..=99)]
    pub priority: Option<At<u64>>,
    /// Processors that its components may run on that name none.
    #[key(range = 0..=1023, example = "[1]")]
    pub cpu: Vec<At<u64>>,
}

/// When a process is started again.
#[derive(Clone, Debug, Table)]
#[table(of = "`restart`", example = "{ policy = \"on_failure\" }", resolved = PlannedRestart)]
pub struct Restart {
    /// After which ends.
    #[key(default)]
    pub policy: Option<At<RestartPolicy>>,
    /// How often within the window.
    #[key(range = 0..=1_000_000, default = 5)]
    pub max: Option<At<u64>>,
    /// The window.
    #[key(unit = "seconds", range = 1..=86_400, default = 60)]
    pub window_s: Option<At<u64>>,
    /// The waits before each start; the last one repeats.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, example = "[200, 400]")]
    pub backoff_ms: Vec<At<u64>>,
}

/// After which ends a process is started again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum RestartPolicy {
    /// After none.
    #[default]
    Never,
    /// After a failure.
    OnFailure,
    /// After every end.
    Always,
}

/// What of a run is written down.
#[derive(Clone, Debug, Table)]
#[table(of = "`record`", example = "{ dir = \"runs/\" }", resolved = PlannedRecord)]
pub struct Record {
    /// The place of the table.
    pub span: Span,
    /// Folder of the files.
    #[key(example = "\"runs/\"", default = "runs/")]
    pub dir: Option<At<String>>,
    /// Which topics; `*` is all.
    #[key(example = "[\"*\"]")]
    pub topics: Vec<At<String>>,
    /// Whether calls and replies are written down.
    #[key(default = true)]
    pub calls: Option<At<bool>>,
    /// Whether states of ASM components are written down.
    #[key(default = true)]
    pub asm_states: Option<At<bool>>,
    /// Size at which a new file is begun.
    #[key(unit = "megabytes", range = 1..=1_000_000, default = 256)]
    pub rotate_mb: Option<At<u64>>,
}
