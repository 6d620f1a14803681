//! Composite files: checked plan, then running system.

mod at;
pub mod binding;
pub mod catalogue;
mod check;
mod choice;
mod codes;
mod context;
mod environment;
mod family;
mod finding;
pub mod model;
mod nearest;
mod opened;
pub mod plan;
pub mod presence;
pub mod read;
mod scope;
pub mod signature;
mod specification;
pub mod start;
pub mod tree;
mod types;
mod value;

pub use at::At;
pub use catalogue::{Catalogue, Constructor, Tables};
pub use codes::CODES;
pub use component::declaration;
pub use context::Context;
pub use environment::{EmptyEnvironment, Environment};
pub use opened::{Opened, open, summary};
pub use plan::Plan;
pub use signature::{NoSpecifications, Signature, Specifications};
pub use specification::AsmFiles;
pub use start::{Part, Standard, StartError, Workshop, start, start_part};
pub use types::open_types;
pub use value::{REDACTED, Value};
