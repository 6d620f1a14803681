//! Shortest fair cycles.

use crate::bits::Bits;
use crate::constraint::Constraint;
use crate::fairness::{Fairness, Recurrent};
use crate::lasso::{Lasso, PathStep};
use crate::rows::Rows;
use crate::search::ShortestPaths;
use crate::streett::FairComponents;
use rustc_hash::FxHashSet;

/// Largest number of cycles that are compared.
const CANDIDATES: usize = 256;

/// Largest number of pairs of a node and satisfied constraints that all searches for shortest cycles visit. Beyond it, cycles
/// satisfy one constraint after the other, each by the shortest path.
const EFFORT: usize = 1 << 18;

/// Returns a lasso with the shortest stem that leads from one of `from` through nodes of `within` into a fair component, and of those
/// the one with the shortest cycle; both after `finish`.
pub(crate) fn shortest_lasso(
    rows: &Rows,
    from: &[u32],
    within: &Bits,
    components: &FairComponents,
    constraints: &[Constraint<'_>],
    finish: impl Fn(Lasso) -> Lasso,
) -> Option<Lasso> {
    let may_pass = |node| within.contains(node as usize);
    let (paths, ends) = ShortestPaths::to_nearest(rows, from, &components.members, may_pass);
    let mut search = CycleSearch {
        rows,
        components,
        constraints,
        effort: EFFORT,
    };
    let mut best: Option<Lasso> = None;
    for end in ends.into_iter().take(CANDIDATES) {
        if best.is_some() && search.effort == 0 {
            break;
        }
        let (start, stem) = paths.path_to(end);
        let Some(cycle) = search.cycle(end) else {
            continue;
        };
        let lasso = finish(Lasso { start, stem, cycle });
        let size = |it: &Lasso| (it.stem.len(), it.cycle.len());
        if best.as_ref().is_none_or(|best| size(&lasso) < size(best)) {
            best = Some(lasso);
        }
    }
    best
}

struct CycleSearch<'a> {
    rows: &'a Rows,
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
        self.shortest(start, region)
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

    /// Breadth-first search over nodes and what has occurred.
    fn shortest(&mut self, start: u32, region: u32) -> Option<Vec<PathStep>> {
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
                if target == start && self.is_fair(reached.occurred) {
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
