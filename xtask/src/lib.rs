//! Measures the source code of this repository and automates its maintenance; see `cargo xtask
//! --help`.
//!
//! The measurements are a library, so that `tests/house.rs` checks the same figures that `cargo
//! xtask house` prints. They only read source text and therefore also work for revisions that
//! cannot be built here.

pub mod arms;
pub mod build_cost;
pub mod checkout;
pub mod doc_blocks;
pub mod functions;
pub mod graph;
pub mod history;
pub mod licences;
pub mod lines;
pub mod module_laws;
pub mod modules;
pub mod new_component;
pub mod printing;
pub mod report;
pub mod table;
pub mod test_code;
pub mod type_names;
