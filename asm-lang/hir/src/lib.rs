//! The tree resolved and typed: everything by id, overloads decided.
//!
//! [`load`] reads a file and all that it imports; [`analyse`] turns the trees into a [`Model`]. Both
//! go on after an error and report all of them; a model is built only from files without errors.

mod added;
mod addition;
mod analyse;
mod apply;
mod codes;
mod collection;
mod declare;
mod id;
mod import;
mod load;
mod model;
mod options;
mod resolver;
mod rule;
mod scope;
mod suggest;
mod term;
mod types;

pub use addition::{AddedRule, AddedTerm, Assignment};
pub use analyse::{analyse, analyse_with};
pub use codes::{CODES, NO_SUCH_INIT};
pub use load::{LoadedFiles, SourceUnit, load};
pub use model::*;
pub use options::ReadOptions;
pub use types::{Type, TypeId, TypeTable};
