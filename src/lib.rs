//! The command line of asmotion: one file for each command, and their shared parts.
//!
//! This is the only crate that prints. [`mission`] assembles and runs a composite; [`story`] prints its events, [`trace`]
//! and [`record`] write them to files.

mod brief;
mod broker;
mod build;
pub mod codes;
mod command;
mod describe;
mod diff;
mod exit;
#[allow(dead_code, reason = "a feature that this build has needs no stand-in")]
mod feature;
mod files;
mod gateway;
#[cfg(any(feature = "amqp", feature = "tui"))]
mod inspection;
pub mod mission;
mod output_files;
mod paths;
mod programs;
mod prompt;
pub mod record;
mod show;
pub mod story;
mod table;
mod terminal;
#[cfg(feature = "tui")]
pub mod top;
pub mod trace;

pub use command::BLOCKED_CORRIDOR;
pub use exit::Exit;
pub use files::DiskLoader;

use clap::{CommandFactory, FromArgMatches, Parser};
use command::Command;
use std::process::ExitCode;
use terminal::{Colour, TerminalOutput};

/// Runs Abstract State Machine specifications as the coordinator of a robot.
#[derive(Parser)]
#[command(name = "asmotion", version, about, after_help = FIRST_STEPS)]
struct Arguments {
    #[command(subcommand)]
    command: Command,

    /// When to use colour: `auto` follows the terminal, `NO_COLOR` and `FORCE_COLOR`
    #[arg(long, global = true, value_enum, default_value_t = Colour::Auto)]
    color: Colour,
}

const FIRST_STEPS: &str = "\
First steps:
  asmotion demo                                              runs a mission with a simulated rover
  asmotion check specs/navigation/navigation.composite.toml  reports errors before anything starts
  asmotion sim specs/patrol/patrol.asm --steps 20            simulates a specification on its own";

/// Parses the command line and executes the command.
pub fn main() -> ExitCode {
    let matches = feature::mark(Arguments::command()).try_get_matches();
    let arguments = match matches.and_then(|matches| Arguments::from_arg_matches(&matches)) {
        Ok(arguments) => arguments,
        Err(error) => {
            // help and version are not errors; a failing standard output cannot be reported anywhere
            let _ = error.print();
            return if error.use_stderr() {
                Exit::Usage.into()
            } else {
                Exit::Ok.into()
            };
        }
    };
    let mut terminal = TerminalOutput::new(arguments.color);
    let exit = arguments.command.run(&mut terminal);
    match terminal.lost() {
        Some(error) => {
            terminal.error(format_args!("cannot write the result: {error}"));
            exit.max(Exit::Usage).into()
        }
        None => exit.into(),
    }
}
