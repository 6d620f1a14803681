//! Deployment: processes, recording and restarts.

use asmotion_component::Scheduler;
use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use super::instances::Instances;
use super::limits::DAY_MS;
use crate::at::At;

/// Assignment of components to processes.
#[derive(Clone, Debug, Table)]
#[table(of = "`deploy`")]
pub struct Deploy {
    /// Source location of the table.
    pub span: Span,
    /// Processes; together they contain every component exactly once.
    #[key(
        needed,
        example = "[{ name = \"onboard\", components = [\"RoverDriver\"] }]"
    )]
    pub processes: Vec<Process>,
    /// Restarts of terminated processes.
    pub restart: Option<Restart>,
    /// Recording of runs.
    pub record: Option<Record>,
}

/// A process and its components.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a process",
    example = "{ name = \"onboard\", components = [\"RoverDriver\"] }",
    resolved = PlannedProcess
)]
pub struct Process {
    /// Name used by `asmotion up` and `--process`.
    #[key(example = "\"onboard\"", form = thing)]
    pub name: At<String>,
    /// Instances: one element for each value of a variable, which is substituted in its names and strings, as in
    /// `"R$r.scan"`. A string that is only the variable becomes its value.
    #[key(name = "for", example = "\"$r in 1..20\"", written)]
    pub instances: Option<Instances>,
    /// Host of the process; any by default.
    #[key(example = "\"robot\"")]
    pub host: Option<At<String>>,
    /// Components of the process; inner components of a nested composite are included.
    #[key(needed, example = "[\"RoverDriver\"]")]
    pub components: Vec<At<String>>,
    /// Default scheduling class of its components.
    #[key(default)]
    pub scheduler: Option<At<Scheduler>>,
    /// Default priority of its components.
    #[key(range = 1..=99)]
    pub priority: Option<At<u64>>,
    /// Default processor affinity of its components.
    #[key(range = 0..=1023, example = "[1]")]
    pub cpu: Vec<At<u64>>,
}

/// Restarts of terminated processes.
#[derive(Clone, Debug, Table)]
#[table(of = "`restart`", example = "{ policy = \"on_failure\" }", resolved = PlannedRestart)]
pub struct Restart {
    /// Kinds of termination that lead to a restart.
    #[key(default)]
    pub policy: Option<At<RestartPolicy>>,
    /// Maximum number of restarts within the window.
    #[key(range = 0..=1_000_000, default = 5)]
    pub max: Option<At<u64>>,
    /// Length of the window.
    #[key(unit = "seconds", range = 1..=86_400, default = 60)]
    pub window_s: Option<At<u64>>,
    /// Delays before consecutive restarts; the last one repeats.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, example = "[200, 400]")]
    pub backoff_ms: Vec<At<u64>>,
}

/// Kinds of termination that lead to a restart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum RestartPolicy {
    /// No restart.
    #[default]
    Never,
    /// Restart after a failure.
    OnFailure,
    /// Restart after every termination.
    Always,
}

/// Recording of runs.
#[derive(Clone, Debug, Table)]
#[table(of = "`record`", example = "{ dir = \"runs/\" }", resolved = PlannedRecord)]
pub struct Record {
    /// Source location of the table.
    pub span: Span,
    /// Directory of the recordings.
    #[key(example = "\"runs/\"", default = "runs/")]
    pub dir: Option<At<String>>,
    /// Topics recorded; `*` for all.
    #[key(example = "[\"*\"]")]
    pub topics: Vec<At<String>>,
    /// Record calls and replies.
    #[key(default = true)]
    pub calls: Option<At<bool>>,
    /// Record states of ASM components.
    #[key(default = true)]
    pub asm_states: Option<At<bool>>,
    /// File size at which a new file is started.
    #[key(unit = "megabytes", range = 1..=1_000_000, default = 256)]
    pub rotate_mb: Option<At<u64>>,
    /// Readers of the recordings.
    #[key(name = "for", default)]
    pub readers: Option<At<RecordReaders>>,
}

/// Readers of recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum RecordReaders {
    /// Viewers such as Foxglove, Lichtblick and PlotJuggler.
    #[default]
    Viewers,
    /// Tools for bags of ROS 2, such as `ros2 bag` and `rosbags`.
    Ros2,
}
