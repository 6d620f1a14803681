//! `asmotion graph`: draws a composite.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::build::Build;
use crate::exit::Exit;
use crate::files::{DiskLoader, reason};
use crate::mission::MissionError;
use crate::terminal::TerminalOutput;

/// Draws a composite: components, topics, services, references and their connections.
#[derive(Args)]
pub struct Graph {
    /// Composite file
    composite: String,

    /// Profile of the composite
    #[arg(long)]
    profile: Option<String>,

    /// Output format
    #[arg(long, value_enum, default_value_t = GraphFormat::Svg)]
    format: GraphFormat,

    /// Output file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Format of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum GraphFormat {
    /// Graphviz
    Dot,
    /// Mermaid
    Mermaid,
    /// SVG image
    Svg,
}

impl Graph {
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
        let picture = match self.format {
            GraphFormat::Dot => asmotion_drawing::dot(plan),
            GraphFormat::Mermaid => asmotion_drawing::mermaid(plan),
            GraphFormat::Svg => asmotion_drawing::svg(plan),
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
