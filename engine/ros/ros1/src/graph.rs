//! Nodes, topics and services that a master knows.

use std::collections::BTreeMap;

use crate::xmlrpc::XmlRpcValue;

/// What a master knows.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RosGraph {
    /// Topics, by name.
    pub topics: BTreeMap<String, RosTopic>,
    /// Names of the nodes that provide a service, by its name.
    pub services: BTreeMap<String, Vec<String>>,
}

/// A topic that a master knows.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RosTopic {
    /// Name of the type; empty if the master does not know it.
    pub type_name: String,
    /// Names of the nodes that publish it.
    pub publishers: Vec<String>,
    /// Names of the nodes that subscribe to it.
    pub subscribers: Vec<String>,
}

impl RosGraph {
    /// The graph of the answers of `getSystemState` and `getTopicTypes`; `None` if they are not as the API says.
    pub(crate) fn of(state: &XmlRpcValue, types: &XmlRpcValue) -> Option<Self> {
        let [publishers, subscribers, services] = state.as_array()? else {
            return None;
        };
        let mut graph = Self::default();
        for (topic, nodes) in named_lists(publishers)? {
            graph.topics.entry(topic).or_default().publishers = nodes;
        }
        for (topic, nodes) in named_lists(subscribers)? {
            graph.topics.entry(topic).or_default().subscribers = nodes;
        }
        graph.services = named_lists(services)?.into_iter().collect();
        for pair in types.as_array()? {
            let pair = pair.as_texts()?;
            let [topic, type_name] = *pair.as_slice() else {
                return None;
            };
            // the master keeps the types of topics that nobody uses any more
            if let Some(topic) = graph.topics.get_mut(topic)
                && type_name != "*"
            {
                topic.type_name = type_name.to_owned();
            }
        }
        Some(graph)
    }

    /// Names of all nodes, in order.
    pub fn nodes(&self) -> Vec<&str> {
        let of_topics = self.topics.values();
        let of_topics = of_topics.flat_map(|it| it.publishers.iter().chain(&it.subscribers));
        let all = of_topics.chain(self.services.values().flatten());
        let mut nodes: Vec<&str> = all.map(String::as_str).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}

/// The pairs of `[[name, [node, …]], …]`.
pub(crate) fn named_lists(of: &XmlRpcValue) -> Option<Vec<(String, Vec<String>)>> {
    let pairs = of.as_array()?.iter().map(|pair| {
        let [name, nodes] = pair.as_array()? else {
            return None;
        };
        let mut nodes: Vec<String> = nodes.as_texts()?.into_iter().map(str::to_owned).collect();
        nodes.sort_unstable();
        Some((name.as_text()?.to_owned(), nodes))
    });
    pairs.collect()
}
