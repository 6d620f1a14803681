//! Runs as files.

use super::Verify;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_verify::{CheckedProperty, Verification};

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
        match std::fs::write(path, &run.trace) {
            Ok(()) => Exit::Ok,
            Err(error) => {
                let path = path.display();
                terminal.error(format_args!("cannot write the trace `{path}`: {error}"));
                Exit::Usage
            }
        }
    }
}
