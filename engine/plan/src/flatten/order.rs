//! Start order: dependencies first, as far as cycles permit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use petgraph::graph::NodeIndex;

use crate::plan::Plan;

/// Returns the component names in start order. Independent components keep the file order; a cycle starts at its first
/// component in file order.
pub(super) fn start_order(plan: &Plan) -> Vec<String> {
    let graph = plan.graph();
    // edges from components that have not started, by component
    let mut missing = vec![0_usize; graph.node_count()];
    let edges = || {
        let edges = graph.edge_indices();
        let ends = edges.filter_map(|edge| graph.edge_endpoints(edge));
        ends.filter(|(from, to)| from != to)
    };
    for (_, to) in edges() {
        missing[to.index()] += 1;
    }
    let ready = graph.node_indices();
    let ready = ready.filter(|node| missing[node.index()] == 0);
    let mut ready: BinaryHeap<Reverse<NodeIndex>> = ready.map(Reverse).collect();
    // in file order, for cycles
    let mut waiting = graph.node_indices();
    let mut started = vec![false; graph.node_count()];
    let mut order = Vec::with_capacity(graph.node_count());
    while let Some(next) = ready.pop().map(|Reverse(node)| node).or_else(|| {
        let waiting = waiting.by_ref();
        waiting.find(|node| !started[node.index()])
    }) {
        if std::mem::replace(&mut started[next.index()], true) {
            continue;
        }
        order.push(graph[next].to_owned());
        for needing in graph.neighbors(next).filter(|it| *it != next) {
            let missing = &mut missing[needing.index()];
            *missing -= 1;
            if *missing == 0 {
                ready.push(Reverse(needing));
            }
        }
    }
    order
}
