//! Operators of CTL on sets of nodes.

use crate::bits::Bits;
use crate::constraint::Constraint;
use crate::fair::{FairNodes, backwards};
use crate::fairness::Fairness;
use crate::graph::Graph;
use crate::streett::{FairComponents, fair_components};

/// A graph, and the paths that count.
pub(crate) struct Fixpoints<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) fairness: &'a [Fairness],
    pub(crate) fair: FairNodes,
}

impl<'a> Fixpoints<'a> {
    pub(crate) fn new(graph: &'a Graph, fairness: &'a [Fairness]) -> Self {
        Self {
            graph,
            fairness,
            fair: FairNodes::of(graph, fairness),
        }
    }

    /// `EX set`.
    pub(crate) fn next(&self, set: &Bits) -> Bits {
        let fair = self.fair_of(set);
        Bits::from_fn(self.graph.node_count(), |node| {
            let mut successors = self.graph.successors(node as u32).iter();
            successors.any(|it| fair.contains(*it as usize))
        })
    }

    /// `EX` repeated.
    pub(crate) fn after(&self, steps: u32, set: &Bits) -> Bits {
        let mut result = set.clone();
        for _ in 0..steps {
            let next = self.next(&result);
            if next == result {
                break;
            }
            result = next;
        }
        result
    }

    /// `E[through U goal]`.
    pub(crate) fn until(&self, through: &Bits, goal: &Bits) -> Bits {
        backwards(self.graph, through, self.fair_of(goal))
    }

    /// `EG set`.
    pub(crate) fn globally(&self, set: &Bits) -> Bits {
        if self.fairness.is_empty() {
            return self.for_ever(set);
        }
        backwards(self.graph, set, self.components(set).members)
    }

    /// The fair components among the nodes of a set.
    pub(crate) fn components(&self, set: &Bits) -> FairComponents {
        fair_components(self.graph.rows(), set, &Constraint::all(self.fairness))
    }

    /// The elements from which fair paths start.
    pub(crate) fn fair_of(&self, set: &Bits) -> Bits {
        let mut fair = set.clone();
        self.fair.restrict(&mut fair);
        fair
    }

    /// `EG set` without fairness: removes nodes whose successors in the set have all been removed.
    fn for_ever(&self, set: &Bits) -> Bits {
        let mut kept = set.clone();
        let mut counts = vec![0_u32; self.graph.node_count()];
        let mut removed = Vec::new();
        for node in set.ones() {
            let successors = self.graph.successors(node as u32).iter();
            let count = successors.filter(|it| set.contains(**it as usize)).count();
            counts[node] = count as u32;
            if count == 0 {
                removed.push(node as u32);
            }
        }
        while let Some(node) = removed.pop() {
            kept.remove(node as usize);
            for source in self.graph.predecessors(node) {
                if !set.contains(*source as usize) {
                    continue;
                }
                let count = &mut counts[*source as usize];
                *count -= 1;
                if *count == 0 {
                    removed.push(*source);
                }
            }
        }
        kept
    }
}
