//! A file as a tree.

use crate::ast::File;
use crate::explain::{Explainer, ParserError};
use crate::findings::SyntaxFindings;
use crate::grammar::ParsedTextParser;
use crate::lexer::{SpannedToken, TextKind, Token};
use crate::nesting::NestedTokens;
use crate::node::{Nodes, ParsedText};
use asmotion_diagnostics::{FileId, Report};
use std::iter;

/// A file's tree, and what was wrong with its text.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The tree; parts that could not be read are `Invalid`.
    pub file: File,
    /// Errors and warnings.
    pub report: Report,
}

/// Reads a file.
pub fn parse(file: FileId, text: &str) -> Parsed {
    let (findings, unheard) = (SyntaxFindings::new(file), SyntaxFindings::new(file));
    let nodes = Nodes::new(text, &findings, Explainer::new(text, &findings, &unheard));
    let mut tokens = NestedTokens::new(text, &findings);
    let mut tree = match read(TextKind::File, 0, &nodes, tokens.by_ref()) {
        Ok(ParsedText::File(tree)) => tree,
        Ok(ParsedText::Rule(_) | ParsedText::Term(_)) => nodes.unread(&never(0)),
        Err(failure) => nodes.unread(&failure),
    };
    tree.annotations = tokens.lexer.annotations;
    Parsed {
        file: tree,
        report: findings.finish(),
    }
}

/// Runs the parser over the tokens of a text, of which the first begins at `start` or later.
pub(crate) fn read<'input, 'run>(
    kind: TextKind,
    start: usize,
    nodes: &Nodes<'input, 'run>,
    tokens: impl Iterator<Item = SpannedToken<'input>>,
) -> Result<ParsedText, ParserError<'input>> {
    let first = (start, Token::Start(kind), start);
    ParsedTextParser::new().parse(nodes, iter::once(first).chain(tokens))
}

/// The failure of a text that was read as another kind than it was to be; the grammar excludes it.
pub(crate) fn never(at: usize) -> ParserError<'static> {
    ParserError::InvalidToken { location: at }
}
