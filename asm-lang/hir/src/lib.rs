//! Name resolution and type checking: turns the trees of a specification into a [`Model`].
//!
//! [`load`] reads a file and all its imports; [`analyse`] turns the trees into a [`Model`], in
//! which every name is an id and overloads are resolved. Both continue after an error and report
//! all of them; a model is built only from files without errors.

mod added;
mod addition;
mod analyse;
mod apply;
mod codes;
mod collection;
mod compatibility;
mod declare;
mod exits;
mod hidden;
mod id;
mod import;
mod load;
mod lost;
mod model;
mod notation;
mod options;
mod resolver;
mod respelling;
mod rule;
mod scope;
mod suggest;
mod term;
mod types;

pub use addition::{AddedRule, AddedTerm, Assignment};
pub use analyse::{analyse, analyse_with, unverified_properties};
pub use codes::{CODES, NO_SUCH_INIT};
pub use load::{BrokenImport, LoadedFiles, SourceUnit, load};
pub use model::*;
pub use notation::temporal_notation;
pub use options::ReadOptions;
pub use types::{Type, TypeId, TypeTable};
