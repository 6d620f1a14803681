//! The simplest of the shortest runs to show a verdict: see [`layers`](crate::layers).

use crate::counterexample::{NodePath, Replay};
use crate::explore::Exploration;
use crate::layers::{FailingStep, LayeredPath, MAX_LAYER_EXECUTIONS, best_path};
use crate::transition::TransitionSystem;
use std::collections::BTreeSet;

/// Limit for the nodes of a layer of a cycle.
const MAX_CYCLE_LAYER: usize = 1 << 12;

/// Nodes of which a run takes one after each step.
type Layers = Vec<Vec<u32>>;

impl<S: TransitionSystem> Replay<'_, S> {
    /// Returns the simplest of the shortest paths to one of several nodes, which are as far from the start as the first one.
    pub fn simplest_to(&self, goals: &[u32]) -> NodePath {
        let Some(first) = goals.first() else {
            return NodePath::default();
        };
        if self.exploration.stands_for_others() {
            return NodePath::to(self.exploration, *first);
        }
        let layers = stem(self.exploration, goals);
        match self.best(&layers, None, None) {
            Some(found) => path_of(found, None),
            None => self.with_same_nodes(NodePath::to(self.exploration, *first)),
        }
    }

    /// Returns the simplest of the shortest paths to a step that fails.
    pub fn simplest_failing(&self, path: NodePath) -> NodePath {
        let (Some(last), Some(failing)) = (path.nodes.last(), &path.failing) else {
            return path;
        };
        if self.exploration.stands_for_others() {
            return path;
        }
        let layers = stem(self.exploration, &[*last]);
        match self.best(&layers, Some(FailingStep(failing)), None) {
            Some(mut found) => {
                found.decisions.pop();
                NodePath {
                    failing: path.failing,
                    ..path_of(found, None)
                }
            }
            None => path,
        }
    }

    /// Returns the simplest path that has the length and the last node of a path without a cycle, and for which `shows` holds.
    pub fn simplest_end(&self, path: NodePath, shows: &dyn Fn(&NodePath) -> bool) -> NodePath {
        let Some(last) = path.nodes.last() else {
            return path;
        };
        if self.exploration.stands_for_others() {
            return path;
        }
        let is_shortest = self.exploration.path(*last).len() == path.nodes.len();
        let other = is_shortest.then(|| self.simplest_to(&[*last]));
        match other.filter(|other| other.nodes.len() == path.nodes.len() && shows(other)) {
            Some(other) => other,
            None => self.with_same_nodes(path),
        }
    }

    /// Returns the simplest path with the lengths of a path that ends in a cycle, and for which `shows` holds.
    pub fn simplest_lasso(&self, path: NodePath, shows: &dyn Fn(&NodePath) -> bool) -> NodePath {
        let fixed = singles(&path);
        let Some((cycle, first)) = path.cycle.zip(path.cycle.and_then(|at| path.nodes.get(at)))
        else {
            return path;
        };
        if self.exploration.stands_for_others() {
            return path;
        }
        let is_shortest = self.exploration.path(*first).len() == cycle + 1;
        let stem = if is_shortest {
            stem(self.exploration, &[*first])
        } else {
            fixed.get(..=cycle).unwrap_or_default().to_vec()
        };
        let fixed_cycle = fixed.get(cycle..).unwrap_or_default();
        let free_cycle = cycle_layers(self.exploration, *first, path.nodes.len() - cycle);
        for cycle_layers in [free_cycle.as_deref(), Some(fixed_cycle)] {
            let later = cycle_layers.and_then(|layers| layers.get(1..));
            let layers = stem.iter().chain(later.unwrap_or_default()).cloned();
            let found = self.best(&layers.collect::<Layers>(), None, None);
            let other = found.map(|found| path_of(found, Some(cycle)));
            if let Some(other) = other
                && later.is_some()
                && shows(&other)
            {
                return other;
            }
        }
        self.with_same_nodes(path)
    }

    /// Returns the path through the same nodes with the simplest steps.
    fn with_same_nodes(&self, path: NodePath) -> NodePath {
        match self.best(&singles(&path), None, Some(&path)) {
            Some(found) => NodePath {
                decisions: found.decisions,
                moved: found.moved,
                ..path
            },
            None => path,
        }
    }

    fn best(
        &self,
        layers: &[Vec<u32>],
        failing: Option<FailingStep<'_>>,
        labelled: Option<&NodePath>,
    ) -> Option<LayeredPath> {
        // too many, as at least one step of each node is executed
        let starts = layers
            .split_last()
            .map_or(0, |(_, starts)| starts.iter().map(Vec::len).sum());
        if starts > MAX_LAYER_EXECUTIONS as usize {
            return None;
        }
        let mut system = self.system.clone();
        system.keep_candidates();
        let wanted = labelled.map(|path| path.moved.as_slice());
        let wanted = wanted.unwrap_or_default();
        best_path(
            &system,
            self.exploration,
            layers,
            failing,
            self.fair,
            wanted,
        )
    }
}

fn path_of(mut found: LayeredPath, cycle: Option<usize>) -> NodePath {
    if cycle.is_some() {
        // the last node is the first one of the cycle
        found.nodes.pop();
    }
    NodePath {
        nodes: found.nodes,
        decisions: found.decisions,
        moved: found.moved,
        cycle,
        ..NodePath::default()
    }
}

/// Returns the nodes of a path as layers, and for a cycle the node to which it returns.
fn singles(path: &NodePath) -> Layers {
    let back = path.cycle.and_then(|at| path.nodes.get(at));
    let nodes = path.nodes.iter().chain(back);
    nodes.map(|node| vec![*node]).collect()
}

/// Returns the layers of the shortest paths to nodes of the same depth. Without transitions, they contain other nodes, too.
fn stem(exploration: &Exploration, goals: &[u32]) -> Layers {
    let first = goals.first().copied().unwrap_or_default();
    let depth = exploration.path(first).len() - 1;
    let mut layers = vec![goals.to_vec()];
    for level in (0..depth).rev() {
        let nodes = exploration.level(level);
        let next: BTreeSet<u32> = layers.last().into_iter().flatten().copied().collect();
        let leads_on = |node: &u32| {
            let mut successors = exploration.successors(*node);
            !exploration.keeps_edges || successors.any(|it| next.contains(&it))
        };
        layers.push(nodes.filter(leads_on).collect());
    }
    layers.reverse();
    layers
}

/// Returns the layers of the cycles of this length through a node; `None` if they have too many nodes.
fn cycle_layers(exploration: &Exploration, node: u32, length: usize) -> Option<Layers> {
    let mut layers: Vec<BTreeSet<u32>> = vec![BTreeSet::from([node])];
    for _ in 0..length {
        let from = layers.last()?.iter();
        let next = from.flat_map(|node| exploration.successors(*node));
        let next: BTreeSet<u32> = next.collect();
        if next.len() > MAX_CYCLE_LAYER {
            return None;
        }
        layers.push(next);
    }
    layers.last_mut()?.retain(|it| *it == node);
    for index in (0..length).rev() {
        let next = layers.get(index + 1)?.clone();
        layers.get_mut(index)?.retain(|node| {
            let mut successors = exploration.successors(*node);
            successors.any(|it| next.contains(&it))
        });
    }
    let lists = layers.into_iter().map(|layer| layer.into_iter().collect());
    Some(lists.collect())
}
