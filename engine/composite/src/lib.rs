//! Composite files: parsing and checking.
//!
//! A composite is read together with all files it refers to, keeping the source location of every value, and checked in
//! every profile. Planning and starting are provided by other crates.

pub mod address;
pub mod at;
pub mod catalogue;
pub mod check;
mod codes;
mod context;
mod discovery;
pub mod end;
mod environment;
pub mod family;
pub mod finding;
mod first_step;
mod instances;
pub mod map;
pub mod mission;
mod misspelt;
pub mod model;
mod named;
mod named_list;
mod nearest;
mod pattern;
pub mod programs;
pub mod property;
pub mod property_file;
mod provider;
mod range;
pub mod read;
pub mod schema;
pub mod scope;
pub mod signature;
mod specification;
pub mod table;
mod template;
pub mod tree;
pub mod types;
pub mod value;
mod wording;

pub use at::At;
pub use catalogue::{
    Catalogue, ComponentFactory, Constructor, RosFolderProblem, RosFolders, RosMessage,
    RosMessages, RosMessagesOf, RosOperation, RosOperations, Tables,
};
pub use codes::CODES;
pub use context::Context;
pub use environment::{EmptyEnvironment, VariableSource};
pub use named_list::{HasName, NamedList};
pub use programs::{NoPrograms, ProgramAnswer, Programs, split_robot_component};
pub use signature::{NoSpecifications, Signature, Specifications};
pub use specification::AsmFiles;
pub use types::open_types;
pub use value::{REDACTED, SettingValue};
