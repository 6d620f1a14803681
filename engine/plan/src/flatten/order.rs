//! Start order: dependencies first, as far as cycles permit.

use petgraph::Direction;
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;

use crate::plan::Plan;

/// Returns the component names in start order. Independent components keep the file order; a cycle starts at its first
/// component in file order.
pub(super) fn start_order(plan: &Plan) -> Vec<String> {
    let graph = plan.graph();
    let mut waiting: Vec<NodeIndex> = graph.node_indices().collect();
    let mut order = Vec::new();
    let mut started = vec![false; waiting.len()];
    while !waiting.is_empty() {
        let is_started = |node: NodeIndex| started.get(node.index()).copied().unwrap_or(true);
        let ready = waiting.iter().position(|node| {
            let needed = graph.edges_directed(*node, Direction::Incoming);
            needed
                .map(|edge| edge.source())
                .all(|from| from == *node || is_started(from))
        });
        let next = waiting.remove(ready.unwrap_or(0));
        if let Some(done) = started.get_mut(next.index()) {
            *done = true;
        }
        if let Some(name) = graph.node_weight(next) {
            order.push((*name).to_owned());
        }
    }
    order
}
