//! Trees back to text: the one layout every specification has.
//!
//! The tree says where lines may end; words, signs and comments come from the text itself, one after
//! the other, so that nothing is lost and nothing is put elsewhere.

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

/// A line is as wide as this at most, where it can be.
const WIDTH: usize = 100;

/// A level of indentation: one tab, measured as four blanks.
const INDENT: usize = 4;

/// The text of a specification in canonical layout.
///
/// # Errors
/// The text has errors: it stays as it is.
pub fn format(file: FileId, text: &str) -> Result<String, Report> {
    let unix = unix(text);
    let parsed = parse(file, text);
    if parsed.report.has_errors() {
        return Err(parsed.report);
    }
    // The places in the tree are those of the text that is printed.
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

/// The text of a scenario in canonical layout.
///
/// # Errors
/// The text has errors: it stays as it is.
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

/// With line ends as the printer knows them.
fn unix(text: &str) -> Cow<'_, str> {
    match text.contains('\r') {
        true => text.replace("\r\n", "\n").replace('\r', "\n").into(),
        false => text.into(),
    }
}
