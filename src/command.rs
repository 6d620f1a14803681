//! The commands, one file each.

mod call;
mod check;
mod component;
mod demo;
mod describe;
mod doctor;
mod expand;
mod fmt;
mod graph;
mod port;
mod reconfigure;
mod repl;
mod run;
mod scdl;
mod schema;
mod shell;
mod sim;
mod test;
mod tool;
mod top;
mod topic;
mod up;

pub use demo::BLOCKED_CORRIDOR;

use crate::exit::Exit;
use crate::terminal::Terminal;
use clap::Subcommand;

/// What to do.
#[derive(Subcommand)]
pub enum Command {
    /// Shows a rover being coordinated to its goal, in a simulated world
    Demo(demo::Demo),
    /// Runs a composite
    Run(Box<run::Run>),
    /// Runs the processes of a composite that are of this machine, and starts them again as it says
    Up(up::Up),
    /// Says what is wrong with specifications, scenarios and composites, before anything runs
    Check(check::Check),
    /// Shows what a composite is to the outside: components, topics, services
    Describe(describe::Describe),
    /// Shows a composite opened up, with everything filled in
    Expand(expand::Expand),
    /// Draws a composite
    Graph(graph::Graph),
    /// Reads composites of the Service Component Architecture (SCDL), and writes them
    Scdl(scdl::Scdl),
    /// Shows the JSON Schema of composite files, for editors
    Schema(schema::Schema),
    /// Puts specifications and scenarios into the one layout
    Fmt(fmt::Fmt),
    /// Runs a specification alone, with scripted or random inputs
    Sim(sim::Sim),
    /// Steps a specification by hand: sets inputs, asks for values, goes back
    Repl(repl::Repl),
    /// Runs scenarios
    Test(test::Test),
    /// Shows what goes over a broker's topics, and publishes
    Topic(topic::Topic),
    /// Shows the components that are there on a broker, starts and stops them
    Component(component::Component),
    /// Makes what runs what its composite says now, without a new start
    Reconfigure(reconfigure::Reconfigure),
    /// Shows a running system on the terminal, as it changes
    Top(top::Top),
    /// Reads and writes ports of live components
    Port(port::Port),
    /// Calls an operation of a live component
    Call(call::Call),
    /// Talks with a running system: looks around in its components, calls, reads, writes, watches
    Shell(shell::Shell),
    /// Says what is wrong with a broker, and how to mend it
    Doctor(doctor::Doctor),
}

impl Command {
    /// Does it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        match self {
            Self::Demo(demo) => demo.run(terminal),
            Self::Run(run) => run.run(terminal),
            Self::Up(up) => up.run(terminal),
            Self::Check(check) => check.run(terminal),
            Self::Describe(describe) => describe.run(terminal),
            Self::Expand(expand) => expand.run(terminal),
            Self::Graph(graph) => graph.run(terminal),
            Self::Scdl(scdl) => scdl.run(terminal),
            Self::Schema(schema) => schema.run(terminal),
            Self::Fmt(fmt) => fmt.run(terminal),
            Self::Sim(sim) => sim.run(terminal),
            Self::Repl(repl) => repl.run(terminal),
            Self::Test(test) => test.run(terminal),
            Self::Topic(topic) => topic.run(terminal),
            Self::Component(component) => component.run(terminal),
            Self::Reconfigure(reconfigure) => reconfigure.run(terminal),
            Self::Top(top) => top.run(terminal),
            Self::Port(port) => port.run(terminal),
            Self::Call(call) => call.run(terminal),
            Self::Shell(shell) => shell.run(terminal),
            Self::Doctor(doctor) => doctor.run(terminal),
        }
    }
}
