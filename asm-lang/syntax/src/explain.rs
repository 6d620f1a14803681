//! Explanations of syntax errors.
//!
//! The parser reports a token and the tokens that it would have accepted. The explainer reads the
//! text up to that token once more and records which constructs are open. Both together distinguish
//! an error from its consequences.

mod binding;
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
use crate::nesting::{Nesting, OpenConstruct, closer, continues};
use asmotion_diagnostics::{Diagnostic, Finding, Span};
use expected::Expected;
use lalrpop_util::ParseError;
use std::convert::Infallible;

/// An error reported by the parser.
pub(crate) type ParserError<'input> = ParseError<usize, Token<'input>, Infallible>;

/// Limit for the length of a line in bytes when errors are compared by line.
const LINE: usize = 1000;

/// Limit for the number of characters of a token shown in a message.
const SHOWN: usize = 40;

/// Follows the parser through the text, from error to error.
#[derive(Debug)]
pub(crate) struct Explainer<'input, 'run> {
    text: &'input str,
    findings: &'run SyntaxFindings,
    lexer: Lexer<'input, 'run>,
    found: Option<SpannedToken<'input>>,
    /// The constructs that are open before it.
    nesting: Nesting<'input>,
    /// Offsets of the last three tokens before it, oldest first.
    recent: [usize; 3],
    last: Option<LastError>,
}

/// The error explained last.
#[derive(Clone, Copy, Debug)]
struct LastError {
    at: usize,
    /// Offset at which the parser continued.
    resumed: usize,
    /// `true` if the user probably meant the word differently from the grammar.
    misused: bool,
}

impl<'input, 'run> Explainer<'input, 'run> {
    /// Creates an explainer that reads `text` a second time. The lexer's findings go to `unheard`,
    /// because they were already reported the first time.
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

    /// Skips the text before an offset.
    pub(crate) fn starting_at(mut self, start: usize) -> Self {
        self.lexer.start_at(start);
        if self.found.is_some_and(|(from, _, _)| from < start) {
            self.found = self.lexer.next();
        }
        self.recent = [start; 3];
        self
    }

    /// Reports an error unless it is a consequence of an earlier one. The parser has skipped the
    /// text from `start` to `resumed`.
    pub(crate) fn explain(&mut self, failure: &ParserError<'_>, start: usize, resumed: usize) {
        let (from, to, expected) = match failure {
            ParseError::UnrecognizedToken {
                token: (from, _, to),
                expected,
            } => (*from, *to, Expected::new(expected)),
            ParseError::UnrecognizedEof { location, expected } => {
                (*location, *location, Expected::new(expected))
            }
            // never produced by a grammar that reads to the end of the text
            ParseError::ExtraToken {
                token: (from, _, to),
            } => (*from, *to, Expected::default()),
            ParseError::InvalidToken { location } => (*location, *location, Expected::default()),
            ParseError::User { error } => match *error {},
        };
        let at = self.findings.span(from, to);
        self.findings.count_error(at);
        self.advance(if from < to { from } else { self.text.len() });
        let error = match self.found {
            Some(found) => self.at_token(found, &expected),
            None => self.at_end(at, &expected),
        };
        let misused = error.is_any(&[ReservedName::CODE, ForeignSign::CODE]);
        if !self.follows(&error, start, from) {
            if error.is_any(&[UnclosedBlock::CODE, FileCutOff::CODE]) {
                // the supposed several rules are the contents of the unclosed construct
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

    /// Advances to the token that begins at `offset`.
    fn advance(&mut self, offset: usize) {
        while let Some(before) = self.found.filter(|(start, ..)| *start < offset) {
            self.nesting.step(before);
            let [_, second, third] = self.recent;
            self.recent = [second, third, before.0];
            self.found = self.lexer.next();
        }
    }

    /// Returns `true` if an error is a consequence of an earlier one: it is in the same declaration
    /// and close to it, it encloses it, or it is a closing token whose opening one was skipped.
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
        let is_near = third_last <= last.resumed || line <= last.resumed;
        let around = start <= last.at;
        let lost = error.is_any(&[ClosesNothing::CODE, MissingRule::CODE]);
        is_near || around || lost || self.continues_lost(last)
    }

    /// Returns `true` if the token found continues or closes a construct that the parser has left because of an earlier error
    /// within it.
    fn continues_lost(&self, last: LastError) -> bool {
        let (Some((_, found, _)), Some(open)) = (self.found, self.nesting.open().next()) else {
            return false;
        };
        let (begun, opener, _) = open.opener;
        begun < last.resumed && (closer(opener) == Some(found) || continues(opener, found))
    }

    /// Returns the offset from which errors belong to the current declaration. An error at its
    /// first word belongs to the previous one, unless the user meant that word differently.
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

    /// Returns the first explanation that applies, from the most specific to the most general.
    fn at_token(&self, found: SpannedToken<'input>, expected: &Expected<'_>) -> Diagnostic {
        let explanations: [Explanation<'input, 'run>; _] = [
            Self::missing_element,
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

    /// The most general explanation, which always applies.
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

    // ── shared by the explanations ──

    /// Returns the innermost open construct with its closing token, if that token may follow here.
    fn missing_end(&self, expected: &Expected<'_>) -> Option<(&OpenConstruct<'input>, String)> {
        let open = self.nesting.open().next()?;
        let end = closer(open.opener.1)?.to_string();
        expected.has(&end).then_some((open, end))
    }

    /// Returns `true` if the current declaration begins with one of these keywords.
    fn declares(&self, words: &[Keyword]) -> bool {
        let Some((_, Token::Keyword(word), _)) = self.nesting.declaration() else {
            return false;
        };
        words.contains(&word)
    }

    /// Returns the text after a token, without leading blanks.
    fn behind(&self, (_, _, end): SpannedToken<'_>) -> &'input str {
        self.text.get(end..).unwrap_or("").trim_start()
    }

    /// Returns `true` if a token is the first of its line.
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

/// An explanation for certain errors at a token; `None` if it does not apply.
type Explanation<'input, 'run> =
    fn(&Explainer<'input, 'run>, SpannedToken<'input>, &Expected<'_>) -> Option<Diagnostic>;
