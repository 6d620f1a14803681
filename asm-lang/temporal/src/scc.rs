//! Strongly connected components, without recursion.

use crate::bits::Bits;
use crate::rows::SparseRows;

/// Strongly connected components, each after those that it reaches.
#[derive(Debug, Default)]
pub(crate) struct Components {
    nodes: Vec<u32>,
    /// End of each component in `nodes`.
    ends: Vec<usize>,
}

impl Components {
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        let ranges = begins.zip(&self.ends);
        ranges.map(|(begin, end)| self.nodes.get(begin..*end).unwrap_or_default())
    }
}

/// A node whose edges are being followed.
struct OpenNode {
    node: u32,
    edge: u32,
    end: u32,
    is_root: bool,
}

/// Computes the components of subgraphs of one graph.
///
/// The algorithm is Pearce's space-efficient variant of Tarjan's ("A space-efficient algorithm for finding strongly connected
/// components", 2016): one number for each node, which is the position on the search path while the node is unfinished, and is
/// larger than every such position afterwards. Nodes outside of the subgraph have such a number from the beginning.
pub(crate) struct ComponentSearch {
    ranks: Vec<u32>,
    visits: Vec<OpenNode>,
    unfinished: Vec<u32>,
}

impl ComponentSearch {
    pub(crate) fn new(node_count: usize) -> Self {
        Self {
            ranks: vec![u32::MAX; node_count],
            visits: Vec::new(),
            unfinished: Vec::new(),
        }
    }

    /// Returns the components of the subgraph with these nodes and the edges between them that are not excluded.
    pub(crate) fn components(
        &mut self,
        rows: &SparseRows,
        nodes: &[u32],
        excluded: Option<&Bits>,
    ) -> Components {
        let mut found = Components::default();
        for node in nodes {
            self.ranks[*node as usize] = 0;
        }
        let mut next = 1;
        let mut finished = u32::MAX;
        for node in nodes {
            if self.ranks[*node as usize] == 0 {
                self.enter(rows, *node, &mut next);
                self.visit(rows, excluded, &mut next, &mut finished, &mut found);
            }
        }
        found
    }

    fn enter(&mut self, rows: &SparseRows, node: u32, next: &mut u32) {
        self.ranks[node as usize] = *next;
        *next += 1;
        let edges = rows.edges(node);
        self.visits.push(OpenNode {
            node,
            edge: edges.start as u32,
            end: edges.end as u32,
            is_root: true,
        });
    }

    /// Visits everything that is reachable from the node entered last.
    fn visit(
        &mut self,
        rows: &SparseRows,
        excluded: Option<&Bits>,
        next: &mut u32,
        finished: &mut u32,
        found: &mut Components,
    ) {
        let targets = rows.all_targets();
        while let Some(visit) = self.visits.last_mut() {
            if visit.edge == visit.end {
                let (node, is_root) = (visit.node, visit.is_root);
                self.visits.pop();
                if is_root {
                    self.finish(node, next, finished, found);
                } else {
                    self.unfinished.push(node);
                }
                continue;
            }
            let target = targets[visit.edge as usize];
            if excluded.is_some_and(|it| it.contains(visit.edge as usize)) {
                visit.edge += 1;
                continue;
            }
            let rank = self.ranks[target as usize];
            if rank == 0 {
                // this edge is looked at again when the target is finished
                self.enter(rows, target, next);
                continue;
            }
            visit.edge += 1;
            let own = &mut self.ranks[visit.node as usize];
            if rank < *own {
                *own = rank;
                visit.is_root = false;
            }
        }
    }

    /// Takes the component of which `root` was entered first from the unfinished nodes.
    fn finish(&mut self, root: u32, next: &mut u32, finished: &mut u32, found: &mut Components) {
        let rank = self.ranks[root as usize];
        found.nodes.push(root);
        *next -= 1;
        while let Some(&node) = self.unfinished.last()
            && rank <= self.ranks[node as usize]
        {
            self.unfinished.pop();
            found.nodes.push(node);
            self.ranks[node as usize] = *finished;
            *next -= 1;
        }
        self.ranks[root as usize] = *finished;
        *finished -= 1;
        found.ends.push(found.nodes.len());
    }
}
