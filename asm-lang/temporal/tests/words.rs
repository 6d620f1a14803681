//! The semantics of LTL on ultimately periodic paths, and of fairness.

use crate::random::Structure;
use asmotion_temporal::{Bits, Fairness, Graph, Lasso, Ltl, PathStep, Recurrent};

/// Asserts that a lasso is a path of the graph.
pub(crate) fn assert_is_path(graph: &Graph, lasso: &Lasso) {
    assert!(graph.initial().contains(&lasso.start), "{lasso:?}");
    let mut node = lasso.start;
    for step in lasso.stem.iter().chain(&lasso.cycle) {
        assert_eq!(graph.source(step.edge), Some(node), "{lasso:?}");
        assert_eq!(graph.target(step.edge), Some(step.node), "{lasso:?}");
        node = step.node;
    }
    if !lasso.cycle.is_empty() {
        assert_eq!(node, entry(lasso), "{lasso:?}");
    }
}

/// The node at the end of the stem.
pub(crate) fn entry(lasso: &Lasso) -> u32 {
    lasso.stem.last().map_or(lasso.start, |step| step.node)
}

pub(crate) fn is_fair(cycle: &[PathStep], fairness: &[Fairness]) -> bool {
    let recurs = |it: &Recurrent| {
        let mut steps = cycle.iter();
        steps.any(|step| it.contains_node(step.node) || it.contains_edge(step.edge as usize))
    };
    fairness.iter().all(|constraint| match constraint {
        Fairness::Justice(often) => recurs(often),
        Fairness::Compassion(cause, effect) => recurs(effect) || !recurs(cause),
    })
}

/// Returns whether a formula holds at the start of an infinite path.
pub(crate) fn holds(formula: &Ltl, lasso: &Lasso, atoms: &[Bits]) -> bool {
    let mut nodes = vec![lasso.start];
    nodes.extend(lasso.stem.iter().map(|step| step.node));
    // the value of a past operator repeats one cycle after those of its operands at the latest
    let rounds = past_operators(formula) + 2;
    for _ in 0..rounds {
        nodes.extend(lasso.cycle.iter().map(|step| step.node));
    }
    let back = nodes.len() - lasso.cycle.len();
    let word = Word { nodes, back, atoms };
    word.values(formula)[0]
}

fn past_operators(formula: &Ltl) -> usize {
    match formula {
        Ltl::True | Ltl::False | Ltl::Atom(_) => 0,
        Ltl::Not(of) | Ltl::Next(of) | Ltl::Finally(of) | Ltl::Globally(of) => past_operators(of),
        Ltl::Yesterday(of) | Ltl::WeakYesterday(of) | Ltl::Once(of) | Ltl::Historically(of) => {
            1 + past_operators(of)
        }
        Ltl::And(parts) | Ltl::Or(parts) => parts.iter().map(past_operators).sum(),
        Ltl::Implies(left, right)
        | Ltl::Iff(left, right)
        | Ltl::Until(left, right)
        | Ltl::Release(left, right)
        | Ltl::WeakUntil(left, right) => past_operators(left) + past_operators(right),
        Ltl::Since(left, right) | Ltl::Triggered(left, right) => {
            1 + past_operators(left) + past_operators(right)
        }
    }
}

/// Positions whose last one is followed by the position `back`.
struct Word<'a> {
    nodes: Vec<u32>,
    back: usize,
    atoms: &'a [Bits],
}

impl Word<'_> {
    fn values(&self, formula: &Ltl) -> Vec<bool> {
        let all = |value| vec![value; self.nodes.len()];
        match formula {
            Ltl::True => all(true),
            Ltl::False => all(false),
            Ltl::Atom(atom) => {
                let nodes = self.nodes.iter();
                nodes
                    .map(|node| self.atoms[*atom].contains(*node as usize))
                    .collect()
            }
            Ltl::Not(of) => self.values(of).into_iter().map(|it| !it).collect(),
            Ltl::And(parts) => self.fold(parts, true, |left, right| left && right),
            Ltl::Or(parts) => self.fold(parts, false, |left, right| left || right),
            Ltl::Implies(left, right) => self.pairs(left, right, |left, right| !left || right),
            Ltl::Iff(left, right) => self.pairs(left, right, |left, right| left == right),
            Ltl::Next(of) => {
                let of = self.values(of);
                (0..of.len()).map(|at| of[self.after(at)]).collect()
            }
            Ltl::Finally(of) => self.backwards(&all(true), &self.values(of), false),
            Ltl::Globally(of) => self.dual(&all(false), &self.values(of)),
            Ltl::Until(left, right) => {
                self.backwards(&self.values(left), &self.values(right), false)
            }
            Ltl::WeakUntil(left, right) => {
                self.backwards(&self.values(left), &self.values(right), true)
            }
            Ltl::Release(left, right) => self.dual(&self.values(left), &self.values(right)),
            Ltl::Yesterday(of) => self.previous(&self.values(of), false),
            Ltl::WeakYesterday(of) => self.previous(&self.values(of), true),
            Ltl::Once(of) => self.forwards(&all(true), &self.values(of)),
            Ltl::Historically(of) => self.forwards_dual(&all(false), &self.values(of)),
            Ltl::Since(left, right) => self.forwards(&self.values(left), &self.values(right)),
            Ltl::Triggered(left, right) => {
                self.forwards_dual(&self.values(left), &self.values(right))
            }
        }
    }

    fn after(&self, at: usize) -> usize {
        if at + 1 == self.nodes.len() {
            self.back
        } else {
            at + 1
        }
    }

    fn fold(&self, parts: &[Ltl], unit: bool, join: impl Fn(bool, bool) -> bool) -> Vec<bool> {
        let mut all = vec![unit; self.nodes.len()];
        for part in parts {
            for (value, part) in all.iter_mut().zip(self.values(part)) {
                *value = join(*value, part);
            }
        }
        all
    }

    fn pairs(&self, left: &Ltl, right: &Ltl, join: impl Fn(bool, bool) -> bool) -> Vec<bool> {
        let pairs = self.values(left).into_iter().zip(self.values(right));
        pairs.map(|(left, right)| join(left, right)).collect()
    }

    /// The least or greatest solution of `x = right or (left and next x)`.
    fn backwards(&self, left: &[bool], right: &[bool], greatest: bool) -> Vec<bool> {
        let mut values = vec![greatest; left.len()];
        for _ in 0..2 {
            for at in (0..left.len()).rev() {
                values[at] = right[at] || (left[at] && values[self.after(at)]);
            }
        }
        values
    }

    fn dual(&self, left: &[bool], right: &[bool]) -> Vec<bool> {
        let not = |values: &[bool]| values.iter().map(|it| !it).collect::<Vec<bool>>();
        not(&self.backwards(&not(left), &not(right), false))
    }

    fn previous(&self, of: &[bool], first: bool) -> Vec<bool> {
        let values = std::iter::once(first).chain(of.iter().copied());
        values.take(of.len()).collect()
    }

    fn forwards(&self, left: &[bool], right: &[bool]) -> Vec<bool> {
        let mut before = false;
        let pairs = left.iter().zip(right);
        let value = pairs.map(|(left, right)| {
            before = *right || (*left && before);
            before
        });
        value.collect()
    }

    fn forwards_dual(&self, left: &[bool], right: &[bool]) -> Vec<bool> {
        let not = |values: &[bool]| values.iter().map(|it| !it).collect::<Vec<bool>>();
        not(&self.forwards(&not(left), &not(right)))
    }
}

/// Calls a function with each fair lasso that continues a path of the given steps and has at most `length` further steps.
pub(crate) fn for_each_lasso(
    structure: &Structure,
    start: u32,
    steps: &mut Vec<PathStep>,
    length: usize,
    found: &mut dyn FnMut(&Lasso),
) {
    let end = steps.last().map_or(start, |step| step.node);
    let nodes = std::iter::once(start).chain(steps.iter().map(|step| step.node));
    for (at, node) in nodes.enumerate().take(steps.len()) {
        if node == end && is_fair(&steps[at..], &structure.fairness) {
            found(&Lasso {
                start,
                stem: steps[..at].to_vec(),
                cycle: steps[at..].to_vec(),
            });
        }
    }
    if length == 0 {
        return;
    }
    let graph = &structure.graph;
    for (edge, node) in graph.edges(end).zip(graph.successors(end)) {
        steps.push(PathStep {
            edge: edge as u32,
            node: *node,
        });
        for_each_lasso(structure, start, steps, length - 1, found);
        steps.pop();
    }
}
