//! Commands that need a feature this build does not have.
#![cfg_attr(
    all(
        feature = "amqp",
        feature = "dashboard",
        feature = "mcap",
        feature = "ros",
        feature = "scdl",
        feature = "tui"
    ),
    allow(dead_code, reason = "this build has all commands")
)]

use std::ffi::OsString;
use std::fmt;
use std::marker::PhantomData;

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

use crate::build::Build;
use crate::exit::Exit;
use crate::feature::{Feature, LeftOut};
use crate::terminal::TerminalOutput;

/// Replaces a command that needs the feature `F`: accepts any arguments, and explains how to get the feature.
pub struct Without<F>(PhantomData<F>);

impl<F: Feature> Without<F> {
    /// Prints the error.
    pub fn run(self, _: &Build, terminal: &mut TerminalOutput) -> Exit {
        terminal.error(LeftOut::new::<F>());
        Exit::Usage
    }
}

/// Name of the argument by which [`mark`] recognises a replaced command; its help text is the feature's name.
const ANYTHING: &str = "anything";

impl<F: Feature> Args for Without<F> {
    fn augment_args(command: Command) -> Command {
        let anything = Arg::new(ANYTHING)
            .help(F::NAME)
            .value_parser(clap::value_parser!(OsString))
            .num_args(0..)
            .trailing_var_arg(true)
            .allow_hyphen_values(true)
            .hide(true);
        command.disable_help_flag(true).arg(anything)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<F> FromArgMatches for Without<F> {
    fn from_arg_matches(_: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(PhantomData))
    }

    fn update_from_arg_matches(&mut self, _: &ArgMatches) -> Result<(), clap::Error> {
        Ok(())
    }
}

/// Marks the commands whose feature is missing in the list of `--help`.
pub fn mark(mut command: Command) -> Command {
    for subcommand in command.get_subcommands_mut() {
        let stands_in = |argument: &&Arg| argument.get_id() == ANYTHING;
        let feature = subcommand.get_arguments().find(stands_in);
        let Some(feature) = feature.and_then(Arg::get_help).map(ToString::to_string) else {
            continue;
        };
        let about = subcommand.get_about().map(ToString::to_string);
        let about = about.unwrap_or_default();
        let marked = std::mem::take(subcommand);
        *subcommand = marked.about(format!("{about} [needs the feature `{feature}`]"));
    }
    command
}

impl<F: Feature> fmt::Debug for Without<F> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "Without<{}>", F::NAME)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feature::Amqp;
    use clap::{CommandFactory, Parser};

    #[derive(Debug, Parser)]
    #[command(name = "asmotion")]
    enum Line {
        /// Shows topics
        Topic(Without<Amqp>),
        /// Is always there
        Check,
    }

    #[test]
    fn a_command_that_was_left_out_takes_any_arguments() {
        for line in [
            "asmotion topic",
            "asmotion topic list --bus amqp://h",
            "asmotion topic --help",
            "asmotion topic pub cmd_vel {x=1} -- --json -q",
        ] {
            let read = Line::try_parse_from(line.split(' '));
            assert!(matches!(read, Ok(Line::Topic(_))), "{line}: {read:?}");
        }
        assert!(Line::try_parse_from(["asmotion", "check", "--bus"]).is_err());
    }

    #[test]
    fn it_is_marked_where_commands_are_listed() {
        let help = mark(Line::command()).render_help().to_string();
        assert!(
            help.contains("Shows topics [needs the feature `amqp`]"),
            "{help}"
        );
        assert!(help.contains("Is always there\n"), "{help}");
    }
}
