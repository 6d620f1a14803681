//! Cargo features of this build: the only list of all features, of their contents, and of the way to enable them.

use std::ffi::OsString;
use std::fmt;
use std::marker::PhantomData;

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;

/// Part of asmotion that a build may leave out, to compile faster.
pub trait Feature {
    /// Name in `Cargo.toml`.
    const NAME: &'static str;
    /// The subject of the sentence "… is not in this build".
    const BRINGS: &'static str;
}

/// Systems on RabbitMQ: `run --bus`, and the commands that inspect and control a running system.
pub struct Amqp;

/// Services over HTTP: gateways of composites, and wires to other systems.
pub struct Http;

/// ROS: the built-in `ros-bridge`, `ros types`, `ros list` and `ros echo`.
pub struct Ros;

/// Composites of the Service Component Architecture, and RTT's property files.
pub struct Scdl;

/// Decision diagrams: `verify --engine symbolic`.
pub struct Symbolic;

/// Terminal user interface: `top` and `run --top`.
pub struct Tui;

impl Feature for Amqp {
    const NAME: &'static str = "amqp";
    const BRINGS: &'static str = "the bus over RabbitMQ";
}

impl Feature for Http {
    const NAME: &'static str = "http";
    const BRINGS: &'static str = "the gateway and client for services over HTTP";
}

impl Feature for Ros {
    const NAME: &'static str = "ros";
    const BRINGS: &'static str = "the bridge to ROS";
}

impl Feature for Scdl {
    const NAME: &'static str = "scdl";
    const BRINGS: &'static str = "the reader and writer of SCDL";
}

impl Feature for Symbolic {
    const NAME: &'static str = "symbolic";
    const BRINGS: &'static str = "the symbolic engine of `verify`";
}

impl Feature for Tui {
    const NAME: &'static str = "tui";
    const BRINGS: &'static str = "the terminal monitor";
}

/// The error for a request that needs a feature this build does not have. Its text explains how to get it.
#[derive(Debug, thiserror::Error)]
#[error(
    "{brings} is not in this build: it needs the feature `{feature}`\n  \
     asmotion itself: `cargo install --path . --features {feature}` adds it, `--features full` adds everything\n  \
     a program of your own: `cargo run --features {feature} -- …`, with `{feature} = [\"asmotion/{feature}\"]` in the \
     `[features]` of its Cargo.toml"
)]
pub struct LeftOut {
    brings: &'static str,
    feature: &'static str,
}

impl LeftOut {
    /// The error for the missing feature `F`.
    pub fn new<F: Feature>() -> Self {
        let (brings, feature) = (F::BRINGS, F::NAME);
        Self { brings, feature }
    }
}

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

    #[test]
    fn what_is_missing_says_how_to_get_it() {
        let said = LeftOut::new::<Scdl>().to_string();
        assert!(said.starts_with("the reader and writer of SCDL is not in this build"));
        for way in [
            "cargo install --path . --features scdl`",
            "cargo run --features scdl -- …`",
            "`scdl = [\"asmotion/scdl\"]` in the `[features]` of its Cargo.toml",
        ] {
            assert!(said.contains(way), "{said}");
        }
        let said = LeftOut::new::<Symbolic>().to_string();
        assert!(said.starts_with("the symbolic engine of `verify` is not in this build"));
        assert!(
            said.contains("cargo install --path . --features symbolic`"),
            "{said}"
        );
    }
}
