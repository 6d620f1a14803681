//! Errors of graphs and checks.

/// A graph, or a check, that is not well-formed or too large.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TemporalError {
    /// An edge or an initial node refers to a node that does not exist.
    #[error("node {node} does not exist: the graph has {count} nodes")]
    UnknownNode {
        /// The number of the node.
        node: u32,
        /// The number of nodes.
        count: usize,
    },
    /// Edges were added after the last node ended.
    #[error("the last node has edges, but was not ended")]
    UnfinishedNode,
    /// An edge has the label of self-loops that complete a graph.
    #[error("an edge has the reserved label {}", u32::MAX)]
    ReservedLabel,
    /// There is no initial node, so that every formula would hold.
    #[error("the graph has no initial node")]
    NoInitialNode,
    /// Nodes or edges do not fit 32 bits.
    #[error("{0} do not fit 32 bits")]
    TooLarge(&'static str),
    /// The formula uses an atom without a set of nodes.
    #[error("atom {atom} does not exist: there are {count} atoms")]
    UnknownAtom {
        /// The index of the atom.
        atom: usize,
        /// The number of atoms.
        count: usize,
    },
    /// A set of nodes or edges has the wrong size.
    #[error("a set of {what} has the size {found} instead of {expected}")]
    SetSize {
        /// `nodes` or `edges`.
        what: &'static str,
        /// The number of nodes or edges of the graph.
        expected: usize,
        /// The size of the set.
        found: usize,
    },
    /// `EX` or `AX` over too many steps.
    #[error("{steps} steps are more than {limit}")]
    TooManySteps {
        /// The number of steps in the formula.
        steps: u32,
        /// The largest supported number.
        limit: u32,
    },
    /// The caller ended the check before it had a result.
    #[error("the check was interrupted")]
    Interrupted,
    /// The automaton of an LTL formula is too large.
    #[error(
        "the formula is too large: one state of its automaton has more than {limit} successors"
    )]
    FormulaTooLarge {
        /// The largest supported number.
        limit: usize,
    },
}
