//! `asmotion graph`: a picture of a composite.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::build;
use crate::exit::Exit;
use crate::files::{Disk, reason};
use crate::mission::MissionError;
use crate::terminal::Terminal;

/// Draws a composite: components, topics, services and references, and what joins them.
#[derive(Args)]
pub struct Graph {
    /// The composite.
    composite: String,

    /// Which of its profiles.
    #[arg(long)]
    profile: Option<String>,

    /// How it is drawn.
    #[arg(long, value_enum, default_value_t = Format::Svg)]
    format: Format,

    /// The file that the picture goes to; without it, it is shown.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// How a composite is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For Graphviz.
    Dot,
    /// For Mermaid.
    Mermaid,
    /// As a picture.
    Svg,
}

impl Graph {
    /// Draws it.
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
        let picture = match self.format {
            Format::Dot => asmotion_drawing::dot(plan),
            Format::Mermaid => asmotion_drawing::mermaid(plan),
            Format::Svg => asmotion_drawing::svg(plan),
        };
        let Some(path) = self.output else {
            terminal.result(picture.trim_end());
            return Exit::Ok;
        };
        match std::fs::write(&path, picture) {
            Ok(()) => {
                terminal.status("Drew", path.display());
                Exit::Ok
            }
            Err(error) => {
                let path = path.display();
                terminal.error(format_args!("cannot write `{path}`: {}", reason(&error)));
                Exit::Usage
            }
        }
    }
}
