//! Measures the cost of building `asmotion` by sets of Cargo features, and reads the recorded
//! figures.
//!
//! The unit is CPU seconds, user and system, of all processes that cargo starts. Unlike wall time, they are nearly the same on a
//! busy machine. They still depend on its processors: one commit was counted as 480 on one machine and 561 on another. So
//! each figure is scaled by the time that a reference crate takes to compile in the same run.

mod reference;

use crate::table::Rows;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

/// The record, written by `build-cost --record`; one table for each set of features.
const RECORD: &str = "docs/build-cost.toml";

/// Time between two compilations of the reference crate.
const PAUSE: Duration = Duration::from_secs(20);

/// A set of Cargo features with the budget of its build.
#[derive(Debug)]
pub struct FeatureSet {
    /// Name on the command line and in the record.
    pub name: &'static str,
    /// Arguments of `cargo build`.
    arguments: &'static [&'static str],
    /// Limit for the CPU seconds of a cold build.
    pub budget: f64,
}

/// The sets from the smallest to the largest.
pub const SETS: [FeatureSet; 3] = [
    FeatureSet {
        name: "minimal",
        arguments: &["--no-default-features"],
        budget: 480.0,
    },
    FeatureSet {
        name: "default",
        arguments: &[],
        budget: 530.0,
    },
    FeatureSet {
        name: "full",
        arguments: &["--features", "full"],
        budget: 900.0,
    },
];

/// The failure to measure a build.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// No set has the requested name.
    #[error("there is no set of features `{name}`, but minimal, default and full")]
    UnknownSet {
        /// Requested name.
        name: String,
    },
    /// A file cannot be read or written, or cargo does not start.
    #[error("cannot {what}: {source}")]
    Io {
        /// The action that failed, as in "start cargo".
        what: &'static str,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The build failed.
    #[error("the build of the set `{set}` failed: {status}")]
    Failed {
        /// Name of the set.
        set: &'static str,
        /// Exit status of cargo.
        status: ExitStatus,
    },
    /// The reference crate does not compile.
    #[error("rustc does not compile the reference crate: {0}")]
    Reference(ExitStatus),
    /// `/proc/self/stat` has another format.
    #[error("cannot read the CPU time of child processes from /proc/self/stat")]
    NoCpuTime,
}

/// Finds a set by its name.
///
/// # Errors
/// There is no such set.
pub fn set(name: &str) -> Result<&'static FeatureSet, BuildError> {
    let found = SETS.iter().find(|it| it.name == name);
    found.ok_or_else(|| BuildError::UnknownSet {
        name: name.to_owned(),
    })
}

/// The cost of a build.
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// CPU seconds on this machine.
    pub seconds: f64,
    /// Speed of this machine during the build, as a multiple of that of the machine for which the budgets are set.
    pub speed: f64,
}

impl Cost {
    /// Returns the CPU seconds on a machine of speed 1, for which the budgets are set.
    #[must_use]
    pub fn scaled(self) -> f64 {
        self.seconds * self.speed
    }
}

/// Builds a set in a target folder and returns the cost. The folder must be empty: a set that is built on top of another one compiles nearly everything
/// again, because other features of `syn` change every derive macro.
///
/// # Errors
/// A build fails, or CPU time cannot be read.
pub fn measure(root: &Path, target: &Path, set: &FeatureSet) -> Result<Cost, BuildError> {
    let before = children_cpu_seconds()?;
    let mut cargo = build(root, target, set)?;
    // While the set is built, because the speed of a processor that other machines share changes within minutes. The processes
    // that cargo starts are not counted until cargo itself has been waited for, so both can be told apart.
    let mut references = Vec::new();
    let status = loop {
        references.push(reference::measure()?);
        if let Some(status) = wait(&mut cargo, PAUSE)? {
            break status;
        }
    };
    if !status.success() {
        let set = set.name;
        return Err(BuildError::Failed { set, status });
    }
    let reference_seconds: f64 = references.iter().sum();
    let seconds = children_cpu_seconds()? - before - reference_seconds;
    let speed = reference::CPU_SECONDS * references.len() as f64 / reference_seconds;
    Ok(Cost { seconds, speed })
}

/// Starts the build of a set.
fn build(root: &Path, target: &Path, set: &FeatureSet) -> Result<Child, BuildError> {
    Command::new("cargo")
        .args(["build", "--release", "--locked", "--quiet"])
        .args(["--package", "asmotion"])
        .args(set.arguments)
        .current_dir(root)
        .env("CARGO_TARGET_DIR", target)
        .env("CARGO_INCREMENTAL", "0")
        // a compiler cache would hide the cost
        .env_remove("RUSTC_WRAPPER")
        .spawn()
        .map_err(cannot("start cargo"))
}

/// Waits for the end of a process, not longer than `limit`. Returns nothing if it still runs.
fn wait(child: &mut Child, limit: Duration) -> Result<Option<ExitStatus>, BuildError> {
    let begun = Instant::now();
    loop {
        let status = child.try_wait().map_err(cannot("wait for cargo"))?;
        if status.is_some() || begun.elapsed() >= limit {
            return Ok(status);
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Wraps an error of the operating system with the action that failed.
fn cannot(what: &'static str) -> impl Fn(std::io::Error) -> BuildError {
    move |source| BuildError::Io { what, source }
}

/// Returns the CPU seconds of all child processes that have ended, including their own children
/// (proc(5), `cutime` and `cstime`).
fn children_cpu_seconds() -> Result<f64, BuildError> {
    let stat =
        std::fs::read_to_string("/proc/self/stat").map_err(cannot("read /proc/self/stat"))?;
    cpu_seconds_in(&stat).ok_or(BuildError::NoCpuTime)
}

/// Parses fields 16 and 17, in ticks of 1/100 s on every architecture that Linux currently
/// supports.
fn cpu_seconds_in(stat: &str) -> Option<f64> {
    // field 2, the name of the program, may contain blanks and parentheses
    let (_, after_name) = stat.rsplit_once(')')?;
    let mut fields = after_name.split_whitespace().skip(13);
    let ticks = |field: Option<&str>| field?.parse::<f64>().ok();
    Some((ticks(fields.next())? + ticks(fields.next())?) / 100.0)
}

/// Records the cost of cold builds for `cargo xtask house`.
///
/// # Errors
/// The record cannot be written.
pub fn record(root: &Path, figures: &[(&FeatureSet, f64)]) -> Result<(), BuildError> {
    let mut text = "# CPU seconds of cold builds: `cargo xtask build-cost --record`\n".to_owned();
    for (set, seconds) in figures {
        let (name, budget) = (set.name, set.budget);
        text += &format!("\n[{name}]\ncpu_seconds = {seconds:.1}\nbudget = {budget:.1}\n");
    }
    std::fs::write(root.join(RECORD), text).map_err(cannot("write docs/build-cost.toml"))
}

/// Returns a row for each recorded set of features; empty without a record.
pub fn rows(root: &Path) -> Rows {
    let text = std::fs::read_to_string(root.join(RECORD)).unwrap_or_default();
    let Ok(record) = toml::from_str::<toml::Table>(&text) else {
        return Rows::new();
    };
    let sets = record.iter().filter_map(|(set, values)| {
        let seconds = values.as_table()?.get("cpu_seconds")?;
        let seconds = seconds
            .as_float()
            .or_else(|| seconds.as_integer().map(|it| it as f64))?;
        Some((
            format!("cold build, `{set}`, CPU seconds"),
            format!("{seconds:.0}"),
        ))
    });
    sets.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cpu_time_of_children_is_read_behind_the_name() {
        let stat = "42 (a b) c) S 1 42 42 0 -1 4194304 1 2 3 4 10 20 3050 150 20 0 1 0 999";
        assert_eq!(cpu_seconds_in(stat), Some(32.0));
        assert_eq!(cpu_seconds_in("42 (x) S 1"), None);
    }

    #[test]
    fn sets_are_found_by_name() {
        assert_eq!(set("full").unwrap().name, "full");
        let error = set("all").unwrap_err().to_string();
        assert!(error.contains("minimal, default and full"), "{error}");
    }
}
