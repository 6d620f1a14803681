//! Endpoints and nodes of peers.

use crate::gid::Gid;
use crate::qos::Qos;

/// The kinds of endpoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndpointKind {
    /// Publishers, and the sending halves of clients and servers.
    Writer,
    /// Subscriptions, and the receiving halves of clients and servers.
    Reader,
}

/// A writer or reader of a peer, or of this node.
#[derive(Debug, Clone, PartialEq)]
pub struct Endpoint {
    /// Its id.
    pub gid: Gid,
    /// Writer or reader.
    pub kind: EndpointKind,
    /// The topic of DDS, such as `rt/scan`.
    pub topic: String,
    /// The type of DDS.
    pub type_name: String,
    /// The topic or service and its type as ROS names them; `None` if they are not of ROS.
    pub ros: Option<(String, String)>,
    /// The quality of service that it announces.
    pub qos: Qos,
    /// The type hash that it announces, such as `RIHS01_…`.
    pub type_hash: Option<String>,
}

/// A node of a peer, according to the graph that it publishes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RemoteNode {
    /// Name.
    pub name: String,
    /// Namespace, `/` or a name that starts with it.
    pub namespace: String,
    /// Ids of its readers.
    pub readers: Vec<Gid>,
    /// Ids of its writers.
    pub writers: Vec<Gid>,
}

impl RemoteNode {
    /// Its name with its namespace, such as `/robot/driver`.
    pub fn full_name(&self) -> String {
        format!("{}/{}", self.namespace.trim_end_matches('/'), self.name)
    }
}
