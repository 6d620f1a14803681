//! The parts of a table that do not depend on its fields.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{DeriveInput, Ident};

use super::options::TableOptions;
use crate::word::doc;

/// Generates the items that do not depend on the fields.
pub(super) fn common(
    input: &DeriveInput,
    options: &TableOptions,
    entry: Option<&Ident>,
) -> TokenStream {
    let (name, doc) = (&input.ident, doc(&input.attrs));
    let TableOptions {
        of, example, short, ..
    } = options;
    let of_here = match &options.elsewhere {
        Some((key, of_there)) => quote!(if spec.name == #key { #of_there } else { #of }),
        None => quote!(#of),
    };
    let many = match entry {
        Some(_) => quote!(crate::table::Many::Names),
        None => quote!(crate::table::Many::Tables),
    };
    let entry_name = match entry {
        Some(check) => quote!(crate::table::derived::name::#check(reader, key)?),
        None => quote!(key.clone()),
    };
    let place = entry.map(|_| quote!(keys.span = name.span;));
    let short_read = short.as_ref().map(|short| {
        quote! {
            if !matches!(node.value, crate::table::derived::Branch::Table(_)) {
                let table = crate::table::derived::Tree::short(#short, node);
                let mut keys = reader.keys(&table, #of, node.span);
                return <Self as crate::table::Table>::read_keys(&mut keys, &name);
            }
        }
    });
    let short_schema = short.as_ref().map(|short| {
        quote!(let schema = crate::table::or_short(schema, <Self as crate::table::Table>::outline(), #short);)
    });
    quote! {
        impl #name {
            fn blank() -> crate::table::Outline {
                crate::table::Outline::new(#of, #doc)
            }
        }

        impl crate::table::Value for #name {
            const MANY: crate::table::Many = #many;

            fn schema(key: &crate::table::Key) -> serde_json::Value {
                let schema = <Self as crate::table::Table>::outline().within(key.name).schema();
                #short_schema
                schema
            }

            fn table(key: &crate::table::Key) -> Option<crate::table::Outline> {
                Some(<Self as crate::table::Table>::outline().within(key.name))
            }

            fn read(
                reader: &mut crate::table::derived::Reader<'_>,
                key: &crate::table::derived::At<String>,
                spec: &crate::table::Key,
                node: &crate::table::derived::Node,
            ) -> Option<Self> {
                let name = #entry_name;
                #short_read
                let mut keys = reader.keys_of(node, key, #of_here, #example)?;
                keys.within = spec.name;
                #place
                <Self as crate::table::Table>::read_keys(&mut keys, &name)
            }
        }
    }
}
