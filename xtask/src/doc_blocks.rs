//! Doc comments: their length, and the words they begin with.

use crate::checkout::SourceFile;
use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// Words that begin a subordinate clause.
const CLAUSES: &[&str] = &["What", "How", "Whether", "Where", "Who", "Whose", "Whom"];

/// Figures about the doc comments of the product.
#[derive(Clone, Copy, Debug, Default)]
pub struct DocCount {
    /// Number of doc comments, one for each documented item or module.
    pub blocks: usize,
    /// Number of doc comments with at most three words.
    pub short: usize,
    /// Number of doc comments that begin with one of the words in `CLAUSES`.
    pub clauses: usize,
    /// Number of doc comments with an `# Errors` section.
    pub errors: usize,
    /// Number of public functions that return a `Result`.
    pub fallible: usize,
}

/// Adds the doc comments of a file.
pub fn count(file: &SourceFile, count: &mut DocCount) {
    let mut visitor = DocVisitor { file, count };
    visitor.attributes(&file.tree.attrs);
    visitor.visit_file(&file.tree);
}

struct DocVisitor<'a> {
    file: &'a SourceFile,
    count: &'a mut DocCount,
}

impl DocVisitor<'_> {
    fn attributes(&mut self, attributes: &[syn::Attribute]) {
        let docs = attributes.iter().filter_map(doc_line);
        let Some((_, span)) = docs.clone().next() else {
            return;
        };
        if self.file.is_test(span.start().line) {
            return;
        }
        let lines: Vec<String> = docs.map(|(line, _)| line).collect();
        let text = lines.join("\n");
        self.count.blocks += 1;
        self.count.short += usize::from(text.split_whitespace().count() <= 3);
        let first = text.split_whitespace().next().unwrap_or_default();
        self.count.clauses += usize::from(CLAUSES.contains(&first));
        self.count.errors += usize::from(lines.iter().any(|line| line.trim() == "# Errors"));
    }

    fn signature(&mut self, visibility: &syn::Visibility, signature: &syn::Signature) {
        let public = matches!(visibility, syn::Visibility::Public(_));
        let fallible = match &signature.output {
            syn::ReturnType::Type(_, output) => {
                if let syn::Type::Path(it) = &**output {
                    let last = it.path.segments.last();
                    last.is_some_and(|last| last.ident == "Result")
                } else {
                    false
                }
            }
            syn::ReturnType::Default => false,
        };
        let test = self.file.is_test(signature.span().start().line);
        self.count.fallible += usize::from(public && fallible && !test);
    }
}

/// Returns the text and the span of a doc attribute.
fn doc_line(attribute: &syn::Attribute) -> Option<(String, Span)> {
    let syn::Meta::NameValue(pair) = &attribute.meta else {
        return None;
    };
    let syn::Expr::Lit(value) = &pair.value else {
        return None;
    };
    let syn::Lit::Str(text) = &value.lit else {
        return None;
    };
    let is_doc = pair.path.is_ident("doc");
    is_doc.then(|| (text.value(), value.span()))
}

impl<'ast> Visit<'ast> for DocVisitor<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        self.attributes(crate::test_code::attributes(item));
        visit::visit_item(self, item);
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        self.signature(&function.vis, &function.sig);
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.attributes(&function.attrs);
        self.signature(&function.vis, &function.sig);
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_impl_item_const(&mut self, constant: &'ast syn::ImplItemConst) {
        self.attributes(&constant.attrs);
        visit::visit_impl_item_const(self, constant);
    }

    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        self.attributes(&function.attrs);
        visit::visit_trait_item_fn(self, function);
    }

    fn visit_trait_item_type(&mut self, item: &'ast syn::TraitItemType) {
        self.attributes(&item.attrs);
        visit::visit_trait_item_type(self, item);
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        self.attributes(&field.attrs);
        visit::visit_field(self, field);
    }

    fn visit_variant(&mut self, variant: &'ast syn::Variant) {
        self.attributes(&variant.attrs);
        visit::visit_variant(self, variant);
    }
}
