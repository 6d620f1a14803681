//! Names that an imported module declares but that are not visible: the module does not export
//! them, or the import does not list them.

use asmotion_diagnostics::{Diagnostic, FileId, Span};
use asmotion_syntax::ast;
use std::sync::Arc;

/// A loaded import of a unit, with the clauses that decide which names it makes visible.
#[derive(Debug)]
pub(crate) struct ImportClause {
    /// Index of the imported unit.
    pub from: usize,
    /// Text of the imported unit.
    pub file: FileId,
    pub import: ast::Import,
    pub export: Option<ast::Export>,
    /// Name of the main rule of the imported unit, which no import makes visible.
    pub main: Option<Span>,
}

/// The kind of declaration that an unknown name was searched among.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NameKind {
    Function,
    Rule,
    Domain,
    /// A literal of an enumeration, or a domain that stands for its elements.
    Constant,
}

/// The declaration of a name that is not visible, and the clause that hides it.
#[derive(Clone, Debug)]
pub(crate) struct HiddenName {
    /// Path of the import.
    pub module: Arc<str>,
    /// Name that the clause lacks: the name itself, or the domain of a literal.
    pub lacking: Arc<str>,
    /// `true` if the name is a literal of the domain `lacking`.
    pub literal: bool,
    pub declared: Span,
    pub hidden_by: HidingClause,
}

/// A clause that lacks a name, with the empty span behind its last name; `None` if there is no name
/// to append to.
#[derive(Clone, Copy, Debug)]
pub(crate) enum HidingClause {
    Export(Option<Span>),
    Import(Option<Span>),
}

impl HiddenName {
    /// Labels the use of the name and its declaration, and suggests to add the name to the clause.
    pub fn explain(&self, diagnostic: Diagnostic, at: Span) -> Diagnostic {
        let Self {
            module,
            lacking,
            hidden_by,
            ..
        } = self;
        let label = match (hidden_by, self.literal) {
            (HidingClause::Export(_), false) => {
                format!("declared in `{module}`, which does not export it")
            }
            (HidingClause::Export(_), true) => {
                format!("literal of `{lacking}`, which `{module}` does not export")
            }
            (HidingClause::Import(_), false) => {
                format!("exported by `{module}`, but not listed in its import")
            }
            (HidingClause::Import(_), true) => {
                format!("literal of `{lacking}`, which the import of `{module}` does not list")
            }
        };
        self.suggest(diagnostic.label(at, label))
    }

    /// Labels the declaration, and suggests to add the name to the clause.
    pub fn suggest(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            module, lacking, ..
        } = self;
        let diagnostic = diagnostic.label(self.declared, "declared here");
        match self.hidden_by {
            HidingClause::Export(Some(end)) => {
                let title = format!("export `{lacking}` from `{module}`");
                diagnostic.guess(title, end, format!(", {lacking}"))
            }
            HidingClause::Export(None) => {
                diagnostic.help(format!("write `export {lacking}` in `{module}`"))
            }
            HidingClause::Import(Some(end)) => {
                let title = format!("import `{lacking}` as well");
                diagnostic.guess(title, end, format!(", {lacking}"))
            }
            HidingClause::Import(None) => {
                diagnostic.help(format!("write `import {module}({lacking})`"))
            }
        }
    }
}
