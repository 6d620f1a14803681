//! Parsing of single terms and rules, as in scenarios, prompts and scripts.

use crate::ast;
use crate::codes::l063::NotAnAssignment;
use crate::explain::Explainer;
use crate::findings::SyntaxFindings;
use crate::lexer::TextKind;
use crate::nesting::NestedTokens;
use crate::node::{Nodes, ParsedText};
use crate::parse::{never, read};
use asmotion_diagnostics::{FileId, Finding, Report};
use std::ops::Range;

/// Parses a term.
///
/// # Errors
/// The text is not exactly one term.
pub fn parse_term(file: FileId, text: &str) -> Result<ast::Term, Report> {
    parse_term_in(file, text, 0..text.len())
}

/// Parses a term in a range of a text.
///
/// # Errors
/// The range is not exactly one term.
pub fn parse_term_in(file: FileId, text: &str, part: Range<usize>) -> Result<ast::Term, Report> {
    parse(file, text, part, TextKind::Term, |parsed| match parsed {
        ParsedText::Term(term) => Some(term),
        ParsedText::File(_) | ParsedText::Rule(_) => None,
    })
}

/// Parses a rule.
///
/// # Errors
/// The text is not exactly one rule.
pub fn parse_rule(file: FileId, text: &str) -> Result<ast::Rule, Report> {
    parse_rule_in(file, text, 0..text.len())
}

/// Parses a rule in a range of a text.
///
/// # Errors
/// The range is not exactly one rule.
pub fn parse_rule_in(file: FileId, text: &str, part: Range<usize>) -> Result<ast::Rule, Report> {
    parse(file, text, part, TextKind::Rule, |parsed| match parsed {
        ParsedText::Rule(rule) => Some(rule),
        ParsedText::File(_) | ParsedText::Term(_) => None,
    })
}

/// Parses `location := term`.
///
/// # Errors
/// The text is not exactly one assignment.
pub fn parse_assignment(file: FileId, text: &str) -> Result<(ast::Assignee, ast::Term), Report> {
    parse_assignment_in(file, text, 0..text.len())
}

/// Parses `location := term` in a range of a text.
///
/// # Errors
/// The range is not exactly one assignment.
pub fn parse_assignment_in(
    file: FileId,
    text: &str,
    part: Range<usize>,
) -> Result<(ast::Assignee, ast::Term), Report> {
    let rule = parse_rule_in(file, text, part)?;
    if let ast::RuleKind::Update { target, value } = *rule.kind {
        return Ok((target, value));
    }
    let mut report = Report::new();
    report.push(NotAnAssignment { at: rule.span }.diagnostic());
    Err(report)
}

fn parse<T>(
    file: FileId,
    text: &str,
    part: Range<usize>,
    kind: TextKind,
    of_kind: impl FnOnce(ParsedText) -> Option<T>,
) -> Result<T, Report> {
    let text = text.get(..part.end).unwrap_or(text);
    let (findings, unheard) = (SyntaxFindings::new(file), SyntaxFindings::new(file));
    let explainer = Explainer::new(text, &findings, &unheard).starting_at(part.start);
    let nodes = Nodes::new(text, &findings, explainer);
    let mut tokens = NestedTokens::new(text, &findings);
    tokens.lexer.start_at(part.start);
    tokens.lexer.names_elements = true;
    let parsed = read(kind, part.start, &nodes, tokens);
    let parsed = parsed.and_then(|parsed| of_kind(parsed).ok_or_else(|| never(part.start)));
    if let Err(failure) = &parsed {
        nodes.explain(failure, part.start, text.len());
    }
    let report = findings.finish();
    match parsed {
        Ok(fragment) if !report.has_errors() => Ok(fragment),
        _ => Err(report),
    }
}
