//! Fairness constraints on a graph, or on its product with an automaton.

use crate::fairness::{Fairness, Recurrent};

/// A constraint on the paths of a graph whose nodes and edges can correspond to those of another graph.
#[derive(Clone, Copy)]
pub(crate) struct Constraint<'a> {
    pub(crate) fairness: &'a Fairness,
    /// The nodes and edges that the constraint means; `None` if they are those of the graph.
    pub(crate) origins: Option<(&'a [u32], &'a [u32])>,
}

impl<'a> Constraint<'a> {
    /// Returns the constraints of a graph on itself.
    pub(crate) fn all(fairness: &'a [Fairness]) -> Vec<Self> {
        let own = |fairness| Self {
            fairness,
            origins: None,
        };
        fairness.iter().map(own).collect()
    }

    /// Returns whether visiting a node is an occurrence.
    #[inline]
    pub(crate) fn contains_node(&self, recurrent: &Recurrent, node: u32) -> bool {
        recurrent.nodes.is_some()
            && recurrent.contains_node(match self.origins {
                Some((nodes, _)) => nodes[node as usize],
                None => node,
            })
    }

    /// Returns whether a step along an edge is an occurrence.
    #[inline]
    pub(crate) fn contains_edge(&self, recurrent: &Recurrent, edge: usize) -> bool {
        recurrent.edges.is_some()
            && recurrent.contains_edge(match self.origins {
                Some((_, edges)) => edges[edge] as usize,
                None => edge,
            })
    }
}
