//! Settings of a node, which its owner provides: the library reads neither environment nor files.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use crate::http::RosUri;
use crate::notice::RosNotice;

/// Settings of a node.
#[derive(Clone)]
pub struct RosSettings {
    /// Name of the node, such as `/robot/coordinator`.
    pub name: String,
    /// Address of the master (`ROS_MASTER_URI`).
    pub master: RosUri,
    /// Host or IP address at which others reach this node (`ROS_IP`, `ROS_HOSTNAME`). If it is a loopback address, the node
    /// listens only there, otherwise at all addresses of the machine.
    pub host: String,
    /// Topics whose messages the owner of this node publishes on other topics of it, with those topics. They are announced to
    /// subscribers; what another node publishes that relays in the other direction is not received, because it would go round.
    pub relays: Vec<(String, String)>,
    /// Times.
    pub timing: RosTiming,
    /// Limits on what others can make this node hold.
    pub limits: RosLimits,
    /// Receives events that no call returns; called by threads of the node, and must not block.
    pub notices: Arc<dyn Fn(&RosNotice) + Send + Sync>,
    /// Called after messages of topics have been put into the queues of their subscribers, in the thread that reads all topics, which
    /// has nothing else to do until it returns. It may drop the node. `None`: the threads of the node read topics beside others.
    pub after_reading: Option<Arc<dyn Fn() + Send + Sync>>,
}

/// Times of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RosTiming {
    /// Limit on a call to the master or a node.
    pub call: Duration,
    /// Limit on connecting and exchanging headers.
    pub connect: Duration,
    /// First delay before an attempt is repeated; doubled with each.
    pub first_retry: Duration,
    /// Longest delay before an attempt is repeated.
    pub last_retry: Duration,
    /// Period of asking the master whether it still knows the node.
    pub check: Duration,
    /// Time after which the connection to a subscriber that reads nothing is closed.
    pub stall: Duration,
    /// Longest execution of a provided service, whose callers state no deadline.
    pub service: Duration,
    /// Limit on leaving the master when the node ends.
    pub leave: Duration,
}

/// Limits on what others can make a node hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RosLimits {
    /// Size of a message, request or response, in bytes.
    pub message: usize,
    /// Size of an answer of the master or a node, in bytes.
    pub answer: usize,
    /// Connections that others have opened to this node.
    pub connections: usize,
    /// Publishers of one topic that this node connects to.
    pub publishers: usize,
    /// Calls of one service client that are in progress.
    pub calls: usize,
}

impl Default for RosTiming {
    fn default() -> Self {
        Self {
            call: Duration::from_secs(5),
            connect: Duration::from_secs(5),
            first_retry: Duration::from_millis(100),
            last_retry: Duration::from_secs(2),
            check: Duration::from_secs(1),
            stall: Duration::from_secs(60),
            service: Duration::from_secs(30),
            leave: Duration::from_secs(1),
        }
    }
}

impl Default for RosLimits {
    fn default() -> Self {
        Self {
            message: 64 << 20,
            answer: 16 << 20,
            connections: 256,
            publishers: 256,
            calls: 64,
        }
    }
}

impl RosSettings {
    /// Settings of a node with this name on the machine of the master at its usual port.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            master: RosUri::new("localhost", 11311),
            host: "127.0.0.1".to_owned(),
            relays: Vec::new(),
            timing: RosTiming::default(),
            limits: RosLimits::default(),
            notices: Arc::new(|_| ()),
            after_reading: None,
        }
    }
}

impl fmt::Debug for RosSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RosSettings")
            .field("name", &self.name)
            .field("master", &self.master)
            .field("host", &self.host)
            .finish_non_exhaustive()
    }
}

/// Delays between attempts: growing to a limit.
pub(crate) struct Retry {
    first: Duration,
    last: Duration,
    next: Duration,
}

impl Retry {
    pub(crate) fn new(timing: &RosTiming) -> Self {
        let first = timing.first_retry;
        Self {
            first,
            last: timing.last_retry,
            next: first,
        }
    }

    pub(crate) fn reset(&mut self) {
        self.next = self.first;
    }

    pub(crate) fn next_delay(&mut self) -> Duration {
        let delay = self.next;
        self.next = delay.saturating_mul(2).min(self.last);
        delay
    }
}
