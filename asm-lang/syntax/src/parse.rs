//! Parsing of files.

use crate::ast::File;
use crate::explain::{Explainer, ParserError};
use crate::findings::SyntaxFindings;
use crate::grammar::ParsedTextParser;
use crate::lexer::{SpannedToken, TextKind, Token};
use crate::nesting::NestedTokens;
use crate::node::{Nodes, ParsedText};
use asmotion_diagnostics::{FileId, Report};
use std::iter;

/// A parsed file with its report.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The tree; parts that could not be parsed are `Invalid`.
    pub file: File,
    /// Errors and warnings, sorted by position.
    pub report: Report,
}

/// Parses a file.
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

/// Runs the parser on the tokens of a text from `start` on.
pub(crate) fn read<'input, 'run>(
    kind: TextKind,
    start: usize,
    nodes: &Nodes<'input, 'run>,
    tokens: impl Iterator<Item = SpannedToken<'input>>,
) -> Result<ParsedText, ParserError<'input>> {
    let first = (start, Token::Start(kind), start);
    ParsedTextParser::new().parse(nodes, iter::once(first).chain(tokens))
}

/// Returns the failure for a text parsed with the wrong start symbol, which the grammar rules out.
pub(crate) fn never(at: usize) -> ParserError<'static> {
    ParserError::InvalidToken { location: at }
}
