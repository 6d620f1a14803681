//! A program: the components, messages and commands that it contains, and its command line.

mod command;

pub use command::AppCommand;

use std::ffi::OsString;
use std::process::ExitCode;

use asmotion_component::{Component, Interface, Operation};
use asmotion_datum::Message;
use asmotion_map::MapFormat;
use asmotion_planner::MakePlanner;
use clap::{CommandFactory, FromArgMatches, Parser};

use crate::build::Build;
use crate::command::{Command, mark};
use crate::exit::Exit;
use crate::mission::Mission;
use crate::terminal::{Colour, TerminalOutput};
use crate::transport::ConnectTransport;
use command::RegisteredCommand;

/// A program that runs composites: the engine and all commands of `asmotion`, with the components of the program's author.
///
/// ```no_run
/// use asmotion_component::{Component, Cycle, Fault, Interface};
///
/// struct Gripper;
///
/// impl Gripper {
///     fn new(_: &mut Interface) -> Self {
///         Self
///     }
/// }
///
/// impl Component for Gripper {
///     fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
///         Ok(())
///     }
/// }
///
/// fn main() -> std::process::ExitCode {
///     asmotion::App::standard()
///         .component("acme::Gripper", Gripper::new)
///         .main()
/// }
/// ```
#[derive(Clone, Debug)]
pub struct App {
    name: &'static str,
    version: &'static str,
    build: Build,
    commands: Vec<RegisteredCommand>,
}

impl App {
    /// A program with the components, messages and commands of `asmotion`.
    pub fn standard() -> Self {
        Self {
            name: "asmotion",
            version: env!("CARGO_PKG_VERSION"),
            build: Build::standard(),
            commands: Vec::new(),
        }
    }

    /// Sets the name and version that `--help` and `--version` show; those of asmotion by default.
    pub fn name(mut self, name: &'static str, version: &'static str) -> Self {
        (self.name, self.version) = (name, version);
        self
    }

    /// Adds a component under the name that composites use (`implementation = { rust = "acme::Gripper" }`), with the types of
    /// its ports and the operations of its services and references. `new` declares the component on the interface, and
    /// declares the same at each call.
    ///
    /// A name that is taken is an error, which [`main`](Self::main) reports.
    pub fn component<C: Component>(
        mut self,
        name: &str,
        new: impl Fn(&mut Interface) -> C + Send + Sync + 'static,
    ) -> Self {
        self.build.add_component(name, new);
        self
    }

    /// Adds the protocol of a component: the text of a specification of what it sends, depending on what it receives, with
    /// which `asmotion verify` verifies the specifications of composites.
    pub fn protocol(mut self, component: &str, protocol: &str) -> Self {
        self.build.add_protocol(component, protocol);
        self
    }

    /// Adds a message type, for composites whose specifications send or receive it while no component has a port of this
    /// type.
    pub fn message<M: Message>(mut self) -> Self {
        self.build.add_message::<M>();
        self
    }

    /// Adds an operation to its service interface, for composites in which no component of this program provides or calls
    /// it.
    pub fn operation<O: Operation>(mut self) -> Self {
        self.build.add_operation::<O>();
        self
    }

    /// Adds a map format, which `nav::MapServer` reads. Its endings win over those of the other formats. The name is for
    /// programs; [`contract::map_format`](crate::contract::map_format) tests a format.
    pub fn map_format(mut self, name: &'static str, format: &'static dyn MapFormat) -> Self {
        self.build.add_map_format(name, format);
        self
    }

    /// Adds a planner, which `nav::TrajectoryPlanner` uses if its property `algorithm` has this name. A name that is taken
    /// replaces the earlier planner. [`contract::planner`](crate::contract::planner) tests a planner.
    pub fn planner(mut self, name: &'static str, make: MakePlanner) -> Self {
        self.build.add_planner(name, make);
        self
    }

    /// Adds a transport for brokers whose addresses have this scheme (`--bus mqtt://…`, or the `url` of a broker in a
    /// composite). A scheme that is taken replaces the earlier transport. [`contract::bus`](crate::contract::bus) tests a
    /// transport.
    pub fn transport(mut self, scheme: &'static str, connect: ConnectTransport) -> Self {
        self.build.add_transport(scheme, connect);
        self
    }

    /// Adds a command.
    ///
    /// ```no_run
    /// use asmotion::{App, AppCommand, Exit, clap};
    ///
    /// /// Moves the gripper to its reference position.
    /// #[derive(clap::Args)]
    /// struct Home {
    ///     /// Closes it, too
    ///     #[arg(long)]
    ///     close: bool,
    /// }
    ///
    /// impl AppCommand for Home {
    ///     const NAME: &'static str = "home";
    ///
    ///     fn run(self, app: &App) -> Exit {
    ///         println!("{} components", app.build().catalogue().components().len());
    ///         Exit::Ok
    ///     }
    /// }
    ///
    /// fn main() -> std::process::ExitCode {
    ///     App::standard().command::<Home>().main()
    /// }
    /// ```
    pub fn command<C: AppCommand>(mut self) -> Self {
        self.commands.push(RegisteredCommand::of::<C>());
        self
    }

    /// The contents of the program: what composites can name.
    pub fn build(&self) -> &Build {
        &self.build
    }

    /// A mission of a composite with the components of this program; see [`Mission::new`].
    pub fn mission(&self, composite: impl Into<String>) -> Mission {
        Mission::with_build(&self.build, composite)
    }

    /// Parses the command line of the process and executes its command.
    pub fn main(self) -> ExitCode {
        self.run(std::env::args_os()).into()
    }

    /// Parses a command line, whose first argument is the name of the program, and executes its command.
    pub fn run(&self, arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> Exit {
        let problems = self.problems();
        if !problems.is_empty() {
            let mut terminal = TerminalOutput::new(Colour::Auto);
            for problem in problems {
                terminal.error(problem);
            }
            return Exit::Usage;
        }
        let matches = match self.command_line().try_get_matches_from(arguments) {
            Ok(matches) => matches,
            Err(error) => return print(&error),
        };
        let registered = matches.subcommand().and_then(|(name, matches)| {
            let mut commands = self.commands.iter();
            Some((commands.find(|it| it.name == name)?, matches))
        });
        let colour = matches.get_one("color").copied().unwrap_or_default();
        let mut terminal = TerminalOutput::new(colour);
        let result = match registered {
            Some((command, matches)) => command.run(matches, self),
            None => Arguments::from_arg_matches(&matches)
                .map(|arguments| arguments.command.run(&self.build, &mut terminal)),
        };
        let exit = result.unwrap_or_else(|error| print(&error));
        match terminal.lost() {
            Some(error) => {
                terminal.error(format_args!("cannot write the result: {error}"));
                // the line above
                let _ = terminal.lost();
                exit.max(Exit::Usage)
            }
            None => exit,
        }
    }

    /// Contradictions between the additions to the program.
    pub fn problems(&self) -> Vec<String> {
        let standard = Arguments::command();
        let taken = self.commands.iter().enumerate().filter(move |(at, it)| {
            let mut before = self.commands[..*at].iter();
            standard.find_subcommand(it.name).is_some() || before.any(|one| one.name == it.name)
        });
        let taken = taken.map(|(_, it)| {
            let name = it.name;
            format!("command `{name}` is registered twice: give one of them another name")
        });
        self.build.problems().iter().cloned().chain(taken).collect()
    }

    fn command_line(&self) -> clap::Command {
        let added = self.commands.iter().map(RegisteredCommand::describe);
        mark(Arguments::command())
            .name(self.name)
            .version(self.version)
            .subcommands(added)
    }
}

/// Prints an error of the command line, or the help text, which clap treats as an error.
fn print(error: &clap::Error) -> Exit {
    // a failing standard output cannot be reported anywhere
    let _ = error.print();
    if error.use_stderr() {
        Exit::Usage
    } else {
        Exit::Ok
    }
}

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
