//! The formatter: prints specifications and scenarios in their canonical layout.
//!
//! The tree determines where lines may be broken. Words, signs and comments are taken from the
//! source text in order, so that nothing is lost or moved.

mod branch;
mod comments;
mod file;
mod layout;
mod list;
mod operator;
mod rule;
mod scenario;
mod term;
mod trivia;

use crate::parse::parse;
use crate::scenario::parse_scenario;
use asmotion_diagnostics::{FileId, Report};
use layout::TokenLayout;
use pretty::Arena;
use std::borrow::Cow;
use trivia::TriviaTokens;

/// Maximum width of a line in characters, exceeded only where no break is possible.
const WIDTH: usize = 100;

/// Width of an indentation level in characters; written as one tab.
const INDENT: usize = 4;

/// Formats a specification in canonical layout.
///
/// # Errors
/// The text has errors and is not formatted.
pub fn format(file: FileId, text: &str) -> Result<String, Report> {
    let unix = unix(text);
    let parsed = parse(file, text);
    if parsed.report.has_errors() {
        return Err(parsed.report);
    }
    // reparse, because the spans of the tree must refer to the text that is printed
    let tree = if unix == text {
        parsed
    } else {
        parse(file, &unix)
    }
    .file;
    let arena = Arena::new();
    let mut layout = TokenLayout::new(&arena, TriviaTokens::of_file(&unix));
    layout.file(&tree);
    Ok(layout.finish())
}

/// Formats a scenario in canonical layout.
///
/// # Errors
/// The text has errors and is not formatted.
pub fn format_scenario(file: FileId, text: &str) -> Result<String, Report> {
    let (_, report) = parse_scenario(file, text);
    if report.has_errors() {
        return Err(report);
    }
    let unix = scenario::with_ends(file, &unix(text));
    let (tree, _) = parse_scenario(file, &unix);
    let arena = Arena::new();
    let tokens = scenario::tokens(&unix, &tree);
    let mut layout = TokenLayout::new(&arena, TriviaTokens::new(&unix, tokens));
    layout.scenario(&tree);
    Ok(layout.finish())
}

/// Converts line ends to `\n`.
fn unix(text: &str) -> Cow<'_, str> {
    if text.contains('\r') {
        text.replace("\r\n", "\n").replace('\r', "\n").into()
    } else {
        text.into()
    }
}
