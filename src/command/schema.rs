//! `asmotion schema`: the dialect of composite files, for editors.

use clap::Args;

use crate::exit::Exit;
use crate::terminal::Terminal;

/// Shows the JSON Schema of composite files, for editors.
#[derive(Args)]
pub struct Schema {
    /// That of files of message types instead.
    #[arg(long)]
    types: bool,
}

impl Schema {
    /// Shows it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let schema = match self.types {
            true => asmotion_assembly::schema::types(),
            false => asmotion_assembly::schema::composite(),
        };
        terminal.result(format_args!("{schema:#}"));
        Exit::Ok
    }
}
