//! Tables from enums: the first key of a variant selects it.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::{DataEnum, DeriveInput, Error, Fields, Ident, Result, Type, Variant};

use super::common::common;
use super::key::KeyDeclaration;
use super::options::TableOptions;
use super::resolved::{self, ResolvedVariant};
use crate::word::{doc, snake};

/// A variant and its keys; the first key selects the variant.
struct VariantKeys {
    rows: Vec<KeyDeclaration>,
    /// The table wrapped by a variant with one unnamed field, which provides the keys.
    inner: Option<Type>,
    /// The variant has named fields.
    named: bool,
    ident: Ident,
    doc: String,
}

impl VariantKeys {
    fn of(variant: &Variant) -> Result<Self> {
        let (ident, doc) = (variant.ident.clone(), doc(&variant.attrs));
        match &variant.fields {
            Fields::Named(fields) => Ok(Self {
                rows: fields
                    .named
                    .iter()
                    .map(KeyDeclaration::of_field)
                    .collect::<Result<_>>()?,
                inner: None,
                named: true,
                ident,
                doc,
            }),
            Fields::Unnamed(fields) if fields.unnamed.len() == 1 => {
                let kind = &fields.unnamed[0].ty;
                let row = KeyDeclaration::of(&ident, kind, &variant.attrs)?;
                let inner = row.flatten.then(|| kind.clone());
                Ok(Self {
                    rows: vec![row],
                    inner,
                    named: false,
                    ident,
                    doc,
                })
            }
            Fields::Unnamed(_) | Fields::Unit => Err(Error::new_spanned(
                variant,
                "a variant has named fields, or one",
            )),
        }
    }

    fn resolved(&self) -> ResolvedVariant<'_> {
        let constant = constant(&self.ident);
        let keys = self.rows.iter().enumerate().map(|(at, row)| {
            if self.inner.is_some() {
                (row, quote!(&crate::table::Key::NAME))
            } else {
                (row, quote!(&Self::#constant[#at]))
            }
        });
        ResolvedVariant {
            ident: &self.ident,
            doc: self.doc.clone(),
            named: self.named,
            written: !self.named && self.rows.iter().any(|row| row.written),
            keys: keys.filter(|(row, _)| row.is_resolved()).collect(),
        }
    }
}

pub(super) fn of_enum(
    input: &DeriveInput,
    data: &DataEnum,
    options: &TableOptions,
) -> Result<TokenStream> {
    let name = &input.ident;
    let choices = data
        .variants
        .iter()
        .map(VariantKeys::of)
        .collect::<Result<Vec<_>>>()?;
    let reason = &options.reason;
    let constants = choices
        .iter()
        .filter(|it| it.inner.is_none())
        .map(|choice| {
            let keys = choice.rows.iter().map(KeyDeclaration::key);
            let constant = constant(&choice.ident);
            quote!(const #constant: &'static [crate::table::Key] = &[#(#keys),*];)
        });
    let chosen_by = choices.iter().map(|choice| match &choice.inner {
        Some(inner) => quote!(<#inner as crate::table::Table>::first()),
        None => {
            let constant = constant(&choice.ident);
            quote!(&Self::#constant[0])
        }
    });
    let outline = choices.iter().map(|choice| match &choice.inner {
        Some(inner) => quote!(outline.choice(<#inner as crate::table::Table>::outline().all());),
        None => {
            let constant = constant(&choice.ident);
            quote!(outline.choice(Self::#constant.iter().collect());)
        }
    });
    let arms = choices.iter().enumerate().map(|(at, choice)| {
        let (variant, constant) = (&choice.ident, constant(&choice.ident));
        if let Some(inner) = &choice.inner {
            return quote!(Some(#at) => Self::#variant(<#inner as crate::table::Table>::read_keys(keys, name)?));
        }
        let bindings: Vec<Ident> = (0..choice.rows.len()).map(|at| format_ident!("field{at}")).collect();
        let reads = choice.rows.iter().enumerate().map(|(at, row)| {
            let (binding, read) = (&bindings[at], row.read(&quote!(&Self::#constant[#at])));
            quote!(let #binding = #read;)
        });
        let made = choice.rows.iter().enumerate().map(|(at, row)| {
            let (binding, ident) = (&bindings[at], &row.ident);
            let value = if row.is_unwrapped() { quote!(#binding?) } else { quote!(#binding) };
            if choice.named { quote!(#ident: #value) } else { value }
        });
        let made = if choice.named { quote!(Self::#variant { #(#made),* }) } else { quote!(Self::#variant(#(#made),*)) };
        quote!(Some(#at) => { #(#reads)* #made })
    });
    let common = common(input, options, None);
    let variants: Vec<_> = choices.iter().map(VariantKeys::resolved).collect();
    let resolved = resolved::of_enum(input, options, &variants);
    Ok(quote! {
        impl #name {
            #(#constants)*
        }

        impl crate::table::Table for #name {
            fn outline() -> crate::table::Outline {
                let mut outline = Self::blank();
                #(#outline)*
                outline
            }

            fn read_keys(keys: &mut crate::table::derived::Keys<'_, '_, '_>, name: &crate::table::derived::At<String>) -> Option<Self> {
                let _ = name;
                Some(match keys.one_of(&[#(#chosen_by),*], #reason) {
                    #(#arms,)*
                    _ => {
                        keys.know(&Self::outline());
                        return None;
                    }
                })
            }
        }

        #common
        #resolved
    })
}

/// Returns the name of the constant with the keys of a variant.
fn constant(variant: &Ident) -> Ident {
    format_ident!("{}_KEYS", snake(&variant.to_string()).to_uppercase())
}
