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

    /// `EX` repeated. The sets come back to an earlier one at last; from then on only the rest of the division by the period counts
    /// (Brent's algorithm: the set to compare with is replaced after 1, 2, 4, … steps).
    pub(crate) fn after(&self, steps: u32, set: &Bits) -> Bits {
        let mut result = set.clone();
        let mut earlier = set.clone();
        let (mut rest, mut distance, mut patience) = (steps, 0, 1);
        while rest > 0 {
            result = self.next(&result);
            rest -= 1;
            distance += 1;
            if result == earlier {
                rest %= distance;
            }
            if distance == patience {
                earlier.clone_from(&result);
                distance = 0;
                patience *= 2;
            }
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
