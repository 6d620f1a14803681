//! The run that files show, and these files.

use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_verify::{CheckedProperty, Run, Verification};
use std::path::PathBuf;

/// Returns the first property whose violation a run shows, or else the first one for which there is a run.
pub fn shown(verification: &Verification) -> Option<(&CheckedProperty, &Run)> {
    let properties = verification.properties.iter();
    let mut shown = properties.filter_map(|it| Some((it, it.verdict.run()?)));
    let violated = shown.clone().find(|(it, _)| it.verdict.is_violated());
    violated.or_else(|| shown.next())
}

/// Writes files.
pub fn save(files: &[(PathBuf, String)], terminal: &mut TerminalOutput) -> Exit {
    for (path, text) in files {
        if let Err(error) = std::fs::write(path, text) {
            let path = path.display();
            terminal.error(format_args!("cannot write the run `{path}`: {error}"));
            return Exit::Usage;
        }
    }
    Exit::Ok
}
