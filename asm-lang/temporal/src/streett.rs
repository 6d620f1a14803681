//! Fair components: the parts of a graph around which a fair path can run for ever.

use crate::bits::Bits;
use crate::constraint::Constraint;
use crate::fairness::{Fairness, Recurrent};
use crate::rows::SparseRows;
use crate::scc::ComponentSearch;

/// Disjoint strongly connected subgraphs, in each of which some cycle visits all nodes and satisfies every constraint.
///
/// Every fair path ends in one of them, up to steps that it takes only finitely often: an infinite path stays in a strongly
/// connected component at last, and avoids the causes whose effects the component lacks.
#[derive(Debug)]
pub(crate) struct FairComponents {
    /// Component of each node; 0 for none.
    regions: Vec<u32>,
    /// Edges that no fair cycle takes, although both ends are in one component.
    excluded: Option<Bits>,
    /// The nodes of all components.
    pub(crate) members: Bits,
}

impl FairComponents {
    /// Returns the component of a node.
    pub(crate) fn region(&self, node: u32) -> Option<u32> {
        let region = self.regions.get(node as usize).copied();
        region.filter(|it| *it != 0)
    }

    /// Returns whether an edge to `target` leads from a node of a component to a node of the same.
    pub(crate) fn is_inside(&self, region: u32, edge: usize, target: u32) -> bool {
        self.regions[target as usize] == region && !self.is_excluded(edge)
    }

    fn is_excluded(&self, edge: usize) -> bool {
        self.excluded.as_ref().is_some_and(|it| it.contains(edge))
    }

    fn is_trivial(&self, rows: &SparseRows, nodes: &[u32]) -> bool {
        let &[node] = nodes else {
            return false;
        };
        let mut edges = rows.edges(node);
        !edges.any(|edge| rows.target(edge) == Some(node) && !self.is_excluded(edge))
    }

    /// Returns whether something occurs in a component, whose nodes have been assigned to `region`.
    fn occurs(
        &self,
        rows: &SparseRows,
        nodes: &[u32],
        region: u32,
        constraint: &Constraint<'_>,
        recurrent: &Recurrent,
    ) -> bool {
        let mut visited = nodes.iter();
        if visited.any(|node| constraint.contains_node(recurrent, *node)) {
            return true;
        }
        if recurrent.edges.is_none() {
            return false;
        }
        nodes.iter().any(|node| {
            let mut edges = rows.edges(*node).zip(rows.targets(*node));
            edges.any(|(edge, target)| {
                constraint.contains_edge(recurrent, edge) && self.is_inside(region, edge, *target)
            })
        })
    }
}

/// Computes the fair components of the subgraph with the nodes `within`.
///
/// A component that lacks what justice requires is dropped. One that lacks the effect of compassion loses the causes and is
/// decomposed again (Emerson and Lei's algorithm for Streett conditions).
pub(crate) fn fair_components(
    rows: &SparseRows,
    within: &Bits,
    constraints: &[Constraint<'_>],
) -> FairComponents {
    let has_compassion = constraints
        .iter()
        .any(|it| matches!(it.fairness, Fairness::Compassion(_, _)));
    let mut found = FairComponents {
        regions: vec![0; rows.node_count()],
        excluded: has_compassion.then(|| Bits::new(rows.edge_count())),
        members: Bits::new(rows.node_count()),
    };
    let mut search = ComponentSearch::new(rows.node_count());
    let mut regions = 0;
    let mut rest: Vec<Vec<u32>> = vec![within.ones().map(|node| node as u32).collect()];
    while let Some(nodes) = rest.pop() {
        let components = search.components(rows, &nodes, found.excluded.as_ref());
        assign(&mut found, &nodes, 0);
        for nodes in components.iter() {
            if found.is_trivial(rows, nodes) {
                continue;
            }
            regions += 1;
            assign(&mut found, nodes, regions);
            match judge(&mut found, rows, nodes, regions, constraints) {
                Judgement::Fair => {
                    for node in nodes {
                        found.members.insert(*node as usize);
                    }
                }
                Judgement::Unfair => assign(&mut found, nodes, 0),
                Judgement::Reduced(nodes) => rest.push(nodes),
            }
        }
    }
    found
}

fn assign(found: &mut FairComponents, nodes: &[u32], region: u32) {
    for node in nodes {
        found.regions[*node as usize] = region;
    }
}

enum Judgement {
    Fair,
    Unfair,
    /// Fair cycles, if any, are among these nodes and the edges that are not excluded.
    Reduced(Vec<u32>),
}

fn judge(
    found: &mut FairComponents,
    rows: &SparseRows,
    nodes: &[u32],
    region: u32,
    constraints: &[Constraint<'_>],
) -> Judgement {
    let mut avoided = Vec::new();
    for constraint in constraints {
        let occurs = |it| found.occurs(rows, nodes, region, constraint, it);
        match constraint.fairness {
            Fairness::Justice(often) => {
                if !occurs(often) {
                    return Judgement::Unfair;
                }
            }
            Fairness::Compassion(cause, effect) => {
                if !occurs(effect) && occurs(cause) {
                    avoided.push((constraint, cause));
                }
            }
        }
    }
    if avoided.is_empty() {
        return Judgement::Fair;
    }
    let mut kept = nodes.to_vec();
    for (constraint, cause) in avoided {
        kept.retain(|node| !constraint.contains_node(cause, *node));
        if let Some(excluded) = &mut found.excluded {
            let all = nodes.iter().flat_map(|node| rows.edges(*node));
            for edge in all.filter(|edge| constraint.contains_edge(cause, *edge)) {
                excluded.insert(edge);
            }
        }
    }
    assign(found, nodes, 0);
    Judgement::Reduced(kept)
}
