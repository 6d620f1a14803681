//! Shared by `Properties` and `Ports`: struct fields, their documentation, and attribute values.

use proc_macro2::{TokenStream, TokenTree};
use syn::parse::ParseStream;
use syn::punctuated::Punctuated;
use syn::{Attribute, Data, DeriveInput, Error, Expr, Field, Fields, Ident, Lit, LitStr, Meta};
use syn::{Result, Token};

/// Returns the named fields of a struct without generics; `derive` names the macro in the error.
pub fn named<'a>(input: &'a DeriveInput, derive: &str) -> Result<&'a Punctuated<Field, Token![,]>> {
    if let Data::Struct(data) = &input.data
        && let Fields::Named(fields) = &data.fields
        && input.generics.params.is_empty()
    {
        return Ok(&fields.named);
    }
    let message = format!("`{derive}` needs a struct with named fields and no parameters");
    Err(Error::new_spanned(&input.ident, message))
}

/// Parses every field; on failure, combines the errors of all fields.
pub fn each<'a, T>(
    fields: &'a Punctuated<Field, Token![,]>,
    parse: impl Fn(&'a Field, &'a Ident) -> Result<T>,
) -> Result<Vec<T>> {
    let mut parsed = Vec::new();
    let mut errors: Option<Error> = None;
    for field in fields {
        let Some(name) = &field.ident else {
            continue;
        };
        match (parse(field, name), &mut errors) {
            (Ok(one), _) => parsed.push(one),
            (Err(error), Some(errors)) => errors.combine(error),
            (Err(error), none) => *none = Some(error),
        }
    }
    errors.map_or(Ok(parsed), Err)
}

/// Returns a field's name without `r#`.
pub fn plain(name: &Ident) -> String {
    let name = name.to_string();
    name.strip_prefix("r#").unwrap_or(&name).to_owned()
}

/// Returns the documentation of a field, one line for each paragraph. Documentation is mandatory
/// because editors, `component info` and the reference pages show it.
pub fn documentation(field: &Field) -> Result<String> {
    let mut text = String::new();
    for line in field.attrs.iter().filter_map(doc) {
        let line = line.trim();
        if line.is_empty() && !text.is_empty() && !text.ends_with('\n') {
            text.push('\n');
        } else if !line.is_empty() && !text.is_empty() && !text.ends_with('\n') {
            text.push(' ');
        }
        text.push_str(line);
    }
    match text.trim_end() {
        "" => {
            let message = "a declared field needs a doc comment: it is the description people read";
            Err(Error::new_spanned(field, message))
        }
        text => Ok(text.to_owned()),
    }
}

/// Returns the text of a `///` line.
fn doc(attribute: &Attribute) -> Option<String> {
    let Meta::NameValue(doc) = &attribute.meta else {
        return None;
    };
    if let Expr::Lit(literal) = &doc.value
        && let Lit::Str(text) = &literal.lit
        && doc.path.is_ident("doc")
    {
        Some(text.value())
    } else {
        None
    }
}

/// Collects the tokens of an attribute's value up to the next comma. They are not parsed further:
/// the compiler reports errors in an expression better than a macro can.
pub fn value(input: ParseStream<'_>) -> Result<TokenStream> {
    until(input, |input| input.peek(Token![,]))
}

/// Parses both bounds of an inclusive range.
pub fn range(input: ParseStream<'_>) -> Result<(TokenStream, TokenStream)> {
    let start = until(input, |input| {
        input.peek(Token![..=]) || input.peek(Token![,])
    })?;
    input.parse::<Token![..=]>()?;
    Ok((start, value(input)?))
}

fn until(input: ParseStream<'_>, end: impl Fn(ParseStream<'_>) -> bool) -> Result<TokenStream> {
    let mut tokens = TokenStream::new();
    while !input.is_empty() && !end(input) {
        tokens.extend([input.parse::<TokenTree>()?]);
    }
    if tokens.is_empty() {
        Err(input.error("a value is missing"))
    } else {
        Ok(tokens)
    }
}

/// Returns the value if it is a string literal.
pub fn text(value: &TokenStream) -> Option<LitStr> {
    syn::parse2(value.clone()).ok()
}
