//! `asmotion reconfigure`: applies a new version of a composite to the running system.

use crate::broker::BrokerArguments;
use crate::build::Build;
use crate::exit::Exit;
use crate::files::{DiskLoader, Remembering};
use crate::mission::{CompositeVersion, reconfigure_address};
use crate::terminal::TerminalOutput;
use asmotion_composite::NoPrograms;
use asmotion_datum::Datum;
use asmotion_plan::beside;
use asmotion_remote::{Remote, RemoteError, RobotPresence};
use clap::Args;
use std::collections::BTreeSet;
use std::time::Duration;

/// Applies the composite's current version to the running system without a restart: in all its processes or in none.
#[derive(Args)]
pub struct Reconfigure {
    /// Composite file
    composite: String,

    /// Lists the changes without applying them
    #[arg(long = "try")]
    only_try: bool,

    /// Robot name, if several robots run the composite
    #[arg(long)]
    robot: Option<String>,

    /// Sets a property of the composite (`place=lab`), as for `asmotion run`
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,

    #[command(flatten)]
    broker: BrokerArguments,
}

/// Time limit for a process to check a version.
const PATIENCE: Duration = Duration::from_secs(20);

impl Reconfigure {
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let files = Remembering::new(&DiskLoader);
        let settings = self.set.iter().filter_map(|set| set.split_once('='));
        let settings: Vec<_> = settings
            .map(|(name, value)| (name.to_owned(), value.to_owned()))
            .collect();
        let opened = build.open_with(&self.composite, &settings, &files, &NoPrograms);
        let mut report = opened.report.clone();
        // the running processes know the components of other robots, and refuse those that they have not asked
        report.diagnostics.retain(|it| it.code.name != "C159");
        terminal.report(&report, &opened.sources);
        let planned = opened.processes();
        let planned: BTreeSet<String> = planned.into_iter().map(str::to_owned).collect();
        let Some(composite) = opened.composite.filter(|_| !opened.report.has_errors()) else {
            return Exit::refused(&self.composite);
        };
        let relative = |path: &str| beside(&opened.path, path);
        let version = CompositeVersion {
            composite: relative(&opened.path),
            files: files
                .read()
                .into_iter()
                .map(|(path, text)| (relative(&path), text.to_string()))
                .collect(),
            only_try: true,
        };
        let version = (version, planned);
        let result = self
            .broker
            .remote(build)
            .and_then(|remote| self.change(&remote, &composite.name(), version, terminal));
        result.unwrap_or_else(|problem| {
            terminal.error(problem);
            Exit::Usage
        })
    }

    /// Asks every process whether it can apply the version, then tells all of them to do so. `planned` are the processes of
    /// the composite.
    fn change(
        &self,
        remote: &Remote,
        name: &str,
        (version, planned): (CompositeVersion, BTreeSet<String>),
        terminal: &mut TerminalOutput,
    ) -> Result<Exit, String> {
        let is_of = |it: &RobotPresence| {
            let is_robot = self.robot.as_ref().is_none_or(|robot| *robot == it.robot);
            is_robot && it.presence.composite == name
        };
        // a process whose presence is late would keep the old version while the others change
        let mut processes = remote.processes_until(|found| {
            let running = found.iter().filter(|it| is_of(it));
            absent(running, planned.clone()).is_empty()
        });
        processes.retain(is_of);
        match &*processes {
            [] => return Err(format!("no process of `{name}` is running")),
            [first, others @ ..] if others.iter().any(|it| it.robot != first.robot) => {
                return Err(format!(
                    "several robots run `{name}`: select one with `--robot`"
                ));
            }
            [_, ..] => {}
        }
        for absent in absent(&processes, planned) {
            terminal.warn(format_args!(
                "`{absent}` does not run: it begins with the version in the file with which it is started"
            ));
        }
        let request_all = |version: &CompositeVersion| -> Vec<Result<Vec<String>, RemoteError>> {
            let threads = processes
                .iter()
                .map(|it| request_change(remote, it, version));
            threads.collect()
        };
        let tried = request_all(&version);
        if tried.iter().all(Result::is_ok) && !self.only_try {
            let version = CompositeVersion {
                only_try: false,
                ..version
            };
            return Ok(report_replies(&processes, request_all(&version), terminal));
        }
        let exit = report_replies(&processes, tried, terminal);
        terminal.status("Unchanged", format_args!("`{name}` runs unchanged"));
        Ok(exit)
    }
}

/// The planned processes that do not run, unless one process runs all components.
fn absent<'a>(
    running: impl IntoIterator<Item = &'a RobotPresence>,
    mut planned: BTreeSet<String>,
) -> BTreeSet<String> {
    for process in running {
        if !planned.remove(&process.presence.process) {
            return BTreeSet::new();
        }
    }
    planned
}

/// Asks one process to check or apply a version; returns the list of changes.
fn request_change(
    remote: &Remote,
    process: &RobotPresence,
    version: &CompositeVersion,
) -> Result<Vec<String>, RemoteError> {
    let address = process.key(&reconfigure_address(&process.presence.process));
    let answer = remote.call(&address, Datum::of(version)?, PATIENCE)?;
    Ok(answer.to()?)
}

/// Prints the replies of all processes.
fn report_replies(
    processes: &[RobotPresence],
    replies: Vec<Result<Vec<String>, RemoteError>>,
    terminal: &mut TerminalOutput,
) -> Exit {
    let mut exit = Exit::Ok;
    for (process, answer) in processes.iter().zip(replies) {
        let process = &process.presence.process;
        match answer {
            Ok(changes) => {
                for change in &changes {
                    terminal.result(format_args!("{process}: {change}"));
                }
                if changes.is_empty() {
                    terminal.result(format_args!("{process}: no changes"));
                }
            }
            Err(error) => {
                terminal.error(format_args!("{process}: {error}"));
                exit = Exit::Findings;
            }
        }
    }
    exit
}
