//! `#[derive(Word)]`: an enum whose variants are the keywords of a closed list.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Attribute, Data, DeriveInput, Error, Expr, ExprLit, Fields, Lit, LitStr, Meta, Result};

/// Implements `asmotion_datum::Word` and `Display`. A variant is written as its name in snake case,
/// unless `#[word("other")]` gives another spelling; its doc comment explains the word.
pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let Data::Enum(data) = &input.data else {
        return Err(Error::new_spanned(input, "only an enum is a list of words"));
    };
    let name = &input.ident;
    let mut rows = Vec::new();
    for variant in &data.variants {
        if !matches!(variant.fields, Fields::Unit) {
            let message = "a word carries nothing: the variant must have no fields";
            return Err(Error::new_spanned(variant, message));
        }
        let ident = &variant.ident;
        let written = variant.attrs.iter().find(|it| it.path().is_ident("word"));
        let word = match written {
            Some(attribute) => attribute.parse_args::<LitStr>()?.value(),
            None => snake(&ident.to_string()),
        };
        let doc = doc(&variant.attrs);
        rows.push(quote!((#word, Self::#ident, #doc)));
    }
    Ok(quote! {
        #[automatically_derived]
        impl ::asmotion_datum::Word for #name {
            const WORDS: &'static [(&'static str, Self, &'static str)] = &[#(#rows),*];
        }

        #[automatically_derived]
        impl ::std::fmt::Display for #name {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.write_str(::asmotion_datum::Word::word(*self))
            }
        }
    })
}

/// Converts `CatchUp` to `catch_up`.
pub(crate) fn snake(name: &str) -> String {
    let mut snake = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    snake
}

/// Returns the documentation of an item, with the lines of each paragraph joined.
pub(crate) fn doc(attributes: &[Attribute]) -> String {
    let mut doc = String::new();
    for attribute in attributes {
        if let Meta::NameValue(pair) = &attribute.meta
            && pair.path.is_ident("doc")
            && let Expr::Lit(ExprLit {
                lit: Lit::Str(line),
                ..
            }) = &pair.value
        {
            let line = line.value();
            match line.trim() {
                "" => doc.push('\n'),
                line => {
                    if !doc.is_empty() && !doc.ends_with('\n') {
                        doc.push(' ');
                    }
                    doc.push_str(line);
                }
            }
        }
    }
    doc.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use syn::parse_quote;

    #[test]
    fn it_takes_words_from_names_or_attributes() {
        let made = super::derive(&parse_quote! {
            enum Overrun {
                /// Left out,
                /// and counted.
                CatchUp,
                #[word("rr")]
                RoundRobin,
            }
        });
        let made = made.map_or_else(|error| error.to_string(), |made| made.to_string());
        assert!(
            made.contains(r#"("catch_up" , Self :: CatchUp , "Left out, and counted.")"#),
            "{made}"
        );
        assert!(
            made.contains(r#"("rr" , Self :: RoundRobin , "")"#),
            "{made}"
        );
    }
}
