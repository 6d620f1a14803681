//! Random graphs, sets, constraints and formulas.

use asmotion_temporal::{Bits, Ctl, Fairness, Graph, GraphBuilder, Ltl, Recurrent};

/// A generator of pseudo-random numbers (xorshift).
pub(crate) struct Random(u64);

/// A graph with atoms and constraints.
#[derive(Debug)]
pub(crate) struct Structure {
    pub(crate) graph: Graph,
    pub(crate) atoms: Vec<Bits>,
    pub(crate) fairness: Vec<Fairness>,
}

pub(crate) const ATOMS: usize = 3;

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        random.below(2);
        random
    }

    pub(crate) fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) % bound as u64) as usize
    }

    pub(crate) fn one_in(&mut self, bound: usize) -> bool {
        self.below(bound) == 0
    }

    pub(crate) fn bits(&mut self, size: usize, one_in: usize) -> Bits {
        Bits::from_fn(size, |_| self.one_in(one_in))
    }

    /// Returns a graph with at most `nodes` nodes and about 1.7 edges for each.
    pub(crate) fn graph(&mut self, nodes: usize) -> Graph {
        let count = 1 + self.below(nodes);
        let mut builder = GraphBuilder::new();
        for _ in 0..count {
            let edges = [0, 1, 1, 2, 2, 2, 3][self.below(7)];
            for label in 0..edges {
                builder.edge(self.below(count) as u32, label);
            }
            builder.end_node();
        }
        let mut initial = vec![self.below(count) as u32];
        if self.one_in(3) {
            initial.push(self.below(count) as u32);
        }
        builder.finish(initial).expect("a lawful graph")
    }

    fn recurrent(&mut self, graph: &Graph) -> Recurrent {
        let nodes = self.bits(graph.node_count(), 3);
        let edges = self.bits(graph.edge_count(), 4);
        match self.below(4) {
            0 | 1 => Recurrent::nodes(nodes),
            2 => Recurrent::edges(edges),
            _ => Recurrent::nodes_or_edges(nodes, edges),
        }
    }

    pub(crate) fn fairness(&mut self, graph: &Graph) -> Vec<Fairness> {
        let count = [0, 0, 1, 1, 2, 3][self.below(6)];
        let constraint = |_| {
            if self.one_in(2) {
                Fairness::Justice(self.recurrent(graph))
            } else {
                Fairness::Compassion(self.recurrent(graph), self.recurrent(graph))
            }
        };
        (0..count).map(constraint).collect()
    }

    pub(crate) fn structure(&mut self, nodes: usize) -> Structure {
        let graph = self.graph(nodes);
        let atoms = (0..ATOMS).map(|_| self.bits(graph.node_count(), 2));
        let atoms = atoms.collect();
        let fairness = self.fairness(&graph);
        Structure {
            graph,
            atoms,
            fairness,
        }
    }

    pub(crate) fn ltl(&mut self, depth: usize) -> Ltl {
        if depth == 0 || self.one_in(8) {
            return match self.below(12) {
                0 => Ltl::True,
                1 => Ltl::False,
                _ => Ltl::Atom(self.below(ATOMS)),
            };
        }
        let depth = depth - 1;
        let unary = [
            Ltl::negation,
            Ltl::next,
            Ltl::finally,
            Ltl::globally,
            Ltl::yesterday,
            Ltl::weak_yesterday,
            Ltl::once,
            Ltl::historically,
        ];
        let binary = [
            Ltl::implies,
            Ltl::iff,
            Ltl::until,
            Ltl::release,
            Ltl::weak_until,
            Ltl::since,
            Ltl::triggered,
        ];
        match self.below(20) {
            0..9 => unary[self.below(unary.len())](self.ltl(depth)),
            9..16 => binary[self.below(binary.len())](self.ltl(depth), self.ltl(depth)),
            16..18 => Ltl::And(vec![self.ltl(depth), self.ltl(depth)]),
            _ => Ltl::Or(vec![self.ltl(depth), self.ltl(depth)]),
        }
    }

    pub(crate) fn ctl(&mut self, depth: usize) -> Ctl {
        if depth == 0 || self.one_in(8) {
            return match self.below(12) {
                0 => Ctl::True,
                1 => Ctl::False,
                _ => Ctl::Atom(self.below(ATOMS)),
            };
        }
        let depth = depth - 1;
        let unary = [Ctl::negation, Ctl::ef, Ctl::af, Ctl::eg, Ctl::ag];
        let binary = [Ctl::implies, Ctl::iff, Ctl::eu, Ctl::au, Ctl::ew, Ctl::aw];
        match self.below(20) {
            0..7 => unary[self.below(unary.len())](self.ctl(depth)),
            7..10 if self.one_in(2) => Ctl::ex(self.below(4) as u32, self.ctl(depth)),
            7..10 => Ctl::ax(self.below(4) as u32, self.ctl(depth)),
            10..16 => binary[self.below(binary.len())](self.ctl(depth), self.ctl(depth)),
            16..18 => Ctl::And(vec![self.ctl(depth), self.ctl(depth)]),
            _ => Ctl::Or(vec![self.ctl(depth), self.ctl(depth)]),
        }
    }
}
