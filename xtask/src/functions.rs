//! The lengths of functions.

use crate::checkout::SourceFile;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// A function with a body.
#[derive(Clone, Debug)]
pub struct FunctionLength {
    /// Name of the function.
    pub name: String,
    /// Path of its file.
    pub path: String,
    /// Line of `fn`, from 1.
    pub line: usize,
    /// Number of lines from `fn` to the closing brace.
    pub lines: usize,
    /// `true` if it is compiled only for tests.
    pub test: bool,
}

/// Returns all functions of a file. Closures are part of the enclosing function.
pub fn lengths(file: &SourceFile) -> Vec<FunctionLength> {
    let mut collector = LengthVisitor {
        file,
        found: Vec::new(),
    };
    collector.visit_file(&file.tree);
    collector.found
}

struct LengthVisitor<'file> {
    file: &'file SourceFile,
    found: Vec<FunctionLength>,
}

impl LengthVisitor<'_> {
    fn add(&mut self, signature: &syn::Signature, body: &syn::Block) {
        let line = signature.span().start().line;
        self.found.push(FunctionLength {
            name: signature.ident.to_string(),
            path: self.file.path.clone(),
            line,
            lines: body.span().end().line + 1 - line,
            test: self.file.is_test(line),
        });
    }
}

impl<'ast> Visit<'ast> for LengthVisitor<'_> {
    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        self.add(&function.sig, &function.block);
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.add(&function.sig, &function.block);
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        if let Some(body) = &function.default {
            self.add(&function.sig, body);
        }
        visit::visit_trait_item_fn(self, function);
    }
}

/// Returns the percentile of sorted lengths; `share` is from 0 to 1.
pub fn percentile(sorted: &[usize], share: f64) -> usize {
    let last = sorted.len().saturating_sub(1);
    let at = (last as f64 * share).round() as usize;
    sorted.get(at).copied().unwrap_or_default()
}
