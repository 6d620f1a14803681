//! Generates the resolved table, which has no source spans.

use proc_macro2::TokenStream;
use quote::quote;
use syn::DeriveInput;

use super::key::{FieldShape, KeyDeclaration};
use super::options::TableOptions;
use crate::word::doc;

/// Generates the table without spans.
pub(super) fn resolved(
    input: &DeriveInput,
    options: &TableOptions,
    rows: &[KeyDeclaration],
    index: &dyn Fn(&KeyDeclaration) -> TokenStream,
) -> TokenStream {
    let Some(twin) = &options.resolved else {
        return quote!();
    };
    let name = &input.ident;
    let doc = format!(
        "{} As it holds in a plan: without places, substituted, with defaults.",
        doc(&input.attrs)
    );
    let kept: Vec<&KeyDeclaration> = rows
        .iter()
        .filter(|it| !it.written && it.ident != "span" && !it.is("FileId"))
        .collect();
    let fields = kept.iter().map(|row| {
        let (ident, kind, doc) = (&row.ident, row.resolved_kind(), &row.doc);
        quote!(#[doc = #doc] pub #ident: #kind)
    });
    let values = kept.iter().map(|row| {
        let key = match row.entry {
            Some(_) => quote!(&crate::table::Key::NAME),
            None => index(row),
        };
        let (ident, value) = (&row.ident, row.resolve(&key));
        quote!(#ident: #value)
    });
    let writes = kept
        .iter()
        .filter(|it| it.entry.is_none())
        .map(|row| row.write());
    let is_open =
        |row: &&KeyDeclaration| row.default.is_some() || !matches!(row.shape(), FieldShape::One(_));
    let default = kept.iter().all(is_open).then(|| {
        let values = kept.iter().map(|row| {
            let (ident, value) = (&row.ident, row.default_value());
            quote!(#ident: #value)
        });
        quote! {
            impl Default for #twin {
                fn default() -> Self {
                    Self { #(#values),* }
                }
            }
        }
    });
    quote! {
        #[doc = #doc]
        #[derive(Clone, Debug, PartialEq)]
        pub struct #twin { #(#fields),* }

        impl crate::table::Resolve for #name {
            type Resolved = #twin;

            fn resolve(&self, _: &crate::table::Key, to: &mut crate::table::Resolver<'_>) -> Option<#twin> {
                Some(#twin { #(#values),* })
            }
        }

        #default

        impl crate::table::WrittenTable for #twin {
            fn keys(&self, within: &str) -> crate::table::Lines {
                let mut keys = crate::table::Lines::new();
                #(#writes)*
                keys
            }
        }

        impl crate::table::Written for #twin {
            fn toml(&self) -> Option<toml_edit::Value> {
                crate::table::WrittenTable::keys(self, "").inline()
            }

            fn list(items: &[Self]) -> Option<toml_edit::Value> {
                crate::table::tables_of(items)
            }
        }
    }
}
