//! The order of starting: whoever is needed comes first, as far as circles allow.

use petgraph::Direction;
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;

use crate::plan::Plan;

/// The names of the components; where nothing decides, in the order of the files. A circle is
/// entered at its first component.
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
