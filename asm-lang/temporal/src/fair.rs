//! Nodes from which fair paths start.

use crate::bits::Bits;
use crate::constraint::Constraint;
use crate::fairness::Fairness;
use crate::graph::Graph;
use crate::streett::fair_components;
use crate::verdict::FairPaths;

/// The nodes from which some fair path starts. A fair path contains no other nodes.
pub(crate) struct FairNodes {
    /// The nodes; `None` for all.
    nodes: Option<Bits>,
}

impl FairNodes {
    pub(crate) fn of(graph: &Graph, fairness: &[Fairness]) -> Self {
        // in a total relation every node starts a path
        if fairness.is_empty() {
            return Self { nodes: None };
        }
        let all = Bits::full(graph.node_count());
        let members = fair_components(graph.rows(), &all, &Constraint::all(fairness)).members;
        // the search backwards needs the predecessors of all nodes
        let nodes = (members != all).then(|| backwards(graph, &all, members));
        Self { nodes }
    }

    #[inline]
    pub(crate) fn contains(&self, node: u32) -> bool {
        let nodes = self.nodes.as_ref();
        nodes.is_none_or(|it| it.contains(node as usize))
    }

    /// Removes all other nodes from a set.
    pub(crate) fn restrict(&self, set: &mut Bits) {
        if let Some(nodes) = &self.nodes {
            set.intersect_with(nodes);
        }
    }

    /// Returns the initial nodes from which fair paths start.
    pub(crate) fn initial(&self, graph: &Graph) -> Vec<u32> {
        let initial = graph.initial().iter().copied();
        initial.filter(|node| self.contains(*node)).collect()
    }

    pub(crate) fn paths(&self, graph: &Graph) -> FairPaths {
        let all = graph.initial().len();
        match self.initial(graph).len() {
            0 => FairPaths::FromNone,
            some if some < all => FairPaths::FromSome,
            _ => FairPaths::FromAll,
        }
    }
}

/// Returns the nodes that reach `goal` through nodes of `through`: `E[through U goal]` without fairness.
pub(crate) fn backwards(graph: &Graph, through: &Bits, goal: Bits) -> Bits {
    let mut found = goal;
    let mut rest: Vec<u32> = found.ones().map(|node| node as u32).collect();
    while let Some(node) = rest.pop() {
        for source in graph.predecessors(node) {
            if through.contains(*source as usize) && found.insert(*source as usize) {
                rest.push(*source);
            }
        }
    }
    found
}
