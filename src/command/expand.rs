//! `asmotion expand`: a composite opened up, with everything filled in.

use clap::Args;

use crate::build;
use crate::exit::Exit;
use crate::files::Disk;
use crate::mission::MissionError;
use crate::terminal::Terminal;

/// Shows a composite opened up: nested ones in their places, defaults filled in, secrets left out.
#[derive(Args)]
pub struct Expand {
    /// The composite.
    composite: String,

    /// Which of its profiles.
    #[arg(long)]
    profile: Option<String>,
}

impl Expand {
    /// Expands it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let opened = build::open(&self.composite, &[], &Disk);
        terminal.report(&opened.report, &opened.sources);
        if opened.report.has_errors() {
            return Exit::refused(&self.composite);
        }
        let Some(plan) = opened.plan(self.profile.as_deref()) else {
            let (wanted, known) = (self.profile, opened.profiles);
            terminal.error(MissionError::Profile { wanted, known });
            return Exit::Usage;
        };
        if !plan.missing.is_empty() {
            let missing = plan.missing.join("`, `");
            terminal.error(format_args!(
                "set `{missing}`: without it nobody knows what it stands for"
            ));
            return Exit::Usage;
        }
        terminal.result(asmotion_assembly::expand(&opened, plan).trim_end());
        Exit::Ok
    }
}
