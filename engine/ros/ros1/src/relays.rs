//! Topics whose messages a node publishes on other topics, and nodes whose relays lead back.

use crate::header::ConnectionHeader;
use crate::names::{RosName, RosNameError};
use crate::xmlrpc::XmlRpcValue;

/// Field of a publisher's header: the topics whose messages it relays, separated by commas. No other client knows it.
const FIELD: &str = "asmotion_relays";

/// Method of a node's API: its relays. No other client knows it.
pub(crate) const METHOD: &str = "asmotionRelays";

/// The relays of a node.
pub(crate) struct Relays(Vec<(RosName, RosName)>);

impl Relays {
    /// The relays of a node of this name, from one topic to another.
    ///
    /// # Errors
    /// A text is not a name.
    pub(crate) fn of(node: &RosName, relays: &[(String, String)]) -> Result<Self, RosNameError> {
        let resolved = relays
            .iter()
            .map(|(from, to)| Ok((node.resolve(from)?, node.resolve(to)?)));
        resolved.collect::<Result<_, _>>().map(Self)
    }

    /// Announces the topics whose messages are relayed to a topic that the node publishes.
    pub(crate) fn announce(&self, topic: &RosName, header: ConnectionHeader) -> ConnectionHeader {
        let relayed = self.0.iter().filter(|(_, to)| to == topic);
        let relayed: Vec<&str> = relayed.map(|(from, _)| from.as_str()).collect();
        if relayed.is_empty() {
            return header;
        }
        header.with(FIELD, relayed.join(","))
    }

    /// The topics to which this node relays a topic.
    pub(crate) fn onward<'r>(&'r self, topic: &'r RosName) -> impl Iterator<Item = &'r str> {
        let own = self.0.iter().filter(move |(from, _)| from == topic);
        own.map(|(_, to)| to.as_str())
    }

    /// The relays for the node's API: `[[from, to], …]`.
    pub(crate) fn as_value(&self) -> XmlRpcValue {
        let pairs = self.0.iter().map(|(from, to)| {
            let pair = [from, to].map(|it| XmlRpcValue::text(it.as_str()));
            XmlRpcValue::Array(pair.to_vec())
        });
        XmlRpcValue::Array(pairs.collect())
    }

    /// The topics that the publisher of a header relays to its topic.
    pub(crate) fn announced(header: &ConnectionHeader) -> impl Iterator<Item = &str> {
        header.get(FIELD).into_iter().flat_map(|it| it.split(','))
    }

    /// Why messages of a publisher of this topic would go round; `None` if they do not.
    pub(crate) fn circle(&self, topic: &RosName, header: &ConnectionHeader) -> Option<String> {
        let announced = header.get(FIELD)?;
        let mut own = self.0.iter().filter(|(from, _)| from == topic);
        let (_, back) = own.find(|(_, to)| announced.split(',').any(|name| name == to.as_str()))?;
        let node = header.get("callerid").unwrap_or("(unnamed)");
        Some(format!(
            "messages would go round: `{node}` relays `{back}` to `{topic}`, and this node `{topic}` to `{back}`"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relays(node: &str, from: &str, to: &str) -> Relays {
        let node = RosName::node(node).unwrap();
        Relays::of(&node, &[(from.to_owned(), to.to_owned())]).unwrap()
    }

    #[test]
    fn a_relay_in_the_other_direction_is_noticed() {
        let name = |text| RosName::node(text).unwrap();
        let there = relays("/robot/there", "b", "/a");
        let header = ConnectionHeader::new().with("callerid", "/robot/there");
        let announced = there.announce(&name("/a"), header.clone());
        let here = relays("/here", "/a", "/robot/b");
        let reason = here.circle(&name("/a"), &announced);
        assert_eq!(
            reason.unwrap(),
            "messages would go round: `/robot/there` relays `/robot/b` to `/a`, and this node `/a` to `/robot/b`"
        );
        // what is relayed elsewhere, and what is not relayed
        assert_eq!(here.circle(&name("/c"), &announced), None);
        assert_eq!(
            relays("/here", "/a", "/c").circle(&name("/a"), &announced),
            None
        );
        assert_eq!(there.announce(&name("/c"), header.clone()), header);
        assert_eq!(here.circle(&name("/a"), &header), None);
    }
}
