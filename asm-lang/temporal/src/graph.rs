//! Finite graphs with labelled edges, initial nodes and a total relation.

use crate::bits::Bits;
use crate::error::TemporalError;
use crate::rows::SparseRows;
use std::ops::Range;
use std::sync::OnceLock;

/// A finite graph (Kripke structure) in which every node has a successor.
///
/// Nodes and edges are numbered from 0; the edges of a node are consecutive. An edge takes 8 bytes, and 4 more once a check needs
/// predecessors.
#[derive(Debug)]
pub struct Graph {
    rows: SparseRows,
    labels: Vec<u32>,
    initial: Vec<u32>,
    stuttering: usize,
    reversed: OnceLock<SparseRows>,
}

impl Graph {
    /// Label of the self-loops that are added to nodes without edges.
    pub const STUTTER: u32 = u32::MAX;

    /// Returns the number of nodes.
    pub fn node_count(&self) -> usize {
        self.rows.node_count()
    }

    /// Returns the number of edges.
    pub fn edge_count(&self) -> usize {
        self.rows.edge_count()
    }

    /// Returns the initial nodes in ascending order.
    pub fn initial(&self) -> &[u32] {
        &self.initial
    }

    /// Returns the number of self-loops that were added to nodes without edges.
    pub fn stuttering(&self) -> usize {
        self.stuttering
    }

    /// Returns the edges of a node; none for a node that does not exist.
    pub fn edges(&self, node: u32) -> Range<usize> {
        self.rows.edges(node)
    }

    /// Returns the successors of a node, in the order of its edges.
    pub fn successors(&self, node: u32) -> &[u32] {
        self.rows.targets(node)
    }

    /// Returns the predecessors of a node in ascending order, one for each edge.
    pub fn predecessors(&self, node: u32) -> &[u32] {
        self.reversed().targets(node)
    }

    /// Returns the source of an edge.
    pub fn source(&self, edge: u32) -> Option<u32> {
        self.rows.source(edge as usize)
    }

    /// Returns the target of an edge.
    pub fn target(&self, edge: u32) -> Option<u32> {
        self.rows.target(edge as usize)
    }

    /// Returns the label of an edge.
    pub fn label(&self, edge: u32) -> Option<u32> {
        self.labels.get(edge as usize).copied()
    }

    /// Returns the edges whose label satisfies a condition.
    pub fn edges_with(&self, mut is_meant: impl FnMut(u32) -> bool) -> Bits {
        let is_meant = |edge: usize| self.labels.get(edge).is_some_and(|it| is_meant(*it));
        Bits::from_fn(self.edge_count(), is_meant)
    }

    pub(crate) fn rows(&self) -> &SparseRows {
        &self.rows
    }

    pub(crate) fn reversed(&self) -> &SparseRows {
        self.reversed.get_or_init(|| self.rows.reversed())
    }
}

/// Builds a [`Graph`], one node after the other.
#[derive(Debug)]
pub struct GraphBuilder {
    rows: SparseRows,
    labels: Vec<u32>,
    stuttering: usize,
    has_reserved_label: bool,
}

impl Default for GraphBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl GraphBuilder {
    /// Returns a builder without nodes.
    pub fn new() -> Self {
        Self {
            rows: SparseRows::new(),
            labels: Vec::new(),
            stuttering: 0,
            has_reserved_label: false,
        }
    }

    /// Adds an edge of the current node. The target can be a node that is added later.
    pub fn edge(&mut self, target: u32, label: u32) {
        self.has_reserved_label |= label == Graph::STUTTER;
        self.rows.push(target);
        self.labels.push(label);
    }

    /// Ends the current node and begins the next one. A node without edges gets an edge to itself with the label
    /// [`Graph::STUTTER`].
    pub fn end_node(&mut self) {
        if !self.rows.has_pending() {
            self.rows.push(self.rows.node_count() as u32);
            self.labels.push(Graph::STUTTER);
            self.stuttering += 1;
        }
        self.rows.end_node();
    }

    /// Returns the graph with the given initial nodes.
    ///
    /// # Errors
    /// A target or initial node does not exist, an edge has the reserved label, the last node was not ended, there is no initial node,
    /// or there are 2^32 - 1 nodes or edges.
    pub fn finish(self, mut initial: Vec<u32>) -> Result<Graph, TemporalError> {
        let count = self.rows.node_count();
        if count >= u32::MAX as usize {
            return Err(TemporalError::TooLarge("nodes"));
        }
        if self.rows.edge_count() >= u32::MAX as usize {
            return Err(TemporalError::TooLarge("edges"));
        }
        if self.rows.has_pending() {
            return Err(TemporalError::UnfinishedNode);
        }
        if self.has_reserved_label {
            return Err(TemporalError::ReservedLabel);
        }
        let mut nodes = self.rows.all_targets().iter().chain(&initial);
        if let Some(&node) = nodes.find(|node| **node as usize >= count) {
            return Err(TemporalError::UnknownNode { node, count });
        }
        if initial.is_empty() {
            return Err(TemporalError::NoInitialNode);
        }
        initial.sort_unstable();
        initial.dedup();
        Ok(Graph {
            rows: self.rows,
            labels: self.labels,
            initial,
            stuttering: self.stuttering,
            reversed: OnceLock::new(),
        })
    }
}
