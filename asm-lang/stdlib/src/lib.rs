//! The standard libraries: signatures in `.asm`, bodies in Rust; a test keeps them consistent.
//!
//! [`library`] returns the text of a library, for resolving an `import`. [`builtin`] returns the
//! body of a library function, for lowering a call. The functions themselves are in one module for
//! each topic, with Rust types, so that compiled code can call them without the table:
//!
//! ```
//! assert_eq!(asmotion_stdlib::integer::idiv(-7, 2), Ok(-3));
//! assert!(asmotion_stdlib::integer::idiv(1, 0).is_err());
//! ```

mod argument;
mod builtin;
mod collection;
mod fault;
mod library;
mod sum;
mod table;
#[cfg(test)]
mod testing;

pub mod any;
pub mod bag;
pub mod boolean;
pub mod character;
pub mod complex;
pub mod integer;
pub mod map;
mod message;
pub mod natural;
pub mod real;
pub mod sequence;
pub mod set;
pub mod text;
pub mod time;
mod to_string;
pub mod tuple;

pub use builtin::{Builtin, BuiltinBody, BuiltinContext, RESERVED, TEMPORAL};
pub use fault::{BuiltinFault, LIMIT};
pub use library::{StandardLibrary, libraries, library, library_declaring, library_spelt_like};
pub use message::{MessageAction, MessageQuery, operation};
pub use table::{builtin, builtins, compatible};
