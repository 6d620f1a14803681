//! Catch-all arms of `match` expressions over enums of this repository.

use crate::checkout::{Checkout, SourceFile};
use std::collections::BTreeSet;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// The `match` expressions of the product, and those among them with a catch-all arm.
#[derive(Debug, Default)]
pub struct MatchCount {
    /// Number of `match` expressions.
    pub matches: usize,
    /// Number of matches with `_ =>` next to a variant of an enum of this repository.
    pub wildcards: usize,
}

/// Counts the `match` expressions of the product.
pub fn count(checkout: &Checkout) -> MatchCount {
    let mut enums = BTreeSet::new();
    for file in &checkout.files {
        EnumVisitor(&mut enums).visit_file(&file.tree);
    }
    let mut count = MatchCount::default();
    for file in &checkout.files {
        let mut visitor = MatchVisitor {
            file,
            enums: &enums,
            within: None,
            count: &mut count,
        };
        visitor.visit_file(&file.tree);
    }
    count
}

struct EnumVisitor<'names>(&'names mut BTreeSet<String>);

impl<'ast> Visit<'ast> for EnumVisitor<'_> {
    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.0.insert(item.ident.to_string());
    }
}

struct MatchVisitor<'a> {
    file: &'a SourceFile,
    enums: &'a BTreeSet<String>,
    /// The type of the enclosing `impl` block, for `Self::Variant`.
    within: Option<String>,
    count: &'a mut MatchCount,
}

impl MatchVisitor<'_> {
    fn is_own(&self, path: &syn::Path) -> bool {
        let mut from_last = path.segments.iter().rev();
        let (Some(_variant), Some(owner)) = (from_last.next(), from_last.next()) else {
            return false;
        };
        let owner = owner.ident.to_string();
        match &self.within {
            Some(within) if owner == "Self" => self.enums.contains(within),
            _ => self.enums.contains(&owner),
        }
    }

    /// Returns `true` if the outermost constructor of a pattern is a variant of an enum of this
    /// repository.
    fn names_variant(&self, pattern: &syn::Pat) -> bool {
        #[expect(clippy::wildcard_enum_match_arm, reason = "the enum of `syn` is open")]
        match pattern {
            syn::Pat::Or(it) => it.cases.iter().any(|case| self.names_variant(case)),
            syn::Pat::Guard(it) => self.names_variant(&it.pat),
            syn::Pat::Paren(it) => self.names_variant(&it.pat),
            syn::Pat::Reference(it) => self.names_variant(&it.pat),
            syn::Pat::Ident(it) => it
                .subpat
                .as_ref()
                .is_some_and(|(_, inner)| self.names_variant(inner)),
            syn::Pat::Path(it) => self.is_own(&it.path),
            syn::Pat::Struct(it) => self.is_own(&it.path),
            syn::Pat::TupleStruct(it) => self.is_own(&it.path),
            _ => false,
        }
    }
}

impl<'ast> Visit<'ast> for MatchVisitor<'_> {
    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let name = if let syn::Type::Path(it) = &*item.self_ty {
            it.path.segments.last().map(|last| last.ident.to_string())
        } else {
            None
        };
        let outer = std::mem::replace(&mut self.within, name);
        visit::visit_item_impl(self, item);
        self.within = outer;
    }

    fn visit_expr_match(&mut self, expression: &'ast syn::ExprMatch) {
        let line = expression.match_token.span().start().line;
        if !self.file.is_test(line) {
            self.count.matches += 1;
            let wild = |arm: &syn::Arm| matches!(arm.pat, syn::Pat::Wild(_));
            let own = |arm: &syn::Arm| self.names_variant(&arm.pat);
            if expression.arms.iter().any(wild) && expression.arms.iter().any(own) {
                self.count.wildcards += 1;
            }
        }
        visit::visit_expr_match(self, expression);
    }
}
