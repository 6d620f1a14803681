//! `#[derive(Table)]`: declares a struct or an enum as a table of the composite dialect.
//!
//! The struct mirrors the file: `At<T>` for a value with its span, `Option` for an optional key,
//! `Vec` for a key that may occur several times. The derive generates the reader, the rows of the
//! schema and of the reference page, and, with `resolved = Name`, the same table without spans and
//! with its defaults filled in, together with its writer. With `into = path` it fills an existing
//! type in, whose fields and variants have the same names and, up to `From`, the resolved types.

mod common;
mod key;
mod of_enum;
mod of_struct;
mod options;
mod resolved;

use proc_macro2::TokenStream;
use syn::{Data, DeriveInput, Error, Result};

use of_enum::of_enum;
use of_struct::of_struct;
use options::TableOptions;

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let options = TableOptions::of(input)?;
    match &input.data {
        Data::Struct(data) => of_struct(input, data, &options),
        Data::Enum(data) => of_enum(input, data, &options),
        Data::Union(_) => Err(Error::new_spanned(input, "a union is no table")),
    }
}
