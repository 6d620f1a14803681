//! `asmotion ros list --ros 2`: what is in a domain.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use asmotion_ros2::{Durability, Endpoint, EndpointKind, Graph, Qos, Reliability, RemoteNode};
use serde_json::json;

use super::domain::DomainArguments;
use crate::exit::Exit;
use crate::table;
use crate::terminal::TerminalOutput;

/// Prints the nodes, topics and services that are discovered within a time.
pub(super) fn run(
    domain: &DomainArguments,
    time: Duration,
    (with_hidden, is_json): (bool, bool),
    terminal: &mut TerminalOutput,
) -> Exit {
    let node = match domain.node(&[]) {
        Ok(node) => node,
        Err(error) => {
            terminal.error(error);
            return Exit::Usage;
        }
    };
    std::thread::sleep(time);
    let mut listed = Listed::of(&node.graph());
    if !with_hidden {
        listed.leave_hidden_out();
    }
    if is_json {
        terminal.result(listed.as_json());
    } else {
        for line in listed.as_tables() {
            terminal.result(line);
        }
    }
    Exit::Ok
}

/// The endpoints of a topic or service, by its name and type.
type Ends = BTreeMap<(String, String), Vec<End>>;

struct End {
    kind: EndpointKind,
    /// `None` for an endpoint that no node has, such as one of a program without ROS.
    node: Option<String>,
    qos: Qos,
    type_hash: Option<String>,
}

struct Listed {
    nodes: BTreeSet<String>,
    topics: Ends,
    /// With the servers' halves that receive requests.
    services: Ends,
}

impl Listed {
    fn of(graph: &Graph) -> Self {
        let (mut topics, mut services) = (Ends::new(), Ends::new());
        for endpoint in graph.endpoints.values() {
            let Some(key) = endpoint.ros.clone() else {
                continue;
            };
            let is_request = endpoint.topic.starts_with("rq");
            let ends = match endpoint.kind {
                EndpointKind::Reader if is_request => &mut services,
                _ if endpoint.topic.starts_with("rt") => &mut topics,
                EndpointKind::Writer | EndpointKind::Reader => continue,
            };
            ends.entry(key).or_default().push(end(endpoint, graph));
        }
        let nodes = graph.nodes.values().flatten();
        Self {
            nodes: nodes.map(RemoteNode::full_name).collect(),
            topics,
            services,
        }
    }

    /// Leaves out what the tools of ROS hide, such as the topics of actions.
    fn leave_hidden_out(&mut self) {
        let is_shown = |name: &str| !name.split('/').any(|part| part.starts_with('_'));
        self.nodes.retain(|name| is_shown(name));
        for ends in [&mut self.topics, &mut self.services] {
            ends.retain(|(name, _), _| is_shown(name));
        }
    }

    fn as_json(&self) -> serde_json::Value {
        let topics = self.topics.iter().map(|((name, of), ends)| {
            let of_kind = |kind| {
                let ends = ends.iter().filter(|end| end.kind == kind);
                ends.map(End::as_json).collect::<Vec<_>>()
            };
            json!({
                "topic": name, "type": of,
                "publishers": of_kind(EndpointKind::Writer),
                "subscribers": of_kind(EndpointKind::Reader),
            })
        });
        let services = self.services.iter().map(|((name, of), ends)| {
            let providers: Vec<_> = ends.iter().map(|end| &end.node).collect();
            json!({ "service": name, "type": of, "providers": providers })
        });
        json!({
            "nodes": self.nodes,
            "topics": topics.collect::<Vec<_>>(),
            "services": services.collect::<Vec<_>>(),
        })
    }

    /// Tables of topics, of services and of nodes.
    fn as_tables(&self) -> Vec<String> {
        let topics = self.topics.iter().map(|((name, of), ends)| {
            let of_kind = |kind| {
                let ends = ends.iter().filter(|end| end.kind == kind);
                let texts: Vec<_> = ends.map(End::to_text).collect();
                joined(&texts)
            };
            let (from, to) = (of_kind(EndpointKind::Writer), of_kind(EndpointKind::Reader));
            vec![name.clone(), of.clone(), from, to]
        });
        let services = self.services.iter().map(|((name, of), ends)| {
            let nodes: Vec<_> = ends.iter().map(|end| end.name().to_owned()).collect();
            vec![name.clone(), of.clone(), joined(&nodes)]
        });
        let mut lines = table::lines(&["topic", "type", "from", "to"], topics);
        lines.push(String::new());
        lines.extend(table::lines(&["service", "type", "node"], services));
        lines.push(String::new());
        let nodes = self.nodes.iter().map(|name| vec![name.clone()]);
        lines.extend(table::lines(&["node"], nodes));
        lines
    }
}

fn joined(texts: &[String]) -> String {
    if texts.is_empty() {
        "-".to_owned()
    } else {
        texts.join(", ")
    }
}

fn end(endpoint: &Endpoint, graph: &Graph) -> End {
    End {
        kind: endpoint.kind,
        node: graph.node_of(endpoint.gid),
        qos: endpoint.qos,
        type_hash: endpoint.type_hash.clone(),
    }
}

impl End {
    fn name(&self) -> &str {
        self.node.as_deref().unwrap_or("(no node)")
    }

    fn to_text(&self) -> String {
        format!("{} ({})", self.name(), self.qos)
    }

    fn as_json(&self) -> serde_json::Value {
        let limit = |limit: Option<Duration>| limit.map(|it| it.as_millis());
        json!({
            "node": self.node,
            "qos": {
                "reliability": match self.qos.reliability {
                    Reliability::Reliable => "reliable",
                    Reliability::BestEffort => "best_effort",
                },
                "durability": match self.qos.durability {
                    Durability::Volatile => "volatile",
                    Durability::TransientLocal => "transient_local",
                },
                "deadline_ms": limit(self.qos.deadline),
                "lifespan_ms": limit(self.qos.lifespan),
            },
            "type_hash": self.type_hash,
        })
    }
}
