//! Fairness constraints on infinite paths.

use crate::bits::Bits;
use crate::error::TemporalError;
use crate::rows::SparseRows;

/// An event that occurs infinitely often: a visit to one of some nodes, or a step along one of some edges.
///
/// Without nodes and without edges it never occurs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recurrent {
    /// The nodes, if any.
    pub nodes: Option<Bits>,
    /// The edges, if any.
    pub edges: Option<Bits>,
}

/// A constraint on infinite paths.
///
/// Weak fairness of an agent is `Justice(nodes where it is not enabled, edges along which it moves)`; strong fairness is
/// `Compassion(nodes where it is enabled, edges along which it moves)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fairness {
    /// Occurs infinitely often.
    Justice(Recurrent),
    /// If the first occurs infinitely often, so does the second.
    Compassion(Recurrent, Recurrent),
}

impl Recurrent {
    /// Returns visits to one of these nodes.
    pub fn nodes(nodes: Bits) -> Self {
        Self {
            nodes: Some(nodes),
            edges: None,
        }
    }

    /// Returns steps along one of these edges.
    pub fn edges(edges: Bits) -> Self {
        Self {
            nodes: None,
            edges: Some(edges),
        }
    }

    /// Returns visits to one of these nodes and steps along one of these edges.
    pub fn nodes_or_edges(nodes: Bits, edges: Bits) -> Self {
        Self {
            nodes: Some(nodes),
            edges: Some(edges),
        }
    }

    /// Returns whether visiting this node is an occurrence.
    #[inline]
    pub fn contains_node(&self, node: u32) -> bool {
        let nodes = self.nodes.as_ref();
        nodes.is_some_and(|it| it.contains(node as usize))
    }

    /// Returns whether a step along this edge is an occurrence.
    #[inline]
    pub fn contains_edge(&self, edge: usize) -> bool {
        let edges = self.edges.as_ref();
        edges.is_some_and(|it| it.contains(edge))
    }

    fn validate(&self, rows: &SparseRows) -> Result<(), TemporalError> {
        let sets = [
            ("nodes", &self.nodes, rows.node_count()),
            ("edges", &self.edges, rows.edge_count()),
        ];
        for (what, bits, expected) in sets {
            let found = bits.as_ref().map_or(expected, Bits::size);
            if found != expected {
                return Err(TemporalError::SetSize {
                    what,
                    expected,
                    found,
                });
            }
        }
        Ok(())
    }
}

impl Fairness {
    pub(crate) fn validate(&self, rows: &SparseRows) -> Result<(), TemporalError> {
        match self {
            Self::Justice(often) => often.validate(rows),
            Self::Compassion(cause, effect) => {
                cause.validate(rows)?;
                effect.validate(rows)
            }
        }
    }
}
