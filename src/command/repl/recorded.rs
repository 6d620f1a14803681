//! Sessions that repeat the steps of a recorded coordinator.

use std::path::PathBuf;

use asmotion_coordinator::{MachineBegin, MachineOrigin};
use asmotion_diagnostics::{or_did_you_mean, similar};
use asmotion_lang::simulate::{self, Recording};
use asmotion_lang::{OpenFailure, Session};
use asmotion_recording::{RecordedMachine, RecordedMachines, RunFiles};

use super::{Repl, ReplStart, refused};
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::terminal::TerminalOutput;

/// Opens a recording; `None` if the file is none.
pub(super) fn files(path: &str) -> Option<RunFiles> {
    let groups = RunFiles::group(&[PathBuf::from(path)]);
    groups.into_iter().find_map(Result::ok)
}

impl Repl {
    /// Opens a session at the beginning of a recorded machine.
    pub(super) fn of_recording(
        &self,
        files: &RunFiles,
        terminal: &mut TerminalOutput,
    ) -> Result<ReplStart, Exit> {
        let usage = |error: String, terminal: &mut TerminalOutput| {
            let path = files.path.display();
            terminal.error(format_args!("`{path}`: {error}"));
            Exit::Usage
        };
        let read = RecordedMachines::read(files);
        let read = read.map_err(|error| usage(error.to_string(), terminal))?;
        let selected = self.select(&read).map_err(|error| usage(error, terminal))?;
        let SelectedMachine { machine, others } = selected;
        let opened = match &self.spec {
            Some(path) => asmotion_lang::open(path, &DiskLoader),
            None => {
                let opened = read.specification(machine);
                Ok(opened.map_err(|error| usage(error.to_string(), terminal))?)
            }
        };
        let recorded = machine.begin.sources.first();
        let recorded = recorded.map_or("", |source| &*source.path);
        let path = self.spec.clone().unwrap_or_else(|| recorded.to_owned());
        let failed = |failure: OpenFailure, terminal: &mut TerminalOutput| {
            let exit = refused(failure, &path, terminal);
            // the text of a recording is no file
            if self.spec.is_some() {
                exit
            } else {
                Exit::Usage
            }
        };
        let session = opened.and_then(Session::new);
        let mut session = session.map_err(|failure| failed(failure, terminal))?;
        set_agents(&machine.begin, &mut session);
        for (number, time_ns) in others {
            let seconds = time_ns as f64 / 1e9;
            terminal.progress(format_args!(
                "machine {number} began at {seconds:.3} s: `--machine {number}` selects it"
            ));
        }
        if let Some((number, rule)) = &machine.safe_step {
            terminal.warn(format_args!(
                "the session ends before step {number}, which the safe rule `{rule}` made: `asmotion replay --until {number}` shows the \
                 state after it"
            ));
        }
        Ok(ReplStart {
            path,
            session,
            recording: Recording::of_steps(machine.steps.clone()),
        })
    }

    /// Selects a machine.
    fn select<'r>(&self, read: &'r RecordedMachines) -> Result<SelectedMachine<'r>, String> {
        let names: Vec<&String> = read.machines.keys().collect();
        let listed = || {
            let names = names.iter().map(|name| format!("`{name}`"));
            names.collect::<Vec<_>>().join(", ")
        };
        let machines = match (&self.component, names.as_slice()) {
            (_, []) => return Err("it has no steps of a coordinator".to_owned()),
            (Some(name), _) => read.machines.get(name).ok_or_else(|| {
                let hint = or_did_you_mean(similar(name, names.clone()).map(String::as_str));
                format!("it has no coordinator `{name}`{hint}; it has {}", listed())
            })?,
            (None, [only]) => read.machines.get(*only).ok_or_else(String::new)?,
            (None, _) => {
                let listed = listed();
                return Err(format!(
                    "it has several coordinators: select one of {listed} with `--component`"
                ));
            }
        };
        let index = self.machine.checked_sub(1);
        let machine = index.and_then(|index| machines.get(index));
        let machine = machine.ok_or_else(|| match machines.len() {
            0 => "its steps are recorded from the middle of the run".to_owned(),
            1 => "the coordinator has one machine, with number 1".to_owned(),
            count => format!("the coordinator has the machines 1 to {count}"),
        })?;
        match &machine.begin.from {
            MachineOrigin::Initial => {}
            MachineOrigin::Predecessor { .. } => {
                return Err(format!(
                    "machine {} took over the state of the one before it, in which a session cannot begin: `asmotion replay --until` \
                     shows its states",
                    self.machine
                ));
            }
            MachineOrigin::Frozen => {
                return Err(
                    "the machine continued from a frozen state, which is not in the recording"
                        .to_owned(),
                );
            }
        }
        let others = (1..)
            .zip(machines)
            .filter(|(number, _)| *number != self.machine);
        Ok(SelectedMachine {
            machine,
            others: others.map(|(number, it)| (number, it.time_ns)).collect(),
        })
    }
}

/// A machine of a coordinator.
struct SelectedMachine<'r> {
    machine: &'r RecordedMachine,
    /// Numbers of the other machines, with the times of their first steps.
    others: Vec<(usize, i64)>,
}

/// Makes the machine send messages where the recorded one did.
fn set_agents(begin: &MachineBegin, session: &mut Session) {
    let agents = begin.agents.iter();
    // an edited specification may not know all of them
    let agents = agents.filter_map(|agent| simulate::agent(agent, &session.machine).ok());
    let agents = agents.collect();
    session.machine.set_partners(agents);
}
