//! Names of types, and names that denote several types.

use crate::checkout::Checkout;
use std::collections::BTreeMap;
use syn::visit::{self, Visit};

/// Returns the files that define each type name of the product: structs, enums, unions, traits and
/// aliases.
///
/// A name defined twice in one file counts once, because its definitions are alternatives under
/// `cfg`.
pub fn definitions(checkout: &Checkout) -> BTreeMap<String, Vec<String>> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in &checkout.files {
        let mut visitor = NameVisitor(Vec::new());
        visitor.visit_file(&file.tree);
        for (name, line) in visitor.0 {
            let paths = found.entry(name).or_default();
            if !file.is_test(line) && paths.last() != Some(&file.path) {
                paths.push(file.path.clone());
            }
        }
    }
    found.retain(|_, paths| !paths.is_empty());
    found
}

struct NameVisitor(Vec<(String, usize)>);

impl NameVisitor {
    fn add(&mut self, name: &syn::Ident) {
        self.0.push((name.to_string(), name.span().start().line));
    }
}

impl<'ast> Visit<'ast> for NameVisitor {
    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.add(&item.ident);
    }

    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.add(&item.ident);
    }

    fn visit_item_union(&mut self, item: &'ast syn::ItemUnion) {
        self.add(&item.ident);
    }

    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        self.add(&item.ident);
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.add(&item.ident);
        visit::visit_item_trait(self, item);
    }
}

/// Statistics of type names with several meanings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NameReuse {
    /// Number of distinct names.
    pub names: usize,
    /// Number of names of more than one type.
    pub reused: usize,
}

impl NameReuse {
    /// Computes the statistics from [`definitions`].
    pub fn of(definitions: &BTreeMap<String, Vec<String>>) -> Self {
        Self {
            names: definitions.len(),
            reused: definitions.values().filter(|paths| paths.len() > 1).count(),
        }
    }

    /// Returns the percentage of reused names.
    pub fn percent(self) -> f64 {
        100.0 * self.reused as f64 / self.names.max(1) as f64
    }
}
