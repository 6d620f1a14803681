//! Shortest fair cycles.

use crate::bits::Bits;
use crate::constraint::Constraint;
use crate::fairness::{Fairness, Recurrent};
use crate::lasso::{Lasso, PathStep};
use crate::rows::SparseRows;
use crate::search::ShortestPaths;
use crate::streett::FairComponents;
use rustc_hash::FxHashSet;

/// Largest number of cycles that are compared.
const CANDIDATES: usize = 256;

/// Largest number of pairs of a node and satisfied constraints that all searches for shortest cycles visit. Beyond it, cycles
/// satisfy one constraint after the other, each by the shortest path.
const EFFORT: usize = 1 << 18;

/// Number of candidates for which a second cycle is looked for.
const RETURNS: usize = 16;

/// A graph, or a product whose nodes and edges correspond to those of a graph, in which lassos are looked for.
pub(crate) struct LassoSearch<'a> {
    pub(crate) rows: &'a SparseRows,
    /// Nodes at which lassos start.
    pub(crate) from: &'a [u32],
    /// Nodes of which they consist.
    pub(crate) within: &'a Bits,
    pub(crate) origins: Option<(&'a [u32], &'a [u32])>,
    pub(crate) components: &'a FairComponents,
    pub(crate) constraints: &'a [Constraint<'a>],
}

impl LassoSearch<'_> {
    /// Returns a lasso with the shortest stem into a fair component, and of those the one with the shortest cycle.
    pub(crate) fn shortest(&self) -> Option<Lasso> {
        let may_pass = |node| self.within.contains(node as usize);
        let goal = &self.components.members;
        if goal.is_empty() {
            return None;
        }
        let (paths, arrivals) = ShortestPaths::to_nearest(self.rows, self.from, goal, may_pass);
        let mut cycles = CycleSearch {
            rows: self.rows,
            components: self.components,
            constraints: self.constraints,
            effort: EFFORT,
        };
        let mut best: Option<Lasso> = None;
        for (at, arrival) in arrivals.into_iter().take(CANDIDATES).enumerate() {
            if best.is_some() && cycles.effort == 0 {
                break;
            }
            let (start, stem) = paths.to_arrival(arrival);
            let again = stem.last().filter(|_| at < RETURNS).copied();
            let again = again.and_then(|last| self.repeating(&mut cycles, last));
            for cycle in [cycles.cycle(arrival.node), again].into_iter().flatten() {
                let stem = stem.clone();
                let lasso = self.described(Lasso { start, stem, cycle });
                let size = |it: &Lasso| (it.stem.len(), it.cycle.len());
                if best.as_ref().is_none_or(|best| size(&lasso) < size(best)) {
                    best = Some(lasso);
                }
            }
        }
        best
    }

    fn described(&self, lasso: Lasso) -> Lasso {
        let lasso = match self.origins {
            Some(origins) => lasso.projected(origins),
            None => lasso,
        };
        lasso.folded()
    }

    /// Returns a cycle that ends with the last step of the stem, up to the state of the automaton, which thereby becomes a part of the
    /// cycle: an automaton needs a step to enter a component where the path is in its cycle already.
    fn repeating(&self, cycles: &mut CycleSearch<'_>, last: PathStep) -> Option<Vec<PathStep>> {
        let (nodes, edges) = self.origins?;
        let region = self.components.region(last.node)?;
        let origin = edges[last.edge as usize];
        let source = nodes[self.rows.source(last.edge as usize)? as usize];
        let mut closing = Vec::new();
        let sources = nodes.iter().enumerate().filter(|(_, it)| **it == source);
        for (node, _) in sources {
            let node = node as u32;
            if self.components.region(node) != Some(region) {
                continue;
            }
            let steps = self.rows.edges(node).zip(self.rows.targets(node));
            closing.extend(steps.filter_map(|(edge, target)| {
                let is_same = *target == last.node && edges[edge] == origin;
                let is_inside = self.components.is_inside(region, edge, *target);
                (is_same && is_inside).then_some(edge)
            }));
        }
        if closing.is_empty() {
            return None;
        }
        cycles.shortest(last.node, region, |edge| closing.contains(&edge))
    }
}

struct CycleSearch<'a> {
    rows: &'a SparseRows,
    components: &'a FairComponents,
    constraints: &'a [Constraint<'a>],
    effort: usize,
}

/// A node, and what has occurred on the way to it.
struct Reached {
    node: u32,
    occurred: u64,
    /// Index of the previous one.
    parent: usize,
    edge: u32,
}

impl CycleSearch<'_> {
    /// Returns a fair cycle through a node of a fair component.
    fn cycle(&mut self, start: u32) -> Option<Vec<PathStep>> {
        let region = self.components.region(start)?;
        self.shortest(start, region, |_| true)
            .or_else(|| self.stepwise(start, region))
    }

    /// The bits of what occurs in a step: one for justice, two for cause and effect of compassion.
    fn occurring(&self, occurs: impl Fn(&Constraint<'_>, &Recurrent) -> bool) -> u64 {
        let mut bits = 0;
        for (at, constraint) in self.constraints.iter().enumerate() {
            bits |= match constraint.fairness {
                Fairness::Justice(often) => u64::from(occurs(constraint, often)) << (2 * at),
                Fairness::Compassion(cause, effect) => {
                    (u64::from(occurs(constraint, cause)) << (2 * at + 1))
                        | (u64::from(occurs(constraint, effect)) << (2 * at))
                }
            };
        }
        bits
    }

    fn is_fair(&self, occurred: u64) -> bool {
        let mut constraints = self.constraints.iter().enumerate();
        constraints.all(|(at, constraint)| {
            let of = occurred >> (2 * at);
            match constraint.fairness {
                Fairness::Justice(_) => of & 1 != 0,
                Fairness::Compassion(_, _) => of & 0b11 != 0b10,
            }
        })
    }

    /// Breadth-first search over nodes and what has occurred, for a cycle whose last edge satisfies `may_close`.
    fn shortest(
        &mut self,
        start: u32,
        region: u32,
        may_close: impl Fn(usize) -> bool,
    ) -> Option<Vec<PathStep>> {
        if self.constraints.len() > 32 {
            return None;
        }
        let occurred = self.occurring(|of, it| of.contains_node(it, start));
        let mut seen = FxHashSet::default();
        let mut queue = vec![Reached {
            node: start,
            occurred,
            parent: 0,
            edge: 0,
        }];
        let mut at = 0;
        while let Some(&Reached { node, occurred, .. }) = queue.get(at) {
            for (edge, &target) in self.rows.edges(node).zip(self.rows.targets(node)) {
                if !self.components.is_inside(region, edge, target) {
                    continue;
                }
                let of_step = self
                    .occurring(|of, it| of.contains_edge(it, edge) || of.contains_node(it, target));
                let reached = Reached {
                    node: target,
                    occurred: occurred | of_step,
                    parent: at,
                    edge: edge as u32,
                };
                if target == start && self.is_fair(reached.occurred) && may_close(edge) {
                    self.effort = self.effort.saturating_sub(queue.len());
                    return Some(path(&queue, reached));
                }
                if seen.insert((target, reached.occurred)) {
                    queue.push(reached);
                }
            }
            if queue.len() > self.effort {
                self.effort = 0;
                return None;
            }
            at += 1;
        }
        None
    }

    /// Satisfies the nearest unsatisfied constraint by the shortest path, until none is left, and returns to the start.
    fn stepwise(&self, start: u32, region: u32) -> Option<Vec<PathStep>> {
        let is_inside = |edge, target| self.components.is_inside(region, edge, target);
        let goals = self.constraints.iter().map(|it| (it, goal(it.fairness)));
        let mut missing: Vec<_> = goals
            .filter(|(of, it)| !of.contains_node(it, start))
            .collect();
        let (mut node, mut cycle) = (start, Vec::new());
        while !missing.is_empty() {
            let occurs = |edge, target| {
                let mut missing = missing.iter();
                missing.any(|(of, it)| of.contains_edge(it, edge) || of.contains_node(it, target))
            };
            // the rest are effects that the component lacks: it lacks the causes, too
            let Some(steps) = ShortestPaths::to_step(self.rows, node, is_inside, occurs) else {
                break;
            };
            for step in &steps {
                missing.retain(|(of, it)| {
                    !of.contains_edge(it, step.edge as usize) && !of.contains_node(it, step.node)
                });
                node = step.node;
            }
            cycle.extend(steps);
        }
        if node != start || cycle.is_empty() {
            let is_start = |_, target| target == start;
            let back = ShortestPaths::to_step(self.rows, node, is_inside, is_start)?;
            cycle.extend(back);
        }
        Some(cycle)
    }
}

fn goal(fairness: &Fairness) -> &Recurrent {
    match fairness {
        Fairness::Justice(often) => often,
        Fairness::Compassion(_, effect) => effect,
    }
}

fn path(queue: &[Reached], last: Reached) -> Vec<PathStep> {
    let mut path = Vec::new();
    let mut at = &last;
    loop {
        path.push(PathStep {
            edge: at.edge,
            node: at.node,
        });
        match queue.get(at.parent) {
            Some(parent) if at.parent != 0 => at = parent,
            Some(_) | None => break,
        }
    }
    path.reverse();
    path
}
