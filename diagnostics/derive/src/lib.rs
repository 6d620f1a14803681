//! The derive macro of `asmotion-diagnostics`: `#[derive(Coded)]` turns the doc comment of a
//! finding into the documentation page of its code.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Attribute, DeriveInput, Error, Expr, Ident, Lit, Meta, Result, Token};

/// Implements `Coded` for a finding and gives it the constant `CODE`.
///
/// `#[code(A014, error)]` names the code and its severity, `error` or `warning`. The first line of the doc
/// comment is the title of the page, the rest is its text.
#[proc_macro_derive(Coded, attributes(code))]
pub fn coded(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let input = syn::parse_macro_input!(input as DeriveInput);
    expand(&input)
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

fn expand(input: &DeriveInput) -> Result<TokenStream> {
    let finding = &input.ident;
    let (name, severity) = code(input)?;
    let (title, page) = page(input)?;
    let (generics, arguments, bounds) = input.generics.split_for_impl();
    Ok(quote! {
        impl #generics #finding #arguments #bounds {
            /// The code of this finding, with its documentation page.
            pub const CODE: &'static ::asmotion_diagnostics::Code = &::asmotion_diagnostics::Code {
                name: #name,
                severity: ::asmotion_diagnostics::Severity::#severity,
                title: #title,
                text: #page,
            };
        }

        impl #generics ::asmotion_diagnostics::Coded for #finding #arguments #bounds {
            fn code(&self) -> &'static ::asmotion_diagnostics::Code {
                Self::CODE
            }
        }
    })
}

/// Parses the name and the severity from `#[code(A014, error)]`.
fn code(input: &DeriveInput) -> Result<(String, Ident)> {
    let is_code = |attribute: &&Attribute| attribute.path().is_ident("code");
    let Some(attribute) = input.attrs.iter().find(is_code) else {
        let missing = "a finding needs a code, as in `#[code(A014, error)]`";
        return Err(Error::new_spanned(&input.ident, missing));
    };
    attribute.parse_args_with(|tokens: syn::parse::ParseStream<'_>| {
        let name: Ident = tokens.parse()?;
        tokens.parse::<Token![,]>()?;
        let severity: Ident = tokens.parse()?;
        let variant = match severity.to_string().as_str() {
            "error" => "Error",
            "warning" => "Warning",
            _ => return Err(Error::new(severity.span(), "expected `error` or `warning`")),
        };
        Ok((name.to_string(), Ident::new(variant, severity.span())))
    })
}

/// Splits the doc comment into its first line, the title, and the remaining text.
fn page(input: &DeriveInput) -> Result<(String, String)> {
    let lines: Vec<String> = input.attrs.iter().filter_map(doc_line).collect();
    let Some((title, rest)) = lines.split_first() else {
        let missing = "a finding needs a doc comment: it is the page of the code";
        return Err(Error::new_spanned(&input.ident, missing));
    };
    let text = rest.join("\n").trim().to_owned() + "\n";
    Ok((title.trim().to_owned(), text))
}

/// Returns one line of a doc comment, without the blank after the slashes.
fn doc_line(attribute: &Attribute) -> Option<String> {
    let Meta::NameValue(meta) = &attribute.meta else {
        return None;
    };
    let Expr::Lit(literal) = &meta.value else {
        return None;
    };
    let Lit::Str(line) = &literal.lit else {
        return None;
    };
    let is_doc = meta.path.is_ident("doc");
    let line = line.value();
    is_doc.then(|| line.strip_prefix(' ').unwrap_or(&line).to_owned())
}
