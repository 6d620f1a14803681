//! Edges in compressed sparse rows: the edges of a node are consecutive.

use std::ops::Range;

/// The edges of a graph, ordered by source. A node can be without edges.
#[derive(Clone, Debug)]
pub(crate) struct SparseRows {
    /// First edge of each node, and the number of edges.
    offsets: Vec<u32>,
    targets: Vec<u32>,
}

impl SparseRows {
    pub(crate) fn new() -> Self {
        Self {
            offsets: vec![0],
            targets: Vec::new(),
        }
    }

    pub(crate) fn node_count(&self) -> usize {
        self.offsets.len() - 1
    }

    pub(crate) fn edge_count(&self) -> usize {
        self.targets.len()
    }

    /// Adds an edge of the node that has not ended.
    #[inline]
    pub(crate) fn push(&mut self, target: u32) {
        self.targets.push(target);
    }

    /// Ends a node. The caller keeps the number of edges below 2^32.
    pub(crate) fn end_node(&mut self) {
        self.offsets.push(self.targets.len() as u32);
    }

    /// Returns whether the node that has not ended has edges.
    pub(crate) fn has_pending(&self) -> bool {
        self.offsets
            .last()
            .is_some_and(|end| (*end as usize) < self.targets.len())
    }

    /// Returns the edges of a node; none for a node that does not exist.
    #[inline]
    pub(crate) fn edges(&self, node: u32) -> Range<usize> {
        let node = node as usize;
        match self.offsets.get(node..node + 2) {
            Some(&[begin, end]) => begin as usize..end as usize,
            Some(_) | None => 0..0,
        }
    }

    #[inline]
    pub(crate) fn targets(&self, node: u32) -> &[u32] {
        self.targets.get(self.edges(node)).unwrap_or_default()
    }

    #[inline]
    pub(crate) fn target(&self, edge: usize) -> Option<u32> {
        self.targets.get(edge).copied()
    }

    pub(crate) fn all_targets(&self) -> &[u32] {
        &self.targets
    }

    /// Returns the source of an edge by binary search.
    pub(crate) fn source(&self, edge: usize) -> Option<u32> {
        let is_edge = edge < self.targets.len();
        let after = self
            .offsets
            .partition_point(|begin| *begin as usize <= edge);
        is_edge.then(|| after.saturating_sub(1) as u32)
    }

    /// Returns the rows of the reversed edges, ordered by target and then by source.
    pub(crate) fn reversed(&self) -> Self {
        let mut offsets = vec![0_u32; self.offsets.len()];
        for target in &self.targets {
            offsets[*target as usize + 1] += 1;
        }
        let mut sum = 0;
        for offset in &mut offsets {
            sum += *offset;
            *offset = sum;
        }
        let mut next = offsets.clone();
        let mut targets = vec![0; self.targets.len()];
        for node in 0..self.node_count() as u32 {
            for target in self.targets(node) {
                let slot = &mut next[*target as usize];
                targets[*slot as usize] = node;
                *slot += 1;
            }
        }
        Self { offsets, targets }
    }
}
