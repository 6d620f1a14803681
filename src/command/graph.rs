//! `asmotion graph`: draws a composite.

use std::path::PathBuf;

use asmotion_drawing::Instances;
use clap::{Args, ValueEnum};

use crate::build::Build;
use crate::exit::Exit;
use crate::files::{DiskLoader, reason};
use crate::mission::MissionError;
use crate::terminal::TerminalOutput;

/// Draws a composite: components, topics, services, references and their connections. Four or more components that differ only in a
/// number, as the instances of an element with `for` do, are drawn as one.
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

    /// Draws each component, also those that differ only in a number
    #[arg(long)]
    each: bool,

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
        let instances = if self.each {
            Instances::Each
        } else {
            Instances::Folded
        };
        let picture = match self.format {
            GraphFormat::Dot => asmotion_drawing::dot(plan, instances),
            GraphFormat::Mermaid => asmotion_drawing::mermaid(plan, instances),
            GraphFormat::Svg => asmotion_drawing::svg(plan, instances),
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
