//! The subcommands, one file each.

#[cfg(feature = "amqp")]
mod call;
mod check;
#[cfg(feature = "amqp")]
mod component;
#[cfg(all(feature = "dashboard", feature = "mcap"))]
mod dash;
mod demo;
mod describe;
#[cfg(feature = "amqp")]
mod doctor;
mod expand;
mod fmt;
mod graph;
mod new;
#[cfg(feature = "amqp")]
mod port;
#[cfg(feature = "amqp")]
mod reconfigure;
mod repl;
#[cfg(feature = "mcap")]
mod replay;
#[cfg(feature = "ros")]
mod ros;
mod run;
#[cfg(feature = "scdl")]
mod scdl;
mod schema;
#[cfg(feature = "amqp")]
mod shell;
mod sim;
mod test;
mod tool;
#[cfg(all(feature = "amqp", feature = "tui"))]
mod top;
#[cfg(feature = "amqp")]
mod topic;
mod up;
mod verify;
mod without;

pub use demo::BLOCKED_CORRIDOR;
pub use without::mark;

#[cfg(not(all(
    feature = "amqp",
    feature = "dashboard",
    feature = "mcap",
    feature = "ros",
    feature = "scdl",
    feature = "tui"
)))]
use crate::feature;
#[cfg(not(all(
    feature = "amqp",
    feature = "dashboard",
    feature = "mcap",
    feature = "ros",
    feature = "scdl",
    feature = "tui"
)))]
use without::Without;

/// The commands for a running system.
#[cfg(feature = "amqp")]
mod live {
    pub use super::call::Call;
    pub use super::component::Component;
    pub use super::doctor::Doctor;
    pub use super::port::Port;
    pub use super::reconfigure::Reconfigure;
    pub use super::shell::Shell;
    pub use super::topic::Topic;
}
/// Replacements in a build without the feature `amqp`.
#[cfg(not(feature = "amqp"))]
mod live {
    use super::without::Without;
    use crate::feature::Amqp;

    pub type Call = Without<Amqp>;
    pub type Component = Without<Amqp>;
    pub type Doctor = Without<Amqp>;
    pub type Port = Without<Amqp>;
    pub type Reconfigure = Without<Amqp>;
    pub type Shell = Without<Amqp>;
    pub type Topic = Without<Amqp>;
}

#[cfg(feature = "mcap")]
use replay::Replay;
#[cfg(not(feature = "mcap"))]
type Replay = Without<feature::Mcap>;
#[cfg(all(feature = "dashboard", feature = "mcap"))]
use dash::Dash;
#[cfg(not(feature = "dashboard"))]
type Dash = Without<feature::Dashboard>;
#[cfg(all(feature = "dashboard", not(feature = "mcap")))]
type Dash = Without<feature::Mcap>;

#[cfg(feature = "ros")]
use ros::Ros;
#[cfg(not(feature = "ros"))]
type Ros = Without<feature::Ros>;

#[cfg(feature = "scdl")]
use scdl::Scdl;
#[cfg(not(feature = "scdl"))]
type Scdl = Without<feature::Scdl>;

#[cfg(all(feature = "amqp", feature = "tui"))]
use top::Top;
#[cfg(all(feature = "amqp", not(feature = "tui")))]
type Top = Without<feature::Tui>;
#[cfg(not(feature = "amqp"))]
type Top = Without<feature::Amqp>;

use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use clap::Subcommand;

/// A subcommand of `asmotion`.
#[derive(Subcommand)]
pub enum Command {
    /// Runs a mission in which a specification coordinates a simulated rover
    Demo(demo::Demo),
    /// Runs a composite
    Run(Box<run::Run>),
    /// Shows a recording in a web browser
    Dash(Dash),
    /// Starts the processes of a composite that belong to this machine, and restarts them as it prescribes
    Up(up::Up),
    /// Checks specifications, scenarios and composites without running them
    Check(check::Check),
    /// Shows the components, topics and services of a composite
    Describe(describe::Describe),
    /// Shows a composite with nested composites and defaults expanded
    Expand(expand::Expand),
    /// Draws a composite
    Graph(graph::Graph),
    /// Converts composites from and to the XML of the Service Component Architecture (SCDL)
    Scdl(Scdl),
    /// Shows the interfaces of ROS: messages, services and actions
    Ros(Ros),
    /// Prints the JSON Schema of composite files, for editors
    Schema(schema::Schema),
    /// Creates a project, or a component in one
    New(new::New),
    /// Formats specifications and scenarios
    Fmt(fmt::Fmt),
    /// Simulates a specification with scripted or random inputs
    Sim(sim::Sim),
    /// Proves properties of specifications for all inputs and choices
    Verify(Box<verify::Verify>),
    /// Steps a specification interactively: sets inputs, evaluates terms, undoes steps
    Repl(repl::Repl),
    /// Repeats the steps of recorded coordinators, and compares them with the recording
    Replay(Replay),
    /// Runs scenarios and missions
    Test(test::Test),
    /// Lists, shows and publishes messages of topics on a broker
    Topic(live::Topic),
    /// Lists, inspects and controls live components on a broker
    Component(live::Component),
    /// Applies the current version of a composite to the running system without a restart
    Reconfigure(live::Reconfigure),
    /// Shows a running system on the terminal, updated continuously
    Top(Top),
    /// Reads and writes ports of live components
    Port(live::Port),
    /// Calls an operation of a live component
    Call(live::Call),
    /// Opens a prompt in a running system: inspects, calls, reads, writes, watches
    Shell(live::Shell),
    /// Diagnoses a broker and says how to repair it
    Doctor(live::Doctor),
}

impl Command {
    /// Executes the command and returns its exit code.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        match self {
            Self::Demo(demo) => demo.run(build, terminal),
            Self::Run(run) => run.run(build, terminal),
            Self::Dash(dash) => dash.run(build, terminal),
            Self::Up(up) => up.run(build, terminal),
            Self::Check(check) => check.run(build, terminal),
            Self::Describe(describe) => describe.run(build, terminal),
            Self::Expand(expand) => expand.run(build, terminal),
            Self::Graph(graph) => graph.run(build, terminal),
            Self::Scdl(scdl) => scdl.run(build, terminal),
            Self::Ros(ros) => ros.run(build, terminal),
            Self::Schema(schema) => schema.run(terminal),
            Self::New(new) => new.run(terminal),
            Self::Fmt(fmt) => fmt.run(terminal),
            Self::Sim(sim) => sim.run(terminal),
            Self::Verify(verify) => verify.run(build, terminal),
            Self::Repl(repl) => repl.run(terminal),
            Self::Replay(replay) => replay.run(build, terminal),
            Self::Test(test) => test.run(build, terminal),
            Self::Topic(topic) => topic.run(build, terminal),
            Self::Component(component) => component.run(build, terminal),
            Self::Reconfigure(reconfigure) => reconfigure.run(build, terminal),
            Self::Top(top) => top.run(build, terminal),
            Self::Port(port) => port.run(build, terminal),
            Self::Call(call) => call.run(build, terminal),
            Self::Shell(shell) => shell.run(build, terminal),
            Self::Doctor(doctor) => doctor.run(build, terminal),
        }
    }
}
