//! The graph of ROS: each participant publishes its nodes and their endpoints on `ros_discovery_info`.

use std::sync::Arc;

use asmotion_datum::{Codec, Datum, DatumError, Schema};
use asmotion_ros_interface::{Catalogue, DefinitionError, Distribution, InterfaceName};

use crate::endpoint::RemoteNode;
use crate::error::EndpointError;
use crate::gid::Gid;
use crate::graph::SharedGraph;
use crate::names;
use crate::reactor::{Incoming, Sink};

/// The topic of DDS.
pub(crate) const TOPIC: &str = names::GRAPH;
/// The type of DDS.
pub(crate) const TYPE: &str = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";

/// Definitions of `rmw_dds_common`, which belongs to the implementation of ROS and not to its interfaces. The length of ids is
/// that since Iron.
const DEFINITIONS: [(&str, &str); 3] = [
    ("rmw_dds_common/msg/Gid", "uint8[16] data"),
    (
        "rmw_dds_common/msg/NodeEntitiesInfo",
        "string<=256 node_namespace\nstring<=256 node_name\nGid[] reader_gid_seq\nGid[] writer_gid_seq",
    ),
    (
        "rmw_dds_common/msg/ParticipantEntitiesInfo",
        "Gid gid\nNodeEntitiesInfo[] node_entities_info_seq",
    ),
];

/// Encodes and decodes messages of the graph.
pub(crate) struct Entities {
    schema: Schema,
}

fn name(text: &str) -> Result<InterfaceName, EndpointError> {
    text.parse().map_err(|_| EndpointError::Dds {
        topic: TOPIC.to_owned(),
        reason: format!("`{text}` is not the name of an interface"),
    })
}

impl Entities {
    pub(crate) fn new() -> Result<Self, EndpointError> {
        let mut catalogue = Catalogue::empty(Distribution::Ros2);
        for (text, definition) in DEFINITIONS {
            let defined: Result<(), DefinitionError> = catalogue.define(name(text)?, definition);
            defined?;
        }
        let [_, _, (whole, _)] = DEFINITIONS;
        let schema = catalogue.schema(&name(whole)?)?;
        Ok(Self { schema })
    }

    pub(crate) fn encode(
        &self,
        participant: Gid,
        nodes: &[RemoteNode],
    ) -> Result<Vec<u8>, DatumError> {
        let nodes = nodes.iter().map(|node| {
            Datum::record([
                ("node_namespace", Datum::text(&*node.namespace)),
                ("node_name", Datum::text(&*node.name)),
                ("reader_gid_seq", gids(&node.readers)),
                ("writer_gid_seq", gids(&node.writers)),
            ])
        });
        let message = Datum::record([
            ("gid", gid(participant)),
            ("node_entities_info_seq", Datum::List(nodes.collect())),
        ]);
        Codec::Cdr.encode(&message, &self.schema)
    }

    pub(crate) fn listener(&self, graph: Arc<SharedGraph>, own: Gid) -> Listener {
        let schema = self.schema.clone();
        Listener { schema, graph, own }
    }
}

fn gid(gid: Gid) -> Datum {
    Datum::record([("data", Datum::Bytes(gid.0.into()))])
}

fn gids(all: &[Gid]) -> Datum {
    Datum::List(all.iter().copied().map(gid).collect())
}

fn read_gid(datum: &Datum) -> Option<Gid> {
    let data = datum.get("data")?;
    let Datum::Bytes(bytes) = &*data else {
        return None;
    };
    Some(Gid(bytes.as_ref().try_into().ok()?))
}

fn read_gids(datum: &Datum, field: &str) -> Option<Vec<Gid>> {
    let list = datum.get(field)?;
    let Datum::List(elements) = &*list else {
        return None;
    };
    elements.iter().map(read_gid).collect()
}

fn read(message: &Datum) -> Option<(Gid, Vec<RemoteNode>)> {
    let list = message.get("node_entities_info_seq")?;
    let Datum::List(elements) = &*list else {
        return None;
    };
    let nodes = elements.iter().map(|node| {
        Some(RemoteNode {
            name: node.get("node_name")?.as_text()?.to_owned(),
            namespace: node.get("node_namespace")?.as_text()?.to_owned(),
            readers: read_gids(node, "reader_gid_seq")?,
            writers: read_gids(node, "writer_gid_seq")?,
        })
    });
    Some((
        read_gid(&*message.get("gid")?)?,
        nodes.collect::<Option<_>>()?,
    ))
}

/// Follows the graph that peers publish.
pub(crate) struct Listener {
    schema: Schema,
    graph: Arc<SharedGraph>,
    own: Gid,
}

impl Sink for Listener {
    fn message(&mut self, incoming: Incoming) {
        // a peer whose graph cannot be read still has its endpoints, which DDS announces
        let Ok(message) = Codec::Cdr.decode(&incoming.payload.0, &self.schema) else {
            return;
        };
        let Some((participant, nodes)) = read(&message) else {
            return;
        };
        // a participant speaks only for itself
        let is_own = participant == self.own;
        if !is_own && participant.participant() == incoming.writer.participant() {
            self.graph.set_nodes(participant, nodes);
        }
    }

    fn unreadable(&mut self) {}
}
