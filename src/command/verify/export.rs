//! Runs as files.

use super::run_files::{save, shown};
use super::{Verify, avalla, itf};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_verify::Verification;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

impl Verify {
    /// Returns `true` if files are to be written.
    pub(super) fn has_exports(&self) -> bool {
        self.trace.is_some() || self.avalla.is_some() || self.itf.is_some()
    }

    /// Warns that there is no run for the files that were requested.
    pub(super) fn nothing_to_write(&self, terminal: &mut TerminalOutput) {
        for path in [&self.trace, &self.avalla, &self.itf].into_iter().flatten() {
            let path = path.display();
            terminal.warn(format_args!("there is no run to write to `{path}`"));
        }
    }

    /// Writes the run of the first violation to the files that were requested.
    pub(super) fn write(
        &self,
        spec: &str,
        verification: &Verification,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        if !self.has_exports() {
            return Exit::Ok;
        }
        let Some((property, run)) = shown(verification) else {
            self.nothing_to_write(terminal);
            return Exit::Ok;
        };
        let mut files: Vec<(PathBuf, String)> = Vec::new();
        let machines = verification.machines.as_slice();
        if let Some(path) = &self.trace {
            for (machine, trace) in machines.iter().zip(&run.traces) {
                let path = match machines {
                    [_] => path.clone(),
                    _ => path_of(path, &machine.name),
                };
                files.push((path, trace.clone()));
            }
        }
        if let Some(path) = &self.avalla {
            let [machine] = machines else {
                terminal
                    .error("a scenario is about one specification: `--avalla` is not for systems");
                return Exit::Usage;
            };
            let paths = (path.as_path(), Path::new(spec));
            let scenario = avalla::scenario(property, run, &machine.specification, paths);
            files.push((path.clone(), scenario));
        }
        if let Some(path) = &self.itf {
            let trace = itf::trace(property, run, spec, machines);
            files.push((path.clone(), format!("{trace:#}\n")));
        }
        save(&files, terminal)
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
