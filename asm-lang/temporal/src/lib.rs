//! Temporal logic over finite graphs: CTL and LTL with past operators, under fairness, with counterexamples.
//!
//! A [`Graph`] is a Kripke structure whose edges carry labels. Atoms are sets of nodes ([`Bits`]). [`check_ctl`] and [`check_ltl`]
//! judge a formula in all initial nodes; only paths that satisfy every [`Fairness`] constraint count. A violated formula comes with a
//! [`Lasso`]: a path from an initial node, and a cycle where the violation takes an infinite path. A path that satisfies a formula is
//! found by [`witness_ctl`], or as the violation of a negated LTL formula.
//!
//! ```
//! use asmotion_temporal::{Bits, GraphBuilder, Ltl, check_ltl};
//!
//! // 0 → 1 → 2, and 2 stays
//! let mut builder = GraphBuilder::new();
//! builder.edge(1, 7);
//! builder.end_node();
//! builder.edge(2, 8);
//! builder.end_node();
//! builder.end_node();
//! let graph = builder.finish(vec![0])?;
//! let at_one = Bits::from_ones(3, [1]);
//!
//! let verdict = check_ltl(&graph, &[at_one], &Ltl::globally(Ltl::finally(Ltl::Atom(0))), &[])?;
//! let lasso = verdict.violation.expect("node 2 is never left");
//! assert_eq!((lasso.stem.len(), lasso.cycle.len()), (2, 1));
//! # Ok::<(), asmotion_temporal::TemporalError>(())
//! ```

mod automaton;
mod bits;
mod closure;
mod constraint;
mod ctl;
mod ctl_terms;
mod cycle;
mod error;
mod fair;
mod fairness;
mod fixpoints;
mod formula;
mod graph;
mod lasso;
mod letters;
mod ltl;
mod monitor;
mod past;
mod product;
mod response;
mod rows;
mod safety;
mod satisfaction;
mod scc;
mod search;
mod streett;
mod vacuity;
mod validate;
mod verdict;

pub use bits::Bits;
pub use ctl::Ctl;
pub use error::TemporalError;
pub use fairness::{Fairness, Recurrent};
pub use graph::{Graph, GraphBuilder};
pub use lasso::{Lasso, PathStep};
pub use ltl::Ltl;
pub use monitor::{Monitor, MonitorState, MonitorVerdict};
pub use past::Letter;
pub use product::{check_ltl, check_ltl_while};
pub use response::{ResponseMonitor, ResponseState};
pub use safety::NotMonitorable;
pub use satisfaction::{check_ctl, check_ctl_while, witness_ctl};
pub use vacuity::{
    AtomOccurrence, Vacuity, check_ltl_with_vacuity, check_ltl_with_vacuity_while, vacuity_ctl,
    vacuity_ctl_by, vacuity_ctl_while, vacuity_ltl, vacuity_ltl_by,
};
pub use verdict::{FairPaths, TemporalVerdict};
