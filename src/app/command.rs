//! Commands that a program adds to those of asmotion.

use clap::ArgMatches;

use super::App;
use crate::exit::Exit;

/// A command of a program, beside those of asmotion. Its arguments are the fields of a struct, and the documentation of the
/// struct is its help text; see [`App::command`].
pub trait AppCommand: clap::Args {
    /// Name on the command line.
    const NAME: &'static str;

    /// Executes the command.
    fn run(self, app: &App) -> Exit;
}

/// A registered command.
#[derive(Clone, Copy, Debug)]
pub(super) struct RegisteredCommand {
    pub(super) name: &'static str,
    describe: fn(clap::Command) -> clap::Command,
    run: fn(&ArgMatches, &App) -> Result<Exit, clap::Error>,
}

impl RegisteredCommand {
    pub(super) fn of<C: AppCommand>() -> Self {
        Self {
            name: C::NAME,
            describe: C::augment_args,
            run: |matches, app| C::from_arg_matches(matches).map(|command| command.run(app)),
        }
    }

    /// The command with its arguments, for the command line.
    pub(super) fn describe(&self) -> clap::Command {
        (self.describe)(clap::Command::new(self.name))
    }

    /// Executes the command with parsed arguments.
    pub(super) fn run(&self, matches: &ArgMatches, app: &App) -> Result<Exit, clap::Error> {
        (self.run)(matches, app)
    }
}
