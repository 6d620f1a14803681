//! Interface definitions of ROS: messages, services and actions.
//!
//! A [`Catalogue`] has the definitions of a distribution, those that this crate includes and those of folders. For each
//! message it gives the [`Schema`](asmotion_datum::Schema), with which data are encoded, and what a peer compares before it
//! exchanges them: the MD5 sum of ROS 1, and the type hash of ROS 2.
//!
//! ```
//! use asmotion_ros_interface::{Catalogue, Distribution};
//!
//! let noetic = Catalogue::included(Distribution::Ros1);
//! let twist = "geometry_msgs/Twist".parse()?;
//! assert_eq!(noetic.md5(&twist)?.to_string(), "9f195f881246fdfa2798d1d3eebca84a");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod catalogue;
mod definition;
mod distribution;
mod error;
mod folder;
mod included;
mod md5;
mod name;
mod parse;
mod schema;
mod type_description;
mod type_hash;

pub use catalogue::Catalogue;
pub use definition::{Constant, Count, Element, Field, FieldType, Interface, Primitive, Structure};
pub use distribution::Distribution;
pub use error::{DefinitionError, DefinitionProblem, FolderError};
pub use folder::files_in;
pub use md5::Md5Sum;
pub use name::{InterfaceKind, InterfaceName, NameError};
pub use schema::common;
pub use type_hash::TypeHash;
