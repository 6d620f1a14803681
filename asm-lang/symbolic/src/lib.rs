//! Sets of states as binary decision diagrams (BDDs): reachability and temporal logic for programs whose locations have finitely many
//! values.

mod bdd;
mod branching;
mod encoding;
mod error;
mod evaluator;
mod fault;
mod fixpoints;
mod guarded;
mod linear;
mod model;
mod moves;
mod operations;
mod query;
mod range;
mod reach;
mod rule;
mod step;
mod term;
mod truth;
mod witness;

pub use error::SymbolicError;
pub use fault::FaultClass;
pub use model::{ModelSource, NodeSet, SymbolicModel};
pub use query::{ReachedCounts, SymbolicFairness, SymbolicFault, SymbolicFormula, SymbolicVerdict};
pub use reach::{Reached, SearchLimit, SearchProgress};
pub use witness::SymbolicInput;
