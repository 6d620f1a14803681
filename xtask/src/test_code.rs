//! Code that is compiled only for tests.

use proc_macro2::{TokenStream, TokenTree};
use std::ops::RangeInclusive;
use syn::spanned::Spanned;

/// The lines of a file that are compiled only for tests.
#[derive(Debug)]
pub enum TestLines {
    /// All lines: a file below `tests/`, or the file of a test module.
    Whole,
    /// The lines of items with `#[cfg(test)]`.
    Parts(Vec<RangeInclusive<usize>>),
}

impl TestLines {
    pub(crate) fn of(tree: &syn::File) -> Self {
        let test = tree
            .items
            .iter()
            .filter(|item| is_cfg_test(attributes(item)));
        Self::Parts(
            test.map(|item| item.span().start().line..=item.span().end().line)
                .collect(),
        )
    }

    pub(crate) fn contains(&self, line: usize) -> bool {
        match self {
            Self::Whole => true,
            Self::Parts(parts) => parts.iter().any(|part| part.contains(&line)),
        }
    }
}

/// Returns the attributes of an item.
pub fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the enum of `syn` is open")]
    match item {
        syn::Item::Const(it) => &it.attrs,
        syn::Item::Enum(it) => &it.attrs,
        syn::Item::ExternCrate(it) => &it.attrs,
        syn::Item::Fn(it) => &it.attrs,
        syn::Item::ForeignMod(it) => &it.attrs,
        syn::Item::Impl(it) => &it.attrs,
        syn::Item::Macro(it) => &it.attrs,
        syn::Item::Mod(it) => &it.attrs,
        syn::Item::Static(it) => &it.attrs,
        syn::Item::Struct(it) => &it.attrs,
        syn::Item::Trait(it) => &it.attrs,
        syn::Item::TraitAlias(it) => &it.attrs,
        syn::Item::Type(it) => &it.attrs,
        syn::Item::Union(it) => &it.attrs,
        syn::Item::Use(it) => &it.attrs,
        _ => &[],
    }
}

/// Returns `true` if the attributes include `#[cfg(test)]` or `#[cfg(all(test, …))]`.
pub fn is_cfg_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let syn::Meta::List(list) = &attribute.meta else {
            return false;
        };
        let condition = list.tokens.to_string();
        list.path.is_ident("cfg")
            && (condition == "test"
                || condition.starts_with("all (test")
                || condition.starts_with("all(test"))
    })
}

/// Returns the lines of multi-line string literals, without the first line of each.
pub(crate) fn long_literals(tokens: TokenStream) -> Vec<RangeInclusive<usize>> {
    let mut found = Vec::new();
    for token in tokens {
        match token {
            TokenTree::Group(group) => found.extend(long_literals(group.stream())),
            TokenTree::Literal(literal) => {
                let span = literal.span();
                if span.end().line > span.start().line {
                    found.push(span.start().line + 1..=span.end().line);
                }
            }
            TokenTree::Ident(_) | TokenTree::Punct(_) => {}
        }
    }
    found
}
