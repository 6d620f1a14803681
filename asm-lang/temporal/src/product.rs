//! Checks LTL formulas: the product of a graph and an automaton, and its fair components.

use crate::automaton::Automaton;
use crate::bits::Bits;
use crate::constraint::Constraint;
use crate::cycle::LassoSearch;
use crate::error::TemporalError;
use crate::fair::FairNodes;
use crate::fairness::{Fairness, Recurrent};
use crate::graph::Graph;
use crate::lasso::Lasso;
use crate::letters::Letters;
use crate::ltl::Ltl;
use crate::rows::SparseRows;
use crate::search::ShortestPaths;
use crate::streett::{FairComponents, fair_components};
use crate::validate::validate;
use crate::verdict::TemporalVerdict;
use std::ops::Range;

/// Checks whether an LTL formula holds on all fair paths from initial nodes.
///
/// The counterexample is a finite path if every fair continuation of it violates the formula, and otherwise a lasso: the shortest path
/// to a fair cycle of the product with the automaton of the negated formula, and the shortest such cycle there.
///
/// # Errors
/// A set has the wrong size, an atom does not exist, the automaton of the formula is too large, or the product has 2^32 - 1 nodes or
/// edges.
pub fn check_ltl(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ltl,
    fairness: &[Fairness],
) -> Result<TemporalVerdict, TemporalError> {
    check_ltl_while(graph, atoms, formula, fairness, &|_| true)
}

/// Checks an LTL formula like [`check_ltl`], as long as `goes_on` returns true. It is asked at least every 1024 nodes of the product,
/// with the bytes of memory that the product takes so far.
///
/// # Errors
/// The same as of [`check_ltl`], and [`TemporalError::Interrupted`].
pub fn check_ltl_while(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ltl,
    fairness: &[Fairness],
    goes_on: &dyn Fn(usize) -> bool,
) -> Result<TemporalVerdict, TemporalError> {
    FairGraph::new(graph, atoms, fairness)?.verdict(formula, goes_on)
}

/// A graph with the nodes from which fair paths start, for several formulas.
pub(crate) struct FairGraph<'a> {
    graph: &'a Graph,
    atoms: &'a [Bits],
    fairness: &'a [Fairness],
    fair: FairNodes,
}

impl<'a> FairGraph<'a> {
    pub(crate) fn new(
        graph: &'a Graph,
        atoms: &'a [Bits],
        fairness: &'a [Fairness],
    ) -> Result<Self, TemporalError> {
        validate(graph, atoms, fairness)?;
        Ok(Self {
            graph,
            atoms,
            fairness,
            fair: FairNodes::of(graph, fairness),
        })
    }

    /// Returns the verdict on a formula; see [`check_ltl_while`].
    pub(crate) fn verdict(
        &self,
        formula: &Ltl,
        goes_on: &dyn Fn(usize) -> bool,
    ) -> Result<TemporalVerdict, TemporalError> {
        let product = self.product(formula, goes_on)?;
        let violation = match product.decided {
            Some(node) => Some(product.path_to(node)),
            None => product.lasso(self.fairness),
        };
        Ok(TemporalVerdict {
            violation,
            fair: self.fair.paths(self.graph),
        })
    }

    /// Returns whether [`check_ltl`] finds no violation.
    pub(crate) fn holds(
        &self,
        formula: &Ltl,
        goes_on: &dyn Fn(usize) -> bool,
    ) -> Result<bool, TemporalError> {
        let product = self.product(formula, goes_on)?;
        if product.decided.is_some() {
            return Ok(false);
        }
        let untils = product.untils();
        let components = product.components(&product.constraints(&untils, self.fairness));
        Ok(components.members.is_empty())
    }

    /// Returns the product with the automaton of the negated formula.
    fn product(
        &self,
        formula: &Ltl,
        goes_on: &dyn Fn(usize) -> bool,
    ) -> Result<Product, TemporalError> {
        let mut automaton = Automaton::of_negation(formula, self.atoms.len())?;
        Product::new(self.graph, self.atoms, &mut automaton, &self.fair, goes_on)
    }
}

/// The part of the product that is reachable along fair nodes.
struct Product {
    rows: SparseRows,
    initial: Vec<u32>,
    /// The node of the graph for each node.
    nodes: Vec<u32>,
    /// The edge of the graph for each edge.
    edges: Vec<u32>,
    /// For each obligation, the edges that postpone it.
    postponing: Vec<Bits>,
    /// The nodes whose state of the automaton can recur. Only they can be on fair cycles.
    recurrent: Bits,
    /// A node at which the formula is violated, whatever fair path follows.
    decided: Option<u32>,
}

/// A product that is being built. Its nodes are numbered in breadth-first order.
struct ProductBuilder<'a> {
    graph: &'a Graph,
    atoms: &'a [Bits],
    automaton: &'a mut Automaton,
    fair: &'a FairNodes,
    letters: Letters,
    pairs: Pairs,
    /// For each obligation, the bits of the edges that postpone it, up to the last such edge.
    postponing: Vec<Vec<u64>>,
    product: Product,
}

/// Number of nodes whose pairs with one state are stored together.
const BLOCK: usize = 64;

/// Pairs of a node of the graph and a state of the automaton, in the order in which they were found.
struct Pairs {
    /// For each state, and each block of nodes of which one has been found, the numbers of the pairs; `u32::MAX` for none.
    ids: Vec<Vec<Option<Box<[u32; BLOCK]>>>>,
    /// Number of blocks of nodes.
    blocks: usize,
    /// Number of blocks that are stored.
    stored: usize,
    nodes: Vec<u32>,
    states: Vec<u32>,
}

impl Pairs {
    fn new(node_count: usize) -> Self {
        Self {
            ids: Vec::new(),
            blocks: node_count.div_ceil(BLOCK),
            stored: 0,
            nodes: Vec::new(),
            states: Vec::new(),
        }
    }

    fn bytes(&self) -> usize {
        self.stored * 4 * BLOCK + self.ids.len() * self.blocks * size_of::<usize>()
    }

    fn id(&mut self, node: u32, state: u32) -> u32 {
        self.of_state(state).id(node)
    }

    fn of_state(&mut self, state: u32) -> PairsOfState<'_> {
        while self.ids.len() <= state as usize {
            let blocks = std::iter::repeat_with(|| None).take(self.blocks);
            self.ids.push(blocks.collect());
        }
        PairsOfState {
            state,
            ids: &mut self.ids[state as usize],
            stored: &mut self.stored,
            nodes: &mut self.nodes,
            states: &mut self.states,
        }
    }
}

/// The pairs with one state.
struct PairsOfState<'a> {
    state: u32,
    ids: &'a mut [Option<Box<[u32; BLOCK]>>],
    stored: &'a mut usize,
    nodes: &'a mut Vec<u32>,
    states: &'a mut Vec<u32>,
}

impl PairsOfState<'_> {
    #[inline]
    fn id(&mut self, node: u32) -> u32 {
        let block = self.ids[node as usize / BLOCK].get_or_insert_with(|| {
            *self.stored += 1;
            Box::new([u32::MAX; BLOCK])
        });
        let id = &mut block[node as usize % BLOCK];
        if *id == u32::MAX {
            *id = self.nodes.len() as u32;
            self.nodes.push(node);
            self.states.push(self.state);
        }
        *id
    }
}

impl Product {
    fn new(
        graph: &Graph,
        atoms: &[Bits],
        automaton: &mut Automaton,
        fair: &FairNodes,
        goes_on: &dyn Fn(usize) -> bool,
    ) -> Result<Self, TemporalError> {
        let used: Vec<&Bits> = automaton
            .atoms()
            .iter()
            .filter_map(|atom| atoms.get(*atom))
            .collect();
        let builder = ProductBuilder {
            graph,
            atoms,
            fair,
            letters: Letters::new(graph.node_count(), &used),
            postponing: vec![Vec::new(); automaton.until_count()],
            automaton,
            pairs: Pairs::new(graph.node_count()),
            product: Self {
                rows: SparseRows::new(),
                initial: Vec::new(),
                nodes: Vec::new(),
                edges: Vec::new(),
                postponing: Vec::new(),
                recurrent: Bits::default(),
                decided: None,
            },
        };
        builder.build(goes_on)
    }

    /// Returns the shortest path to a node.
    fn path_to(&self, node: u32) -> Lasso {
        let goal = Bits::from_ones(self.nodes.len(), [node as usize]);
        let (paths, arrivals) =
            ShortestPaths::to_nearest(&self.rows, &self.initial, &goal, |_| true);
        let found = arrivals.first().map(|it| paths.to_arrival(*it));
        let (start, stem) = found.unwrap_or((node, Vec::new()));
        let lasso = Lasso {
            start,
            stem,
            cycle: Vec::new(),
        };
        lasso.projected((&self.nodes, &self.edges))
    }

    /// Returns, for each obligation, that it is not postponed for ever.
    fn untils(&self) -> Vec<Fairness> {
        let postponing = self.postponing.iter().cloned();
        let kept = postponing.map(|it| Fairness::Justice(Recurrent::edges(it.complemented())));
        kept.collect()
    }

    /// Returns the constraints on the product: those of the automaton, and fairness.
    fn constraints<'a>(
        &'a self,
        untils: &'a [Fairness],
        fairness: &'a [Fairness],
    ) -> Vec<Constraint<'a>> {
        let mut constraints = Constraint::all(untils);
        constraints.extend(fairness.iter().map(|fairness| Constraint {
            fairness,
            origins: Some((&self.nodes, &self.edges)),
        }));
        constraints
    }

    fn components(&self, constraints: &[Constraint<'_>]) -> FairComponents {
        fair_components(&self.rows, &self.recurrent, constraints)
    }

    /// Returns a shortest lasso that satisfies fairness and postpones nothing for ever.
    fn lasso(&self, fairness: &[Fairness]) -> Option<Lasso> {
        let untils = self.untils();
        let constraints = self.constraints(&untils, fairness);
        LassoSearch {
            rows: &self.rows,
            from: &self.initial,
            within: &Bits::full(self.nodes.len()),
            origins: Some((&self.nodes, &self.edges)),
            components: &self.components(&constraints),
            constraints: &constraints,
        }
        .shortest()
    }
}

impl ProductBuilder<'_> {
    fn build(mut self, goes_on: &dyn Fn(usize) -> bool) -> Result<Product, TemporalError> {
        for node in self.fair.initial(self.graph) {
            let id = self.pairs.id(node, Automaton::START);
            self.product.initial.push(id);
        }
        let mut at = 0;
        while at < self.pairs.nodes.len() && self.product.decided.is_none() {
            if at.is_multiple_of(1024) && !goes_on(self.bytes()) {
                return Err(TemporalError::Interrupted);
            }
            self.expand(at as u32)?;
            at += 1;
        }
        let edge_count = self.product.rows.edge_count();
        let postponing = self.postponing.into_iter();
        let postponing = postponing.map(|words| Bits::from_words(edge_count, words));
        self.product.postponing = postponing.collect();
        let recurrent = self.automaton.recurrent_states();
        let states = &self.pairs.states;
        let is_recurrent = |node: usize| recurrent.contains(states[node] as usize);
        self.product.recurrent = Bits::from_fn(states.len(), is_recurrent);
        self.product.nodes = self.pairs.nodes;
        Ok(self.product)
    }

    /// Bytes of nodes and edges, of what a search for components adds for each node, and of the numbers of pairs.
    fn bytes(&self) -> usize {
        let nodes = self.pairs.nodes.len() * 32;
        let edges = self.product.rows.edge_count() * 8;
        nodes + edges + self.pairs.bytes()
    }

    /// Adds the edges of a node.
    fn expand(&mut self, id: u32) -> Result<(), TemporalError> {
        let (node, state) = (
            self.pairs.nodes[id as usize],
            self.pairs.states[id as usize],
        );
        let holds = |atom: usize| {
            let atom = self.atoms.get(atom);
            atom.is_some_and(|nodes| nodes.contains(node as usize))
        };
        let letter = self.letters.of(node);
        let product = &mut self.product;
        for step in self.automaton.steps(state, letter, &holds)? {
            if step.is_final {
                product.decided = Some(id);
            }
            let begin = product.rows.edge_count();
            let mut pairs = self.pairs.of_state(step.target);
            let edges = self.graph.edges(node).zip(self.graph.successors(node));
            for (edge, target) in edges.filter(|(_, target)| self.fair.contains(**target)) {
                product.rows.push(pairs.id(*target));
                product.edges.push(edge as u32);
            }
            for until in &step.postponed {
                mark(
                    &mut self.postponing[*until],
                    begin..product.rows.edge_count(),
                );
            }
        }
        product.rows.end_node();
        self.is_small_enough()
    }

    fn is_small_enough(&self) -> Result<(), TemporalError> {
        // the next node adds at most one edge for each pair of an alternative and an edge of the graph
        let limit = u32::MAX as usize - (1 << 26);
        if self.pairs.nodes.len() >= limit || self.product.rows.edge_count() >= limit {
            return Err(TemporalError::TooLarge("edges of the product"));
        }
        Ok(())
    }
}

/// Sets bits.
fn mark(words: &mut Vec<u64>, bits: Range<usize>) {
    words.resize(bits.end.div_ceil(64), 0);
    for bit in bits {
        words[bit / 64] |= 1 << (bit % 64);
    }
}
