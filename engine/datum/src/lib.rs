//! Self-describing data, exchanged between components.
//!
//! A [`Message`] is a Rust struct with a ROS name and a [`Schema`]; the [`message!`] macro declares it. A [`Datum`] is
//! the same data without the struct, for code that learns a type only at run time: the coordinator, the recorder, the
//! monitor. Codecs convert a datum to bytes and back.
//!
//! ```
//! asmotion_datum::message! {
//!     /// A planar point.
//!     #[derive(Copy)]
//!     pub struct Point = "example/Point" {
//!         /// metres
//!         pub x: f64,
//!         /// metres
//!         pub y: f64,
//!     }
//! }
//!
//! let point = Point { x: 1.0, y: 2.0 };
//! let datum = asmotion_datum::Datum::of(&point)?;
//! assert_eq!(datum.get("x").as_deref(), Some(&asmotion_datum::Datum::Float(1.0)));
//! assert_eq!(datum.to::<Point>()?, point);
//! # Ok::<(), asmotion_datum::DatumError>(())
//! ```

// the macro refers to this crate as `datum`, and is used in its own tests
extern crate self as datum;
// the derive macro of words refers to this crate as `asmotion_datum`
extern crate self as asmotion_datum;

mod codec;

mod de;
mod described;
mod error;
mod fit;
pub mod json_schema;
mod message;
mod numbers;
mod sample;
mod schema;
mod ser;
mod shared_name;
mod value;
mod word;

pub use codec::{Codec, cbor, cdr, json, ros1};
pub use described::{Described, field};
pub use error::{DatumError, DatumProblem};
pub use message::Message;
pub use numbers::Numbers;
pub use sample::Sample;
pub use schema::{OutlineKey, Schema, SchemaDifference, Shape};
pub use shared_name::shared_name;
pub use value::{Datum, FieldName};
pub use word::Word;

/// The serde that [`message!`] derives with, so that its users do not depend on serde themselves.
pub use serde;
