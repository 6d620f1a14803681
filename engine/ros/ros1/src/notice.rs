//! Events of a node that no call returns, for a log.

use std::fmt;
use std::sync::Arc;

/// The type that an end of a connection has, as the header says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatedType {
    /// Name of the node.
    pub node: Arc<str>,
    /// Name of the type.
    pub name: Arc<str>,
    /// MD5 sum.
    pub md5: Arc<str>,
    /// Definition; empty if the node did not send one.
    pub definition: Arc<str>,
}

/// Both ends of a connection state different types.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TypeMismatch {
    /// Name of the topic or service.
    pub of: Arc<str>,
    /// This node's type.
    pub here: StatedType,
    /// The other node's type.
    pub there: StatedType,
}

/// An event in the life of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RosNotice {
    /// The master knows all topics and services of the node.
    Registered {
        /// Address of the master.
        master: String,
    },
    /// The master does not answer, or refuses a registration. The node goes on trying.
    Unregistered {
        /// Address of the master.
        master: String,
        /// Cause, for display.
        reason: String,
    },
    /// Another node has taken the name, or the master has asked the node to end. It takes part no longer.
    Ended {
        /// Cause, in the master's words.
        reason: String,
    },
    /// A node has another type for a topic or service; there is no connection to it.
    Mismatch(Box<TypeMismatch>),
    /// A connection to another node failed. It is tried again while the master lists that node.
    Disconnected {
        /// Name of the topic or service.
        of: Arc<str>,
        /// Address or name of the other node.
        peer: String,
        /// Cause, for display.
        reason: String,
    },
    /// A message, header or call could not be read.
    Unreadable {
        /// Name of the topic or service, or what else was read.
        of: String,
        /// Address or name of the other node.
        peer: String,
        /// Cause, for display.
        reason: String,
    },
}

impl fmt::Display for TypeMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { of, here, there } = self;
        write!(
            f,
            "`{of}` has the type `{}` ({}) here, and `{}` ({}) in `{}`",
            here.name, here.md5, there.name, there.md5, there.node
        )?;
        for (side, definition) in [("here", &here.definition), ("there", &there.definition)] {
            if definition.is_empty() {
                write!(f, "\n  {side}: not stated")?
            } else {
                write!(f, "\n  {side}: {}", definition.replace('\n', "\n    "))?
            }
        }
        Ok(())
    }
}

impl fmt::Display for RosNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Registered { master } => write!(f, "registered at the ROS master {master}"),
            Self::Unregistered { master, reason } => {
                write!(f, "not registered at the ROS master {master}: {reason}")
            }
            Self::Ended { reason } => write!(f, "the node was asked to end: {reason}"),
            Self::Mismatch(mismatch) => mismatch.fmt(f),
            Self::Disconnected { of, peer, reason } => {
                write!(f, "no connection to {peer} for `{of}`: {reason}")
            }
            Self::Unreadable { of, peer, reason } => {
                write!(f, "cannot read {of} from {peer}: {reason}")
            }
        }
    }
}
