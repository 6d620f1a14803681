//! Generates the resolved table, which has no source spans, and its writer.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{DeriveInput, Ident, Path};

use super::key::{FieldShape, KeyDeclaration};
use super::options::TableOptions;
use crate::word::doc;

/// The resolved table of a struct or an enum.
pub(super) enum Twin {
    /// A type that the derive declares.
    New(Ident),
    /// A type of another crate with the same fields or variants.
    Existing(Path),
}

impl Twin {
    fn name(&self) -> TokenStream {
        match self {
            Self::New(name) => quote!(#name),
            Self::Existing(path) => quote!(#path),
        }
    }

    fn exists(&self) -> bool {
        matches!(self, Self::Existing(_))
    }
}

/// A variant of an enum with the keys that its resolved table keeps.
pub(super) struct ResolvedVariant<'v> {
    pub ident: &'v Ident,
    pub doc: String,
    /// The variant has named fields.
    pub named: bool,
    /// Only in the table as written, not in the resolved one.
    pub written: bool,
    /// The keys, each with the expression of its description.
    pub keys: Vec<(&'v KeyDeclaration, TokenStream)>,
}

/// Generates the resolved table of a struct.
pub(super) fn of_struct(
    input: &DeriveInput,
    options: &TableOptions,
    rows: &[KeyDeclaration],
    index: &dyn Fn(&KeyDeclaration) -> TokenStream,
) -> TokenStream {
    let Some(twin) = &options.twin else {
        return quote!();
    };
    let kept: Vec<&KeyDeclaration> = rows.iter().filter(|it| it.is_resolved()).collect();
    let idents = kept.iter().map(|it| &it.ident);
    let variables = kept.iter().map(|it| it.variable());
    let open = quote!(let Self { #(#idents: #variables,)* .. } = self;);
    let values = kept.iter().map(|row| {
        let key = match (&row.entry, row.flatten) {
            (None, false) => index(row),
            _ => quote!(&crate::table::Key::NAME),
        };
        let (ident, value) = (&row.ident, row.resolve(&key, twin.exists()));
        quote!(#ident: #value)
    });
    let name = twin.name();
    let resolve = quote!(#open Some(#name { #(#values),* }));
    let entry = kept.iter().find(|it| it.entry.is_some());
    let written = kept.iter().filter(|it| it.entry.is_none());
    let (idents, variables): (Vec<_>, Vec<_>) =
        written.clone().map(|it| (&it.ident, it.variable())).unzip();
    let writes = written.map(|row| row.write());
    let write = quote!(let Self { #(#idents: #variables,)* .. } = self; #(#writes)*);
    let list = match entry {
        Some(KeyDeclaration { ident, .. }) => {
            quote!(crate::table::named(items.iter().map(|it| (&it.#ident, it))))
        }
        None => quote!(crate::table::tables_of(items)),
    };
    let declaration = declaration(input, twin, || {
        let fields = kept.iter().map(|row| {
            let (ident, kind, doc) = (&row.ident, row.resolved_kind(), &row.doc);
            quote!(#[doc = #doc] pub #ident: #kind)
        });
        let default = default(&name, &kept);
        (quote!(struct #name { #(#fields),* }), default)
    });
    let implementations = implementations(input, twin, &resolve, &write, &list);
    quote!(#declaration #implementations)
}

/// Generates the default of a resolved table, if all its keys are optional.
fn default(name: &TokenStream, kept: &[&KeyDeclaration]) -> Option<TokenStream> {
    let is_open = |row: &&KeyDeclaration| {
        row.default.is_some() || row.or_default || !matches!(row.shape(), FieldShape::One(_))
    };
    let values = kept.iter().map(|row| {
        let (ident, value) = (&row.ident, row.default_value());
        quote!(#ident: #value)
    });
    kept.iter().all(is_open).then(|| {
        quote! {
            impl Default for #name {
                fn default() -> Self {
                    Self { #(#values),* }
                }
            }
        }
    })
}

/// Generates the resolved table of an enum.
pub(super) fn of_enum(
    input: &DeriveInput,
    options: &TableOptions,
    variants: &[ResolvedVariant<'_>],
) -> TokenStream {
    let Some(twin) = &options.twin else {
        return quote!();
    };
    let name = twin.name();
    let resolve = variants.iter().map(|variant| {
        let ident = variant.ident;
        if variant.written {
            return quote!(Self::#ident { .. } => return None,);
        }
        let pattern = variant.pattern();
        let values = variant.keys.iter().map(|(row, key)| {
            let value = row.resolve(key, twin.exists());
            if variant.named {
                let ident = &row.ident;
                quote!(#ident: #value)
            } else {
                quote!(0: #value)
            }
        });
        quote!(Self::#pattern => #name::#ident { #(#values),* },)
    });
    let resolve = quote!(Some(match self { #(#resolve)* }));
    let kept = || variants.iter().filter(|it| !it.written);
    let write = kept().map(|variant| {
        let (pattern, writes) = (
            variant.pattern(),
            variant.keys.iter().map(|(row, _)| row.write()),
        );
        quote!(Self::#pattern => { #(#writes)* })
    });
    let write = quote!(match self { #(#write)* });
    let declaration = declaration(input, twin, || {
        let variants = kept().map(ResolvedVariant::declaration);
        (quote!(enum #name { #(#variants),* }), None)
    });
    let list = quote!(crate::table::tables_of(items));
    let implementations = implementations(input, twin, &resolve, &write, &list);
    quote!(#declaration #implementations)
}

impl ResolvedVariant<'_> {
    /// Generates the pattern that binds the variables of the keys.
    fn pattern(&self) -> TokenStream {
        let ident = self.ident;
        let fields = self.keys.iter().map(|(row, _)| {
            let (ident, variable) = (&row.ident, row.variable());
            if self.named {
                quote!(#ident: #variable)
            } else {
                quote!(0: #variable)
            }
        });
        quote!(#ident { #(#fields,)* .. })
    }

    fn declaration(&self) -> TokenStream {
        let Self {
            ident, doc, named, ..
        } = self;
        let fields = self.keys.iter().map(|(row, _)| {
            let (ident, kind, doc) = (&row.ident, row.resolved_kind(), &row.doc);
            if *named {
                quote!(#[doc = #doc] #ident: #kind)
            } else {
                kind
            }
        });
        if *named {
            quote!(#[doc = #doc] #ident { #(#fields),* })
        } else {
            quote!(#[doc = #doc] #ident(#(#fields),*))
        }
    }
}

/// Generates the declaration of a new type and its default; nothing for an existing one.
fn declaration(
    input: &DeriveInput,
    twin: &Twin,
    declare: impl FnOnce() -> (TokenStream, Option<TokenStream>),
) -> Option<TokenStream> {
    let doc = format!(
        "{} As it holds in a plan: without places, substituted, with defaults.",
        doc(&input.attrs)
    );
    (!twin.exists()).then(|| {
        let (declaration, default) = declare();
        quote! {
            #[doc = #doc]
            #[derive(Clone, Debug, PartialEq)]
            pub #declaration

            #default
        }
    })
}

/// Generates the conversion to the resolved table and its writer.
fn implementations(
    input: &DeriveInput,
    twin: &Twin,
    resolve: &TokenStream,
    write: &TokenStream,
    list: &TokenStream,
) -> TokenStream {
    let (name, twin) = (&input.ident, twin.name());
    quote! {
        impl crate::table::Resolve for #name {
            type Resolved = #twin;

            fn resolve(&self, _: &crate::table::Key, to: &mut crate::table::Resolver<'_>) -> Option<#twin> {
                #resolve
            }
        }

        impl crate::table::WrittenTable for #twin {
            fn keys(&self, within: &str) -> crate::table::Lines {
                let mut keys = crate::table::Lines::new();
                #write
                keys
            }
        }

        impl crate::table::Written for #twin {
            fn toml(&self) -> Option<toml_edit::Value> {
                crate::table::WrittenTable::keys(self, "").inline()
            }

            fn list(items: &[Self]) -> Option<toml_edit::Value> {
                #list
            }
        }
    }
}
