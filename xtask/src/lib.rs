//! Measures the source of this repository and does its chores; `cargo xtask --help` lists them.
//!
//! The measurements are a library so that `tests/house.rs` holds the same figures that
//! `cargo xtask house` prints. They read source text only, so they also measure revisions that do
//! not build here.

pub mod arms;
pub mod build_cost;
pub mod checkout;
pub mod debts;
pub mod doc_blocks;
pub mod functions;
pub mod graph;
pub mod history;
pub mod licences;
pub mod lines;
pub mod modules;
pub mod new_component;
pub mod printing;
pub mod report;
pub mod table;
pub mod test_code;
pub mod type_names;
