//! Shortest paths by breadth-first search.

use crate::bits::Bits;
use crate::lasso::PathStep;
use crate::rows::SparseRows;
use rustc_hash::FxHashMap;
use std::collections::hash_map::Entry;

/// Shortest paths from some nodes to all nodes that a search has reached.
pub(crate) struct ShortestPaths<'a> {
    rows: &'a SparseRows,
    /// The edge by which each node was reached first; `None` where the search started.
    entered: FxHashMap<u32, Option<u32>>,
}

/// The end of a path.
#[derive(Clone, Copy)]
pub(crate) struct NearestNode {
    pub(crate) node: u32,
    /// The last edge; `None` for a path without steps.
    pub(crate) edge: Option<u32>,
}

impl<'a> ShortestPaths<'a> {
    fn new(rows: &'a SparseRows, from: &[u32]) -> Self {
        Self {
            rows,
            entered: from.iter().map(|node| (*node, None)).collect(),
        }
    }

    /// Returns the paths, and all ways to arrive at nodes of the set `goal` at the least distance. The search continues with the nodes
    /// for which `may_pass` holds.
    pub(crate) fn to_nearest(
        rows: &'a SparseRows,
        from: &[u32],
        goal: &Bits,
        may_pass: impl Fn(u32) -> bool,
    ) -> (Self, Vec<NearestNode>) {
        let mut paths = Self::new(rows, from);
        let at_start = from.iter().filter(|node| goal.contains(**node as usize));
        let at_start = at_start.map(|node| NearestNode {
            node: *node,
            edge: None,
        });
        let mut arrivals: Vec<NearestNode> = at_start.collect();
        let mut level = from.to_vec();
        while !level.is_empty() && arrivals.is_empty() {
            let mut next = Vec::new();
            for node in level.into_iter().filter(|node| may_pass(*node)) {
                for (edge, &target) in rows.edges(node).zip(rows.targets(node)) {
                    let edge = Some(edge as u32);
                    if goal.contains(target as usize) {
                        let node = target;
                        arrivals.push(NearestNode { node, edge });
                    } else if let Entry::Vacant(entry) = paths.entered.entry(target) {
                        entry.insert(edge);
                        next.push(target);
                    }
                }
            }
            level = next;
        }
        (paths, arrivals)
    }

    /// Returns the shortest path from `from` along edges for which `may_follow` holds, which takes at least one step and whose last
    /// step alone satisfies `is_goal`. Both are given an edge and its target.
    pub(crate) fn to_step(
        rows: &'a SparseRows,
        from: u32,
        may_follow: impl Fn(usize, u32) -> bool,
        is_goal: impl Fn(usize, u32) -> bool,
    ) -> Option<Vec<PathStep>> {
        let mut paths = Self::new(rows, &[from]);
        let mut queue = vec![from];
        let mut at = 0;
        while let Some(&node) = queue.get(at) {
            at += 1;
            for (edge, &target) in rows.edges(node).zip(rows.targets(node)) {
                if !may_follow(edge, target) {
                    continue;
                }
                if is_goal(edge, target) {
                    let (_, mut path) = paths.path_to(node);
                    path.push(PathStep {
                        edge: edge as u32,
                        node: target,
                    });
                    return Some(path);
                }
                if let Entry::Vacant(entry) = paths.entered.entry(target) {
                    entry.insert(Some(edge as u32));
                    queue.push(target);
                }
            }
        }
        None
    }

    /// Returns the path that arrives at a nearest node, and where it starts.
    pub(crate) fn to_arrival(&self, arrival: NearestNode) -> (u32, Vec<PathStep>) {
        let NearestNode { node, edge } = arrival;
        let source = edge.and_then(|edge| self.rows.source(edge as usize));
        let (Some(edge), Some(source)) = (edge, source) else {
            return (node, Vec::new());
        };
        let (start, mut path) = self.path_to(source);
        path.push(PathStep { edge, node });
        (start, path)
    }

    /// Returns the path to a node that has been reached, and where it starts.
    fn path_to(&self, end: u32) -> (u32, Vec<PathStep>) {
        let mut path = Vec::new();
        let mut node = end;
        while let Some(Some(edge)) = self.entered.get(&node) {
            path.push(PathStep { edge: *edge, node });
            let Some(source) = self.rows.source(*edge as usize) else {
                break;
            };
            node = source;
        }
        path.reverse();
        (node, path)
    }
}
