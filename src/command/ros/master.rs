//! The master of ROS 1.

use asmotion_ros1::{RosError, RosNode, RosSettings, RosUri, RosUriError};
use clap::Args;

use crate::ros_host::own_host;

/// The master of ROS 1.
#[derive(Args)]
pub(super) struct MasterArguments {
    /// Address of the master [default: the environment variable `ROS_MASTER_URI`, or `http://localhost:11311`]
    #[arg(long, value_name = "URI")]
    master: Option<String>,

    /// Host or address at which nodes reach this machine [default: `ROS_HOSTNAME` or `ROS_IP`, or the address on the way to the master]
    #[arg(long, value_name = "HOST")]
    host: Option<String>,
}

/// Why there is no node.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoNode {
    #[error(transparent)]
    Master(#[from] RosUriError),
    #[error(transparent)]
    Node(#[from] RosError),
}

impl MasterArguments {
    /// The option of ROS 1 that was given; in ROS 2 there is no master.
    pub(super) fn given(&self) -> Option<&'static str> {
        let master = self.master.as_ref().map(|_| "--master");
        master.or(self.host.as_ref().map(|_| "--host"))
    }

    /// Starts a node for the time of a command.
    pub(super) fn node(self) -> Result<RosNode, NoNode> {
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
