//! `#[derive(Word)]`: the variants of an enum become words, lawful values of a property.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, Ident, Result};

pub fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let of = &input.ident;
    let Data::Enum(data) = &input.data else {
        return Err(Error::new_spanned(of, "`Word` needs an enum"));
    };
    let mut variants = Vec::new();
    for variant in &data.variants {
        match variant.fields {
            Fields::Unit => variants.push(&variant.ident),
            Fields::Named(_) | Fields::Unnamed(_) => {
                let message = "a word carries nothing: the variant must have no fields";
                return Err(Error::new_spanned(variant, message));
            }
        }
    }
    let words: Vec<String> = variants.iter().map(|variant| snake_case(variant)).collect();
    Ok(quote! {
        #[automatically_derived]
        impl ::asmotion_component::Word for #of {
            const ALL: &'static [Self] = &[#(Self::#variants,)*];

            fn word(&self) -> &'static str {
                match self {
                    #(Self::#variants => #words,)*
                }
            }
        }
    })
}

/// `AStar` is written `a_star`.
fn snake_case(variant: &Ident) -> String {
    let mut word = String::new();
    for letter in variant.to_string().chars() {
        if letter.is_uppercase() && !word.is_empty() {
            word.push('_');
        }
        word.extend(letter.to_lowercase());
    }
    word
}
