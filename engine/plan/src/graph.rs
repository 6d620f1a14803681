//! Dependency graph of a plan, used for diagrams and for the start order.

use std::collections::BTreeMap;

use petgraph::graph::{DiGraph, NodeIndex};

use crate::plan::{End, Plan, Terminal};

/// A dependency between two components.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Dependency {
    /// One component reads messages written by the other.
    Reads {
        /// Topic between them; `None` for a direct connection.
        topic: Option<String>,
        /// Message type name.
        kind: String,
    },
    /// One component calls the other.
    Calls {
        /// Interface of the calls.
        interface: String,
    },
}

impl Plan {
    /// Returns the interface of a reference; empty if unknown.
    fn interface(&self, reference: &End) -> String {
        let component = self.component(&reference.component);
        let mut references = component.into_iter().flat_map(|it| &it.references);
        let found = references.find(|it| it.name == reference.name);
        found.map_or_else(String::new, |it| it.interface.clone())
    }

    /// Returns the dependency graph. Edges lead from the component that must start first, that is from writers to
    /// readers and from providers to callers.
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
