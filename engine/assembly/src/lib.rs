//! Composite files: checked plan, then running system.

mod at;
pub mod binding;
pub mod catalogue;
mod choice;
mod environment;
mod finding;
pub mod model;
mod nearest;
pub mod read;
pub mod signature;
pub mod tree;
mod types;
mod value;

pub use at::At;
pub use catalogue::{Catalogue, EmptyCatalogue};
pub use environment::{EmptyEnvironment, Environment};
pub use signature::{NoSpecifications, Signature, Specifications};
pub use value::{REDACTED, Value};
