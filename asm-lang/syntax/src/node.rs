//! Builds the nodes of the tree: computes spans and depths, and checks what the grammar cannot
//! express.

mod file;
mod order;
mod rule;
mod term;

pub(crate) use file::{Item, empty as empty_file};
pub(crate) use rule::Choose;
pub(crate) use term::{Elements, applied};

use crate::ast::*;
use crate::codes::l056::Misnamed;
use crate::codes::l075::PropertyPrefix;
use crate::explain::{Explainer, ParserError};
use crate::findings::SyntaxFindings;
use crate::lexer::Token;
use asmotion_diagnostics::Span;
use lalrpop_util::ErrorRecovery;
use std::cell::RefCell;
use std::convert::Infallible;
use std::sync::Arc;

/// An error caught by the parser, with the skipped tokens.
pub(crate) type Caught<'input> = ErrorRecovery<usize, Token<'input>, Infallible>;

/// The result of parsing a text, according to its start symbol.
#[expect(clippy::large_enum_variant, reason = "one short-lived value per parse")]
pub(crate) enum ParsedText {
    File(File),
    Rule(Rule),
    Term(Term),
}

/// Constructors of nodes, called by the actions of the grammar.
pub(crate) struct Nodes<'input, 'run> {
    text: &'input str,
    findings: &'run SyntaxFindings,
    explainer: RefCell<Explainer<'input, 'run>>,
    /// Names that the fix of bindings without brackets corrects, within other such bindings, too.
    respelt: RefCell<Vec<Span>>,
}

impl<'input, 'run> Nodes<'input, 'run> {
    /// Creates the constructors for one run of the parser.
    pub(crate) fn new(
        text: &'input str,
        findings: &'run SyntaxFindings,
        explainer: Explainer<'input, 'run>,
    ) -> Self {
        Self {
            text,
            findings,
            explainer: RefCell::new(explainer),
            respelt: RefCell::default(),
        }
    }

    // ── declarations ──

    /// Builds the main rule from the rule after the keyword `main`.
    pub(crate) fn main(&self, start: usize, rule: RuleDeclaration) -> Item {
        let span = self.span(start, start).to(rule.span);
        Item::Main(RuleDeclaration { span, ..rule })
    }

    /// Builds a domain of the signature.
    pub(crate) fn domain(
        &self,
        start: usize,
        dynamic: bool,
        (name, kind): (NameText, DomainKind),
        end: usize,
    ) -> Domain {
        Domain {
            name,
            kind,
            dynamic,
            span: self.span(start, end),
        }
    }

    /// Builds a structured domain without a name, which is named by its text.
    pub(crate) fn structured_domain(&self, of: Type) -> Domain {
        let span = of.span;
        let text = self.text.get(span.range()).unwrap_or("");
        let name = NameText {
            text: text.into(),
            span,
        };
        Domain {
            name,
            kind: DomainKind::Structured(of),
            dynamic: false,
            span,
        }
    }

    /// Builds a function. `mapping` holds the codomain first if there is no domain.
    pub(crate) fn function(
        &self,
        start: usize,
        kind: FunctionKind,
        name: NameText,
        mapping: (Type, Option<Type>),
        end: usize,
    ) -> Function {
        let (domain, codomain) = match mapping {
            (codomain, None) => (None, codomain),
            (domain, Some(codomain)) => (Some(domain), codomain),
        };
        Function {
            name,
            kind,
            domain,
            codomain,
            span: self.span(start, end),
        }
    }

    /// Reports a rule name without the prefix `r_`, and adds the prefix.
    pub(crate) fn rule_name_without_prefix(&self, name: NameText) -> NameText {
        let better = format!("r_{}", name.text);
        self.findings.report(Misnamed {
            what: "a rule",
            beginning: "`r_`",
            found: (name.text.to_string(), name.span),
            better: Some(better.clone()),
        });
        NameText {
            text: better.into(),
            span: name.span,
        }
    }

    pub(crate) fn property(
        &self,
        start: usize,
        (name, kind): (Option<NameText>, PropertyKind),
        end: usize,
    ) -> Property {
        Property {
            name,
            kind,
            span: self.span(start, end),
        }
    }

    /// Builds the name of a property. AsmetaS requires a certain prefix for each kind.
    pub(crate) fn property_name(
        &self,
        prefix: &'static str,
        name: Option<NameText>,
    ) -> Option<NameText> {
        if let Some(name) = name.as_ref().filter(|name| !name.text.starts_with(prefix)) {
            self.findings.report(PropertyPrefix {
                prefix,
                name: name.text.to_string(),
                at: name.span,
            });
        }
        name
    }

    // ── names and spans ──

    pub(crate) fn name(&self, start: usize, text: &str, end: usize) -> NameText {
        NameText {
            text: Arc::from(text),
            span: self.span(start, end),
        }
    }

    /// Builds a span; called for each node, so it also records progress of the parser.
    pub(crate) fn span(&self, start: usize, end: usize) -> Span {
        self.findings.node_built();
        self.findings.span(start, end)
    }

    // ── errors caught by the grammar ──

    /// Builds an item that could not be parsed.
    pub(crate) fn broken_item(&self, start: usize, caught: Caught<'input>, end: usize) -> Item {
        self.explain(&caught.error, start, end);
        Item::Broken(self.span(start, end))
    }

    /// Builds a rule that could not be parsed.
    pub(crate) fn broken_rule(&self, start: usize, caught: Caught<'input>, end: usize) -> RuleKind {
        self.explain(&caught.error, start, end);
        RuleKind::Invalid
    }

    /// Builds a term that could not be parsed.
    pub(crate) fn broken_term(&self, start: usize, caught: Caught<'input>, end: usize) -> TermKind {
        self.explain(&caught.error, start, end);
        TermKind::Invalid
    }

    /// Builds the file for a text that the parser has given up.
    pub(crate) fn unread(&self, failure: &ParserError<'_>) -> File {
        self.explain(failure, 0, self.text.len());
        empty_file()
    }

    /// Reports an error for which the parser has skipped the text from `start` to `end`.
    pub(crate) fn explain(&self, failure: &ParserError<'_>, start: usize, end: usize) {
        self.explainer.borrow_mut().explain(failure, start, end);
    }
}
