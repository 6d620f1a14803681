//! `asmotion ros`: what other robots speak, and what they say.

mod echo;
mod list;
mod types;

use asmotion_ros1::{RosError, RosNode, RosSettings, RosUri, RosUriError};
use clap::{Args, Subcommand};

use crate::build::Build;
use crate::exit::Exit;
use crate::ros_host::own_host;
use crate::terminal::TerminalOutput;

/// Shows the interfaces of ROS, and nodes and topics of a running system of ROS 1.
#[derive(Args)]
pub struct Ros {
    #[command(subcommand)]
    what: RosCommand,
}

#[derive(Subcommand)]
enum RosCommand {
    /// Lists messages, services and actions, or shows one with what peers compare: an MD5 sum or a type hash
    Types(types::Types),
    /// Lists the nodes, topics and services that a master of ROS 1 knows
    List(list::RosList),
    /// Prints the messages of a topic of ROS 1
    Echo(echo::RosEcho),
}

/// The master of ROS 1.
#[derive(Args)]
struct MasterArguments {
    /// Address of the master [default: the environment variable `ROS_MASTER_URI`, or `http://localhost:11311`]
    #[arg(long, value_name = "URI")]
    master: Option<String>,

    /// Host or address at which nodes reach this machine [default: `ROS_HOSTNAME` or `ROS_IP`, or the address on the way to the master]
    #[arg(long, value_name = "HOST")]
    host: Option<String>,
}

/// Why there is no node.
#[derive(Debug, thiserror::Error)]
enum NoNode {
    #[error(transparent)]
    Master(#[from] RosUriError),
    #[error(transparent)]
    Node(#[from] RosError),
}

impl MasterArguments {
    /// Starts a node for the time of a command.
    fn node(self) -> Result<RosNode, NoNode> {
        let variable = |name| std::env::var(name).ok().filter(|it| !it.is_empty());
        let mut settings = RosSettings::new(format!("/asmotion_{}", std::process::id()));
        if let Some(master) = self.master.or_else(|| variable("ROS_MASTER_URI")) {
            settings.master = master.parse::<RosUri>()?;
        }
        let master = settings.master.to_string();
        settings.host = self.host.unwrap_or_else(|| own_host(&master));
        Ok(RosNode::start(settings)?)
    }
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
