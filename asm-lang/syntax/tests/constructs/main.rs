//! One test for each construct of the language: a text and its expected tree.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

mod declarations;
mod files;
mod rules;
mod single_rules;
mod single_terms;
mod terms;
#[path = "../shared/tree.rs"]
mod tree;

use asmotion_diagnostics::FileId;
use asmotion_syntax::ast::{Rule, Term};
use asmotion_syntax::{parse, parse_term};

#[track_caller]
fn term(text: &str, expected: &str) {
    let term: Term = parse_term(FileId(0), text).unwrap_or_else(|report| panic!("{report:#?}"));
    assert_eq!(tree::term(&term), expected, "{text}");
    assert_eq!(term.span.range(), 0..text.len(), "the span of {text}");
}

#[track_caller]
fn rule(text: &str, expected: &str) {
    assert_eq!(tree::rule(&read_rule(text)), expected, "{text}");
}

#[track_caller]
fn read_rule(text: &str) -> Rule {
    let file = format!("asm a\nsignature:\ndefinitions:\n  main rule r_Main = {text}\n");
    let parsed = parse(FileId(0), &file);
    assert!(!parsed.report.has_errors(), "{:#?}", parsed.report);
    parsed.file.main.unwrap().body
}

#[track_caller]
fn file(text: &str, expected: &str) {
    let parsed = parse(FileId(0), text);
    assert!(!parsed.report.has_errors(), "{:#?}", parsed.report);
    assert_eq!(tree::file(&parsed.file), expected.trim());
}

/// Checks the tree of a declaration in the signature.
#[track_caller]
fn declared(text: &str, expected: &str) {
    file(
        &format!("asm a signature: {text} definitions:"),
        &format!("asm a\n{expected}"),
    );
}

/// Checks the tree of an item in the definitions.
#[track_caller]
fn defined(text: &str, expected: &str) {
    file(
        &format!("asm a signature: definitions: {text}"),
        &format!("asm a\n{expected}"),
    );
}
