//! Branching time on an explicit graph, by the definitions: sets of nodes that grow or shrink until nothing changes, and fair paths from
//! components that are found by reachability alone.

use crate::naive::Random;
use std::fmt;

/// A set of nodes.
pub type Nodes = Vec<bool>;

/// A condition on the paths that are considered.
pub enum Fair {
    /// Infinitely often at such a node, or along such an edge.
    Often(Nodes, fn(u32, u32) -> bool, u32),
    /// If infinitely often at such a node, then infinitely often along such an edge.
    IfOften(Nodes, fn(u32, u32) -> bool, u32),
}

/// Nodes with labelled edges. A path never ends.
#[derive(Default)]
pub struct Graph {
    pub initial: Vec<usize>,
    /// Target and label of the edges of each node.
    pub edges: Vec<Vec<(usize, u32)>>,
    pub fairness: Vec<Fair>,
}

impl Graph {
    /// Adds a loop to each node without successors.
    pub fn close(&mut self, label: u32) {
        for (node, edges) in self.edges.iter_mut().enumerate() {
            if edges.is_empty() {
                edges.push((node, label));
            }
        }
    }

    fn len(&self) -> usize {
        self.edges.len()
    }

    /// The nodes from which a path within `allowed` leads to `goal`.
    fn reaching(&self, allowed: &Nodes, goal: &Nodes) -> Nodes {
        let mut found: Nodes = (0..self.len()).map(|it| allowed[it] && goal[it]).collect();
        loop {
            let mut grows = false;
            for node in 0..self.len() {
                if allowed[node] && !found[node] && self.edges[node].iter().any(|it| found[it.0]) {
                    found[node] = true;
                    grows = true;
                }
            }
            if !grows {
                return found;
            }
        }
    }

    fn reached_from(&self, start: usize, within: &Nodes) -> Nodes {
        let mut found = vec![false; self.len()];
        let mut waiting = vec![start];
        while let Some(node) = waiting.pop() {
            for (target, _) in &self.edges[node] {
                if within[*target] && !found[*target] {
                    found[*target] = true;
                    waiting.push(*target);
                }
            }
        }
        found
    }

    /// The nodes on cycles within `within` that a fair path can repeat for ever.
    fn fair_cores(&self, within: &Nodes) -> Nodes {
        let mut cores = vec![false; self.len()];
        let reached: Vec<Nodes> = (0..self.len())
            .map(|node| {
                if within[node] {
                    self.reached_from(node, within)
                } else {
                    Vec::new()
                }
            })
            .collect();
        let mut done = vec![false; self.len()];
        for node in 0..self.len() {
            if !within[node] || done[node] || !reached[node][node] {
                continue;
            }
            let component: Nodes = (0..self.len())
                .map(|it| within[it] && reached[node][it] && reached[it][node])
                .collect();
            for (index, is_in) in component.iter().enumerate() {
                done[index] |= is_in;
            }
            let has_edge = |test: fn(u32, u32) -> bool, mask: u32| {
                (0..self.len()).filter(|it| component[*it]).any(|from| {
                    let mut edges = self.edges[from].iter();
                    edges.any(|(to, label)| component[*to] && test(*label, mask))
                })
            };
            let has_node = |nodes: &Nodes| (0..self.len()).any(|it| component[it] && nodes[it]);
            let mut rest = component.clone();
            let mut is_fair = true;
            for fair in &self.fairness {
                match fair {
                    Fair::Often(nodes, test, mask) => {
                        if !has_node(nodes) && !has_edge(*test, *mask) {
                            is_fair = false;
                            rest = vec![false; self.len()];
                        }
                    }
                    Fair::IfOften(nodes, test, mask) => {
                        if has_node(nodes) && !has_edge(*test, *mask) {
                            is_fair = false;
                            for index in 0..self.len() {
                                rest[index] &= !nodes[index];
                            }
                        }
                    }
                }
            }
            let found = if is_fair {
                component
            } else {
                self.fair_cores(&rest)
            };
            for (index, is_in) in found.iter().enumerate() {
                cores[index] |= is_in;
            }
        }
        cores
    }

    /// The nodes from which a fair path stays within `within`.
    pub fn fair_within(&self, within: &Nodes) -> Nodes {
        self.reaching(within, &self.fair_cores(within))
    }

    /// The nodes at which a formula is true.
    fn nodes_of(&self, formula: &Formula, truths: &dyn Fn(usize, &Condition) -> bool) -> Nodes {
        let all = vec![true; self.len()];
        let of = |formula: &Formula| self.nodes_of(formula, truths);
        let not = |nodes: Nodes| nodes.into_iter().map(|it| !it).collect::<Nodes>();
        let both = |left: &Nodes, right: &Nodes| {
            left.iter()
                .zip(right)
                .map(|(l, r)| *l && *r)
                .collect::<Nodes>()
        };
        let fair = || self.fair_within(&all);
        let next = |nodes: &Nodes| {
            let nodes = both(nodes, &fair());
            let some = |edges: &Vec<(usize, u32)>| edges.iter().any(|it| nodes[it.0]);
            self.edges.iter().map(some).collect::<Nodes>()
        };
        let until = |left: &Nodes, right: &Nodes| {
            let goal = both(right, &fair());
            let allowed = left.iter().zip(&goal).map(|(l, g)| *l || *g).collect();
            self.reaching(&allowed, &goal)
        };
        match formula {
            Formula::Is(condition) => (0..self.len()).map(|it| truths(it, condition)).collect(),
            Formula::Not(operand) => not(of(operand)),
            Formula::And(left, right) => both(&of(left), &of(right)),
            Formula::Or(left, right) => not(both(&not(of(left)), &not(of(right)))),
            Formula::Ex(operand) => next(&of(operand)),
            Formula::Ax(operand) => not(next(&not(of(operand)))),
            Formula::Ef(operand) => until(&all, &of(operand)),
            Formula::Ag(operand) => not(until(&all, &not(of(operand)))),
            Formula::Eg(operand) => self.fair_within(&of(operand)),
            Formula::Af(operand) => not(self.fair_within(&not(of(operand)))),
            Formula::Eu(left, right) => until(&of(left), &of(right)),
            Formula::Au(left, right) => {
                // neither is the right one false for ever, nor do both become false before it is true
                let (left, right) = (not(of(left)), not(of(right)));
                let fails = until(&right, &both(&left, &right));
                let never = self.fair_within(&right);
                fails.iter().zip(never).map(|(f, n)| !*f && !n).collect()
            }
        }
    }

    /// Returns `true` if a formula is true at all initial nodes from which a fair path starts.
    pub fn satisfies(&self, formula: &Formula, truths: &dyn Fn(usize, &Condition) -> bool) -> bool {
        let nodes = self.nodes_of(formula, truths);
        let fair = self.fair_within(&vec![true; self.len()]);
        self.initial.iter().all(|it| nodes[*it] || !fair[*it])
    }
}

/// A condition on a node.
#[derive(Clone, Debug)]
pub enum Condition {
    /// One of the atoms of a test.
    Atom(&'static str),
    Not(Box<Condition>),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
}

impl Condition {
    pub fn random(random: &mut Random, atoms: &[&'static str], depth: u32) -> Self {
        let operand = |random: &mut Random| Box::new(Self::random(random, atoms, depth - 1));
        match random.below(if depth == 0 { 1 } else { 5 }) {
            0 | 1 => Self::Atom(atoms[random.below(atoms.len() as u64) as usize]),
            2 => Self::Not(operand(random)),
            3 => Self::And(operand(random), operand(random)),
            _ => Self::Or(operand(random), operand(random)),
        }
    }

    pub fn is_true(&self, atom: &dyn Fn(&str) -> bool) -> bool {
        match self {
            Self::Atom(text) => atom(text),
            Self::Not(operand) => !operand.is_true(atom),
            Self::And(left, right) => left.is_true(atom) && right.is_true(atom),
            Self::Or(left, right) => left.is_true(atom) || right.is_true(atom),
        }
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Atom(text) => write!(f, "{text}"),
            Self::Not(operand) => write!(f, "not ({operand})"),
            Self::And(left, right) => write!(f, "({left} and {right})"),
            Self::Or(left, right) => write!(f, "({left} or {right})"),
        }
    }
}

/// A formula of branching time.
#[derive(Clone, Debug)]
pub enum Formula {
    Is(Condition),
    Not(Box<Formula>),
    And(Box<Formula>, Box<Formula>),
    Or(Box<Formula>, Box<Formula>),
    Ex(Box<Formula>),
    Ax(Box<Formula>),
    Ef(Box<Formula>),
    Af(Box<Formula>),
    Eg(Box<Formula>),
    Ag(Box<Formula>),
    Eu(Box<Formula>, Box<Formula>),
    Au(Box<Formula>, Box<Formula>),
}

impl Formula {
    /// A formula whose outermost operator is temporal.
    pub fn temporal(random: &mut Random, atoms: &[&'static str], depth: u32) -> Self {
        let operand = Box::new(Self::random(random, atoms, depth));
        match random.below(4) {
            0 | 1 => Self::Ag(operand),
            2 => Self::Ef(operand),
            _ => Self::Af(operand),
        }
    }

    fn random(random: &mut Random, atoms: &[&'static str], depth: u32) -> Self {
        if depth == 0 {
            return Self::Is(Condition::random(random, atoms, 1));
        }
        let kind = random.below(12);
        let mut operand = || Box::new(Self::random(random, atoms, depth - 1));
        match kind {
            0 => Self::Not(operand()),
            1 => Self::And(operand(), operand()),
            2 | 3 => Self::Or(operand(), operand()),
            4 => Self::Ex(operand()),
            5 => Self::Ax(operand()),
            6 => Self::Ef(operand()),
            7 => Self::Af(operand()),
            8 => Self::Eg(operand()),
            9 => Self::Ag(operand()),
            10 => Self::Eu(operand(), operand()),
            _ => Self::Au(operand(), operand()),
        }
    }
}

impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Is(condition) => write!(f, "{condition}"),
            Self::Not(operand) => write!(f, "not ({operand})"),
            Self::And(left, right) => write!(f, "(({left}) and ({right}))"),
            Self::Or(left, right) => write!(f, "(({left}) or ({right}))"),
            Self::Ex(operand) => write!(f, "ex({operand})"),
            Self::Ax(operand) => write!(f, "ax({operand})"),
            Self::Ef(operand) => write!(f, "ef({operand})"),
            Self::Af(operand) => write!(f, "af({operand})"),
            Self::Eg(operand) => write!(f, "eg({operand})"),
            Self::Ag(operand) => write!(f, "ag({operand})"),
            Self::Eu(left, right) => write!(f, "eu({left}, {right})"),
            Self::Au(left, right) => write!(f, "au({left}, {right})"),
        }
    }
}
