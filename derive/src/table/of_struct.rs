//! Tables from structs: each field is a key.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{DataStruct, DeriveInput, Error, ExprRange, Fields, RangeLimits, Result};

use super::common::common;
use super::key::KeyDeclaration;
use super::options::TableOptions;
use super::resolved;

pub(super) fn of_struct(
    input: &DeriveInput,
    data: &DataStruct,
    options: &TableOptions,
) -> Result<TokenStream> {
    let Fields::Named(fields) = &data.fields else {
        return Err(Error::new_spanned(input, "a table has named fields"));
    };
    let rows = fields
        .named
        .iter()
        .map(KeyDeclaration::of_field)
        .collect::<Result<Vec<_>>>()?;
    for row in &rows {
        if let Some(ExprRange {
            limits: RangeLimits::HalfOpen(_),
            ..
        }) = &row.range
        {
            return Err(Error::new(
                row.ident.span(),
                "a range includes its end: `1..=9`",
            ));
        }
    }
    let name = &input.ident;
    let keys: Vec<&KeyDeclaration> = rows
        .iter()
        .filter(|it| !it.is_place() && !it.flatten)
        .collect();
    let index = |row: &KeyDeclaration| {
        let at = keys
            .iter()
            .position(|it| it.ident == row.ident)
            .unwrap_or_default();
        quote!(&Self::KEYS[#at])
    };
    let consts = keys.iter().map(|row| row.key());
    let outline = rows.iter().filter(|it| !it.is_place()).map(|row| {
        if row.flatten {
            let inner = row.inner();
            quote!(outline.append(<#inner as crate::table::Table>::outline());)
        } else {
            let key = index(row);
            quote!(outline.add(#key);)
        }
    });
    let reads = rows.iter().map(|row| {
        let (variable, read) = (row.variable(), row.read(&index(row)));
        quote!(let #variable = #read;)
    });
    let made = rows.iter().map(|row| {
        let (ident, variable) = (&row.ident, row.variable());
        if row.is_unwrapped() {
            quote!(#ident: #variable?)
        } else {
            quote!(#ident: #variable)
        }
    });
    let after = options.after.iter();
    let common = common(input, options, rows.iter().find_map(|it| it.entry.as_ref()));
    let resolved = resolved::of_struct(input, options, &rows, &index);
    Ok(quote! {
        impl #name {
            const KEYS: &'static [crate::table::Key] = &[#(#consts),*];
        }

        impl crate::table::Table for #name {
            fn outline() -> crate::table::Outline {
                let mut outline = Self::blank();
                #(#outline)*
                outline
            }

            fn read_keys(keys: &mut crate::table::derived::Keys<'_, '_, '_>, name: &crate::table::derived::At<String>) -> Option<Self> {
                #(#reads)*
                #[allow(unused_mut, reason = "only some tables are looked at again")]
                let mut table = Self { #(#made),* };
                #(#after(&mut table, keys);)*
                Some(table)
            }
        }

        #common
        #resolved
    })
}
