//! The plan as a graph, for pictures and for the order of starting.

use std::collections::BTreeMap;

use petgraph::graph::{DiGraph, NodeIndex};

use crate::plan::{End, Plan, Terminal};

/// Why one component needs another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Dependency {
    /// It reads what the other writes, over this topic if there is one.
    Reads {
        /// The topic.
        topic: Option<String>,
        /// The type of the messages.
        kind: String,
    },
    /// It calls the other, through this interface.
    Calls {
        /// The interface.
        interface: String,
    },
}

impl Plan {
    /// The interface of a reference; empty where nobody says.
    fn interface(&self, reference: &End) -> String {
        let component = self.component(&reference.component);
        let mut references = component.into_iter().flat_map(|it| &it.references);
        let found = references.find(|it| it.name == reference.name);
        found.map_or_else(String::new, |it| it.interface.clone())
    }

    /// Components and their links. An edge leads from the one that must be there first, so from
    /// writers to readers and from providers to callers.
    pub fn graph(&self) -> DiGraph<&str, Dependency> {
        let mut graph = DiGraph::new();
        let nodes: BTreeMap<&str, NodeIndex> = self
            .components
            .iter()
            .map(|component| {
                (
                    component.name.as_str(),
                    graph.add_node(component.name.as_str()),
                )
            })
            .collect();
        let mut add = |from: &str, to: &str, link: Dependency| {
            if let (Some(from), Some(to)) = (nodes.get(from), nodes.get(to)) {
                graph.add_edge(*from, *to, link);
            }
        };
        for wire in &self.wires {
            for service in &wire.services {
                let interface = self.interface(&wire.reference);
                add(
                    &service.component,
                    &wire.reference.component,
                    Dependency::Calls { interface },
                );
            }
        }
        for connection in &self.connections {
            if let (Terminal::Port(from), Terminal::Port(to)) = (&connection.from, &connection.to) {
                let writer = self.component(&from.component);
                let port = writer.and_then(|it| it.outputs.iter().find(|it| it.name == from.name));
                let kind = port.map_or(String::new(), |port| port.kind.clone());
                add(
                    &from.component,
                    &to.component,
                    Dependency::Reads { topic: None, kind },
                );
            }
        }
        for topic in &self.topics {
            for from in &topic.publishers {
                for to in &topic.subscribers {
                    let kind = topic.kind.clone().unwrap_or_default();
                    let topic = Some(topic.name.clone());
                    add(
                        &from.component,
                        &to.component,
                        Dependency::Reads { topic, kind },
                    );
                }
            }
        }
        graph
    }
}
