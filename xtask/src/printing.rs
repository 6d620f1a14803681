//! Calls of printing macros.

use crate::checkout::{Checkout, SourceFile};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

const PRINTING: &[&str] = &["print", "println", "eprint", "eprintln", "dbg"];

/// Returns path and line of each such call in the product's code, except in files whose path begins
/// with one of `allowed`.
pub fn calls(checkout: &Checkout, allowed: &[&str]) -> Vec<(String, usize)> {
    let mut found = Vec::new();
    for file in &checkout.files {
        if !allowed.iter().any(|start| file.path.starts_with(start)) {
            let mut visitor = PrintVisitor {
                file,
                found: &mut found,
            };
            visitor.visit_file(&file.tree);
        }
    }
    found
}

struct PrintVisitor<'a> {
    file: &'a SourceFile,
    found: &'a mut Vec<(String, usize)>,
}

impl<'ast> Visit<'ast> for PrintVisitor<'_> {
    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        let line = call.span().start().line;
        let last = call.path.segments.last();
        let prints = last.is_some_and(|name| PRINTING.iter().any(|it| name.ident == it));
        if prints && !self.file.is_test(line) {
            self.found.push((self.file.path.clone(), line));
        }
        visit::visit_macro(self, call);
    }
}
