//! Why the parser stopped, in the user's words.
//!
//! The parser knows a token and the tokens it would rather have seen. A second look at the text up
//! to there tells what was open; both together tell a mistake from its traces.

mod block;
mod expected;
mod name;
mod sign;
mod word;

use crate::codes::l009::ForeignSign;
use crate::codes::l030::FileCutOff;
use crate::codes::l031::UnclosedBlock;
use crate::codes::l032::UnclosedElseIf;
use crate::codes::l033::ClosesNothing;
use crate::codes::l034::SeveralRules;
use crate::codes::l035::MissingRule;
use crate::codes::l054::ReservedName;
use crate::codes::l058::UnexpectedToken;
use crate::edits::SpannedText;
use crate::findings::SyntaxFindings;
use crate::lexer::{Keyword, Lexer, SpannedToken, Token};
use crate::nesting::{Nesting, OpenConstruct, closer};
use asmotion_diagnostics::{Diagnostic, Finding, Span};
use expected::Expected;
use lalrpop_util::ParseError;
use std::convert::Infallible;

/// An error as the parser found it.
pub(crate) type ParserError<'input> = ParseError<usize, Token<'input>, Infallible>;

/// So many bytes count as one line at most.
const LINE: usize = 1000;

/// So many characters of a token are shown at most.
const SHOWN: usize = 40;

/// Follows the parser from error to error.
#[derive(Debug)]
pub(crate) struct Explainer<'input, 'run> {
    text: &'input str,
    findings: &'run SyntaxFindings,
    lexer: Lexer<'input, 'run>,
    /// The token that is looked at.
    found: Option<SpannedToken<'input>>,
    /// What is open before it.
    nesting: Nesting<'input>,
    /// Where the third last token before it begins.
    recent: [usize; 3],
    last: Option<LastError>,
}

/// The error explained last.
#[derive(Clone, Copy, Debug)]
struct LastError {
    at: usize,
    /// Where reading went on.
    resumed: usize,
    /// Whether the word there was meant otherwise than the grammar takes it.
    misused: bool,
}

impl<'input, 'run> Explainer<'input, 'run> {
    /// Reads `text` a second time; what its tokens are blamed for goes to `unheard`.
    pub(crate) fn new(
        text: &'input str,
        findings: &'run SyntaxFindings,
        unheard: &'run SyntaxFindings,
    ) -> Self {
        let mut lexer = Lexer::new(text, unheard);
        let found = lexer.next();
        let nesting = Nesting::new(text);
        Self {
            text,
            findings,
            lexer,
            found,
            nesting,
            recent: [0; 3],
            last: None,
        }
    }

    /// Leaves out what stands before a place.
    pub(crate) fn starting_at(mut self, start: usize) -> Self {
        self.lexer.start_at(start);
        if self.found.is_some_and(|(from, _, _)| from < start) {
            self.found = self.lexer.next();
        }
        self.recent = [start; 3];
        self
    }

    /// Reports an error, unless it only follows from one before. What the parser gave up for it
    /// reaches from `start` to `resumed`.
    pub(crate) fn explain(&mut self, failure: &ParserError<'_>, start: usize, resumed: usize) {
        let (from, to, expected) = match failure {
            ParseError::UnrecognizedToken {
                token: (from, _, to),
                expected,
            } => (*from, *to, Expected::new(expected)),
            ParseError::UnrecognizedEof { location, expected } => {
                (*location, *location, Expected::new(expected))
            }
            // A grammar that reads to the end of the text has none of these.
            ParseError::ExtraToken {
                token: (from, _, to),
            } => (*from, *to, Expected::default()),
            ParseError::InvalidToken { location } => (*location, *location, Expected::default()),
            ParseError::User { error } => match *error {},
        };
        let at = self.findings.span(from, to);
        self.findings.caught(at);
        self.advance(if from < to { from } else { self.text.len() });
        let error = match self.found {
            Some(found) => self.at_token(found, &expected),
            None => self.at_end(at, &expected),
        };
        let misused = error.is_any(&[ReservedName::CODE, ForeignSign::CODE]);
        if !self.follows(&error, start, from) {
            if error.is_any(&[UnclosedBlock::CODE, FileCutOff::CODE]) {
                // What looked like several rules is the inside of what was not closed.
                self.findings.retract(SeveralRules::CODE, start);
            }
            self.findings.add(error);
        }
        self.last = Some(LastError {
            at: from,
            resumed: resumed.max(to),
            misused,
        });
    }

    /// Looks at the token that begins at `offset`.
    fn advance(&mut self, offset: usize) {
        while let Some(before) = self.found.filter(|(start, ..)| *start < offset) {
            self.nesting.step(before);
            let [_, second, third] = self.recent;
            self.recent = [second, third, before.0];
            self.found = self.lexer.next();
        }
    }

    /// Whether the error is but a trace of one before: in the same declaration, and near it, or
    /// around it, or an end whose beginning was lost.
    fn follows(&self, error: &Diagnostic, start: usize, found: usize) -> bool {
        let declaration = self.declared_from();
        let line = self.line_start(found).max(declaration);
        if self.findings.error_between(line, found) {
            return true;
        }
        let Some(last) = self.last.filter(|last| last.at >= declaration) else {
            return false;
        };
        let [third_last, ..] = self.recent;
        let near = third_last <= last.resumed || line <= last.resumed;
        let around = start <= last.at;
        let lost = error.is_any(&[ClosesNothing::CODE, MissingRule::CODE]);
        near || around || lost
    }

    /// Where the errors of the current declaration begin. One at its first word belongs to the
    /// declaration before, except where that word was meant otherwise.
    fn declared_from(&self) -> usize {
        let misused = |start| {
            self.last
                .is_some_and(|last| last.misused && last.at == start)
        };
        match self.nesting.declaration() {
            Some((start, _, _)) if misused(start) => start,
            Some((_, _, end)) => end,
            None => 0,
        }
    }

    fn line_start(&self, offset: usize) -> usize {
        let line = self
            .text
            .as_bytes()
            .get(offset.saturating_sub(LINE)..offset)
            .unwrap_or(&[]);
        offset - line.iter().rev().take_while(|&&byte| byte != b'\n').count()
    }

    // ── at the end of the text ──

    fn at_end(&self, at: Span, expected: &Expected<'_>) -> Diagnostic {
        let open = self.missing_end(expected);
        if let Some((open, _)) = &open
            && let Some(inner) = open.else_if
        {
            let (outer, inner) = (self.span(open.opener), self.span(inner));
            return UnclosedElseIf { at, outer, inner }.diagnostic();
        }
        let missing = open.map_or(expected.to_string(), |(_, end)| format!("`{end}`"));
        let open = self.nesting.open().take(3);
        let open = open.map(|open| self.place(open.opener)).collect();
        FileCutOff { missing, at, open }.diagnostic()
    }

    // ── at a token ──

    /// The first explanation that fits, from the most particular to the most general.
    fn at_token(&self, found: SpannedToken<'input>, expected: &Expected<'_>) -> Diagnostic {
        let explanations: [Explanation<'input, 'run>; _] = [
            Self::unused_word,
            Self::wrong_sign,
            Self::misspelled_word,
            Self::missing_heading,
            Self::missing_function,
            Self::several_rules,
            Self::unclosed,
            Self::closes_nothing,
            Self::missing_word,
            Self::complex_name,
            Self::wrong_name,
            Self::missing_rule,
            Self::call_without_brackets,
            Self::bare_quantifier,
        ];
        explanations
            .iter()
            .find_map(|explain| explain(self, found, expected))
            .unwrap_or_else(|| self.unexpected(found, expected))
    }

    /// What can always be said.
    fn unexpected(&self, found: SpannedToken<'input>, expected: &Expected<'_>) -> Diagnostic {
        let before = self.nesting.previous.filter(|_| self.begins_line(found));
        UnexpectedToken {
            what: expected.to_string(),
            found: self.place(found),
            after: before.map(|before| self.place(before)),
            open: self
                .missing_end(expected)
                .map(|(open, _)| self.place(open.opener)),
        }
        .diagnostic()
    }

    // ── what all of them ask ──

    /// What is open innermost and its end, if the end may stand here.
    fn missing_end(&self, expected: &Expected<'_>) -> Option<(&OpenConstruct<'input>, String)> {
        let open = self.nesting.open().next()?;
        let end = closer(open.opener.1)?.to_string();
        expected.has(&end).then_some((open, end))
    }

    /// Whether the current declaration begins with one of these words.
    fn declares(&self, words: &[Keyword]) -> bool {
        let Some((_, Token::Keyword(word), _)) = self.nesting.declaration() else {
            return false;
        };
        words.contains(&word)
    }

    /// What stands behind a token, blanks left out.
    fn behind(&self, (_, _, end): SpannedToken<'_>) -> &'input str {
        self.text.get(end..).unwrap_or("").trim_start()
    }

    /// Whether a token is the first of its line.
    fn begins_line(&self, (start, ..): SpannedToken<'_>) -> bool {
        let between = self.nesting.previous.map_or(0, |(_, _, end)| end)..start;
        self.text
            .get(between)
            .is_some_and(|between| between.contains('\n'))
    }

    fn span(&self, (start, _, end): SpannedToken<'_>) -> Span {
        self.findings.span(start, end)
    }

    fn place(&self, token: SpannedToken<'_>) -> SpannedText {
        let text = self.text.get(token.0..token.2).unwrap_or("");
        let shown = match text.char_indices().nth(SHOWN) {
            Some((end, _)) => format!("{}…", text.get(..end).unwrap_or("")),
            None => text.to_owned(),
        };
        (shown, self.span(token))
    }
}

/// Explains some errors at a token.
type Explanation<'input, 'run> =
    fn(&Explainer<'input, 'run>, SpannedToken<'input>, &Expected<'_>) -> Option<Diagnostic>;
