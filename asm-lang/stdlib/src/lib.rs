//! The standard libraries: signatures in `.asm`, bodies in Rust, held equal by a test.
//!
//! [`library`] gives the text of a library, for whoever resolves an `import`. [`builtin`] gives the
//! body of one of its functions, for whoever lowers a call. The functions themselves stand in one
//! module a topic, typed, so that compiled code can call them without the table:
//!
//! ```
//! assert_eq!(asmotion_stdlib::integer::idiv(-7, 2), Ok(-3));
//! assert!(asmotion_stdlib::integer::idiv(1, 0).is_err());
//! ```

mod argument;
mod builtin;
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
pub mod tuple;

pub use builtin::{Builtin, BuiltinBody, BuiltinContext, RESERVED, TEMPORAL};
pub use fault::{BuiltinFault, LIMIT};
pub use library::{StandardLibrary, libraries, library, library_declaring, library_spelt_like};
pub use message::{MessageAction, MessageQuery, operation};
pub use table::{builtin, builtins, compatible};
