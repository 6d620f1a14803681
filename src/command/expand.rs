//! `asmotion expand`: a composite with nested composites and defaults expanded.

use clap::Args;

use crate::build::Build;
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::mission::MissionError;
use crate::terminal::TerminalOutput;

/// Prints a composite with nested composites expanded, defaults filled in and secrets masked.
#[derive(Args)]
pub struct Expand {
    /// Composite file
    composite: String,

    /// Profile of the composite
    #[arg(long)]
    profile: Option<String>,
}

impl Expand {
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let opened = build.open(&self.composite, &[], &DiskLoader);
        terminal.report(&opened.report, &opened.sources);
        if opened.report.has_errors() {
            return Exit::refused(&self.composite);
        }
        let Some(plan) = opened.plan(self.profile.as_deref()) else {
            let (wanted, known) = (self.profile, opened.profiles);
            terminal.error(MissionError::Profile {
                requested: wanted,
                available: known,
            });
            return Exit::Usage;
        };
        if !plan.missing.is_empty() {
            let missing = plan.missing.join("`, `");
            terminal.error(format_args!("set `{missing}`, which the file refers to"));
            return Exit::Usage;
        }
        terminal.result(asmotion_plan::expand(&opened, plan).trim_end());
        Exit::Ok
    }
}
