//! Runs as files.

use super::Verify;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_verify::{CheckedProperty, Verification};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

impl Verify {
    /// Writes the trace of the first violation, if there is one and it was requested.
    pub(super) fn write(&self, verification: &Verification, terminal: &mut TerminalOutput) -> Exit {
        let Some(path) = &self.trace else {
            return Exit::Ok;
        };
        let violated = |property: &&CheckedProperty| property.verdict.is_violated();
        let mut properties = verification.properties.iter();
        let shown = properties
            .clone()
            .find(|it| violated(it) && it.verdict.run().is_some());
        let run = shown.or_else(|| properties.find(|it| it.verdict.run().is_some()));
        let Some(run) = run.and_then(|property| property.verdict.run()) else {
            terminal.warn(format_args!(
                "there is no run to write to `{}`",
                path.display()
            ));
            return Exit::Ok;
        };
        for (machine, trace) in verification.machines.iter().zip(&run.traces) {
            let path = match verification.machines.as_slice() {
                [_] => path.clone(),
                _ => path_of(path, &machine.name),
            };
            if let Err(error) = std::fs::write(&path, trace) {
                let path = path.display();
                terminal.error(format_args!("cannot write the trace `{path}`: {error}"));
                return Exit::Usage;
            }
        }
        Exit::Ok
    }
}

/// The path of a machine's trace: `run.trace` becomes `run.courier.trace`.
fn path_of(path: &Path, machine: &str) -> PathBuf {
    match path.extension() {
        Some(extension) => {
            let mut name = OsString::from(machine);
            name.push(".");
            name.push(extension);
            path.with_extension(name)
        }
        None => path.with_extension(machine),
    }
}
