//! Circles of relays of several nodes: what this node would receive comes, through others, from what it relays itself.
//!
//! Before this node receives from a publisher that relays, it follows the relays backwards: the master knows who publishes the
//! topics that they come from, and a node of this library tells its relays when it is asked ([`METHOD`]). A topic that nobody
//! publishes may be one outside ROS, such as that of a broker: all subscribers are asked who relays to it. A node registers its
//! publishers before its subscriptions. So the last node of a circle that registers finds all others, and does not receive; the
//! circle is open there.

use std::collections::{BTreeSet, VecDeque};

use crate::context::Context;
use crate::graph::named_lists;
use crate::header::ConnectionHeader;
use crate::http::RosUri;
use crate::names::RosName;
use crate::relays::{METHOD, Relays};
use crate::xmlrpc::XmlRpcValue;

/// Most topics that are followed. A circle with more is not found.
const TOPICS: usize = 64;
/// Most publishers of a topic that are asked.
const PUBLISHERS: usize = 16;

/// Why messages of a publisher of this topic would go round through further nodes; `None` if they do not, or the master does not
/// answer.
pub(crate) async fn longer_circle(
    context: &Context,
    topic: &RosName,
    header: &ConnectionHeader,
) -> Option<String> {
    let onward: BTreeSet<&str> = context.relays.onward(topic).collect();
    let mut seen: BTreeSet<String> = Relays::announced(header).map(str::to_owned).collect();
    if onward.is_empty() || seen.is_empty() {
        return None;
    }
    let state = context.master("getSystemState", &[]).await.ok()?;
    let [publishers, subscribers, ..] = state.as_array()? else {
        return None;
    };
    let (publishers, subscribers) = (named_lists(publishers)?, named_lists(subscribers)?);
    let subscribers = subscribers.iter().flat_map(|(_, nodes)| nodes);
    let subscribers: BTreeSet<&String> = subscribers.collect();
    // ways back from the topic, each with the topic that comes last
    let mut ways: VecDeque<Vec<String>> = seen.iter().map(|it| vec![it.clone()]).collect();
    while let Some(way) = ways.pop_front() {
        let last = way.last()?;
        if onward.contains(&**last) {
            return Some(reason(topic, header, &way));
        }
        let known = publishers.iter().find(|(name, _)| name == last);
        let nodes: Vec<&String> = match known {
            Some((_, nodes)) => nodes.iter().collect(),
            None => subscribers.iter().copied().collect(),
        };
        for node in nodes.into_iter().take(PUBLISHERS) {
            for from in relayed_by(context, node, last).await {
                if seen.len() < TOPICS && seen.insert(from.clone()) {
                    let longer = way.iter().cloned().chain([from]);
                    ways.push_back(longer.collect());
                }
            }
        }
    }
    None
}

/// The topics that a node relays to this one.
async fn relayed_by(context: &Context, node: &str, to: &str) -> Vec<String> {
    let relays = if node == context.name.as_str() {
        context.relays.as_value()
    } else {
        let uri = context
            .master("lookupNode", &[XmlRpcValue::text(node)])
            .await;
        let uri: Option<RosUri> = uri.ok().and_then(|it| it.as_text()?.parse().ok());
        let Some(uri) = uri else {
            return Vec::new();
        };
        // a node of another library does not know the method
        let Ok(relays) = context.api(&uri, METHOD, &[]).await else {
            return Vec::new();
        };
        relays
    };
    let pairs = relays.as_array().unwrap_or_default().iter();
    let pairs = pairs.filter_map(|pair| match *pair.as_texts()?.as_slice() {
        [from, it] if it == to => Some(from.to_owned()),
        _ => None,
    });
    pairs.collect()
}

/// The way leads backwards from the topic.
fn reason(topic: &RosName, header: &ConnectionHeader, way: &[String]) -> String {
    let node = header.get("callerid").unwrap_or("(unnamed)");
    let (last, next) = (way.first(), way.last());
    let (last, next) = (last.map_or("", |it| it), next.map_or("", |it| it));
    let topics: Vec<_> = way.iter().rev().map(|it| format!("`{it}`")).collect();
    format!(
        "messages would go round: `{node}` relays `{last}` to `{topic}`, and this node `{topic}` to `{next}`, from where they come through {}",
        topics.join(", ")
    )
}
