//! `asmotion schema`: the JSON Schemas of composite, type and mission files.

use clap::Args;

use crate::exit::Exit;
use crate::terminal::TerminalOutput;

/// Prints the JSON Schema of composite files, for editors.
#[derive(Args)]
pub struct Schema {
    /// Prints the schema of message type files instead
    #[arg(long, conflicts_with = "missions")]
    types: bool,

    /// Prints the schema of mission files instead
    #[arg(long)]
    missions: bool,
}

impl Schema {
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        let schema = if self.types {
            asmotion_composite::schema::types()
        } else if self.missions {
            asmotion_composite::schema::mission()
        } else {
            asmotion_composite::schema::composite()
        };
        terminal.result(format_args!("{schema:#}"));
        Exit::Ok
    }
}
