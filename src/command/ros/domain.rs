//! The domain of ROS 2.

use std::path::PathBuf;

use clap::Args;

use super::generation::Generation;
use super::master::MasterArguments;

/// The domain of ROS 2.
#[derive(Args)]
pub(super) struct DomainArguments {
    /// ROS 2: domain id [default: the environment variable `ROS_DOMAIN_ID`, or 0]
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u16).range(0..=232))]
    domain: Option<u16>,
}

/// An option does not belong to the generation.
#[derive(Debug, thiserror::Error)]
#[error("`{option}` is an option of ROS {own}, not of `--ros {other}`")]
pub(super) struct GenerationError {
    option: &'static str,
    own: u8,
    other: u8,
}

impl DomainArguments {
    /// Checks that the options are those of one generation of ROS.
    ///
    /// # Errors
    /// An option belongs to the other generation.
    pub(super) fn check(
        &self,
        generation: Generation,
        master: &MasterArguments,
        definitions: &[PathBuf],
        hidden: bool,
    ) -> Result<(), GenerationError> {
        let foreign = match generation {
            Generation::One if !definitions.is_empty() => Some(("--definitions", 2, 1)),
            Generation::One if hidden => Some(("--hidden", 2, 1)),
            Generation::One => self.domain.map(|_| ("--domain", 2, 1)),
            Generation::Two => master.given().map(|option| (option, 1, 2)),
        };
        match foreign {
            Some((option, own, other)) => Err(GenerationError { option, own, other }),
            None => Ok(()),
        }
    }
}

#[cfg(feature = "ros2")]
mod with_ros2 {
    use std::path::PathBuf;
    use std::sync::Arc;

    use asmotion_ros_interface::FolderError;
    use asmotion_ros2::{Node, NodeError, NodeOptions};

    use super::DomainArguments;
    use crate::build::ros_messages;
    use crate::ros_domain::{RosVariableError, networks, own_domain};

    /// Why there is no node.
    #[derive(Debug, thiserror::Error)]
    pub(in super::super) enum NoDomain {
        #[error(transparent)]
        Variable(#[from] RosVariableError),
        #[error(transparent)]
        Folder(#[from] FolderError),
        #[error(transparent)]
        Node(#[from] NodeError),
    }

    impl DomainArguments {
        /// The domain id.
        ///
        /// # Errors
        /// `ROS_DOMAIN_ID` is not one.
        pub(in super::super) fn id(&self) -> Result<u16, RosVariableError> {
            self.domain.map_or_else(own_domain, Ok)
        }

        /// Starts a node for the time of a command, which knows the definitions in folders, too.
        ///
        /// # Errors
        /// A variable of ROS has a wrong value, a definition is wrong, or the node cannot be started.
        pub(in super::super) fn node(&self, folders: &[PathBuf]) -> Result<Node, NoDomain> {
            let mut catalogue = ros_messages::jazzy();
            for folder in folders {
                Arc::make_mut(&mut catalogue).add_folder(folder)?;
            }
            let options = NodeOptions {
                domain: self.id()?,
                networks: networks()?,
                ..NodeOptions::named(format!("asmotion_{}", std::process::id()))
            };
            Ok(Node::start(options, catalogue)?)
        }
    }
}
