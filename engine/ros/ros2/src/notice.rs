//! Events that a user should see.

use std::sync::Arc;
use std::time::Duration;

use crate::endpoint::EndpointKind;
use crate::gid::Gid;
use crate::qos::Qos;

/// Called on the thread of a node when something has arrived. It must not wait.
pub type Waker = Arc<dyn Fn() + Send + Sync>;

/// An event that a user should see.
#[derive(Debug, Clone, PartialEq)]
pub enum Notice {
    /// A peer announces another type hash for a topic or service of this node. Its messages are decoded all the same, and
    /// counted as malformed where this fails.
    TypeHash {
        /// The topic of DDS.
        topic: String,
        /// The endpoint of the peer.
        peer: Gid,
        /// The hash here.
        here: String,
        /// The hash there.
        there: String,
    },
    /// A peer has the same topic with another type, and does not match.
    Type {
        /// The topic of DDS.
        topic: String,
        /// The type here.
        here: String,
        /// The type there.
        there: String,
        /// The endpoint of the peer.
        peer: Gid,
    },
    /// A peer has the same topic with a quality of service that does not match: a best-effort writer for a reliable reader, a
    /// volatile writer for a transient local reader, or a writer with a longer deadline than the reader's.
    Qos {
        /// The topic of DDS.
        topic: String,
        /// The quality of service here.
        here: Qos,
        /// The quality of service there.
        there: Qos,
        /// The endpoint of the peer.
        peer: Gid,
        /// Its kind: writers offer, readers request.
        kind: EndpointKind,
    },
    /// A subscription with a matched publisher received no message within its deadline. The next one ends the gap; a gap is
    /// noticed once.
    Deadline {
        /// The topic of DDS.
        topic: String,
        /// The longest time between two messages.
        deadline: Duration,
    },
    /// A subscription does not acknowledge the messages of a publisher, which no longer keeps them all for it. Noticed again after all
    /// have acknowledged everything.
    Unacknowledged {
        /// The topic of DDS.
        topic: String,
        /// The reliable subscriptions that match, of which DDS does not tell which one it is.
        readers: Vec<Gid>,
    },
    /// A participant whose lease had ended, and that matched endpoints of this node, is there again. RustDDS takes its endpoints,
    /// which it announces anew, for those that it knows, and does not match them: a node that starts now does.
    Returned {
        /// The id of the participant's first 12 bytes, in hexadecimal digits.
        participant: String,
        /// Names of its nodes when it was lost, with their namespaces.
        nodes: Vec<String>,
    },
    /// A wait of this node was interrupted, as when its process is stopped and goes on. RustDDS ends its threads then: the node
    /// receives and sends nothing any more, and has to be started again.
    Interrupted,
    /// A participant has left, or its lease has ended.
    Lost {
        /// The id of the participant's first 12 bytes, in hexadecimal digits.
        participant: String,
        /// Names of its nodes, with their namespaces.
        nodes: Vec<String>,
        /// Topics of DDS on which it still matched endpoints of this node: none after a farewell.
        topics: Vec<String>,
    },
}

impl Notice {
    /// The endpoint of a peer that it is about.
    pub(crate) fn peer(&self) -> Option<Gid> {
        match self {
            Self::TypeHash { peer, .. } | Self::Type { peer, .. } | Self::Qos { peer, .. } => {
                Some(*peer)
            }
            Self::Deadline { .. }
            | Self::Unacknowledged { .. }
            | Self::Returned { .. }
            | Self::Interrupted
            | Self::Lost { .. } => None,
        }
    }
}
