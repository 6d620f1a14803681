//! `asmotion ros`: what other robots speak, and what they say.

mod domain;
mod echo;
mod generation;
#[cfg(not(feature = "ros2"))]
mod left_out;
mod list;
mod master;
mod printed;
#[cfg(feature = "ros2")]
mod ros2_echo;
#[cfg(feature = "ros2")]
mod ros2_list;
mod types;

use clap::{Args, Subcommand};
#[cfg(not(feature = "ros2"))]
use left_out::{ros2_echo, ros2_list};

use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;

/// Shows the interfaces of ROS, and nodes and topics of a running system.
#[derive(Args)]
pub struct Ros {
    #[command(subcommand)]
    what: RosCommand,
}

#[derive(Subcommand)]
enum RosCommand {
    /// Lists messages, services and actions, or shows one with what peers compare: an MD5 sum or a type hash
    Types(types::Types),
    /// Lists the nodes, topics and services that a master of ROS 1 knows, or that are in a domain of ROS 2
    List(list::RosList),
    /// Prints the messages of a topic
    Echo(echo::RosEcho),
}

impl Ros {
    pub fn run(self, _: &Build, terminal: &mut TerminalOutput) -> Exit {
        match self.what {
            RosCommand::Types(types) => types.run(terminal),
            RosCommand::List(list) => list.run(terminal),
            RosCommand::Echo(echo) => echo.run(terminal),
        }
    }
}
