//! The lexer: produces tokens one at a time and never fails; invalid characters are reported and
//! skipped.

mod comment;
mod number;
mod quoted;
mod sign;
mod token;
mod word;

pub(crate) use number::complex_parts;
pub(crate) use quoted::character;
pub(crate) use token::{Keyword, Sign, TextKind, Token};
pub(crate) use word::length as word_length;

use crate::ast::Annotation;
use crate::codes::l001::UnknownCharacters;
use crate::codes::l010::StraySemicolon;
use crate::findings::SyntaxFindings;
use asmotion_diagnostics::Span;

/// A token with the offsets of its first byte and of the byte after its last.
pub(crate) type SpannedToken<'input> = (usize, Token<'input>, usize);

/// A token with its length in bytes.
type TokenLength<'input> = (Token<'input>, usize);

/// Splits a text into tokens.
#[derive(Debug)]
pub(crate) struct Lexer<'input, 'run> {
    text: &'input str,
    findings: &'run SyntaxFindings,
    /// Offset from which the next token is read.
    position: usize,
    /// The last token, on which the reading of paths, names and signs depends.
    previous: Option<Token<'input>>,
    /// `true` within `<<…`, where `>>` is one token; elsewhere it closes two bags.
    in_rule_reference: bool,
    /// `true` to accept names of elements, such as `person!1`.
    pub(crate) names_elements: bool,
    /// The `//@…` comments read so far.
    pub(crate) annotations: Vec<Annotation>,
}

impl<'input, 'run> Lexer<'input, 'run> {
    /// Creates a lexer at the first character, after a byte order mark.
    pub(crate) fn new(text: &'input str, findings: &'run SyntaxFindings) -> Self {
        const BYTE_ORDER_MARK: char = '\u{feff}';
        Self {
            text,
            findings,
            position: if text.starts_with(BYTE_ORDER_MARK) {
                BYTE_ORDER_MARK.len_utf8()
            } else {
                0
            },
            previous: None,
            in_rule_reference: false,
            names_elements: false,
            annotations: Vec::new(),
        }
    }

    /// Skips the text before an offset, which must be the beginning of a token.
    pub(crate) fn start_at(&mut self, start: usize) {
        self.position = self.position.max(start);
    }

    /// Returns the offset from which the next token is read.
    pub(crate) fn position(&self) -> usize {
        self.position
    }

    /// Skips one token or invalid character; returns `false` at the end of the text.
    pub(crate) fn pass(&mut self) -> bool {
        let Some(next) = self.rest().chars().next() else {
            return false;
        };
        let length = self.read().map_or(next.len_utf8(), |(_, length)| length);
        self.position += length.max(1);
        true
    }

    /// Reads the token at the current position, if there is one.
    fn read(&mut self) -> Option<TokenLength<'input>> {
        if self.previous == Some(Token::Keyword(Keyword::Import))
            && let Some(path) = self.path()
        {
            return Some(path);
        }
        match self.rest().chars().next()? {
            '"' => Some(self.quoted('"', Token::Text)),
            '\'' => Some(self.quoted('\'', Token::Char)),
            '$' => self.variable(),
            '0'..='9' => Some(self.number()),
            first if word::begins(first) => Some(self.word()),
            _ => self.sign(),
        }
    }

    /// Reports a run of invalid characters once, and skips it.
    fn skip_unknown(&mut self) {
        let rest = self.rest();
        let length = rest.find(|c| !is_unknown(c)).unwrap_or(rest.len());
        // a character that is valid only in combination, such as `$`, stands alone here
        let length = length.max(rest.chars().next().map_or(0, char::len_utf8));
        let at = self.next_bytes(length);
        let characters: String = self.from(self.position).get(..length).unwrap_or("").into();
        match characters.as_str() {
            ";" => self.findings.report(StraySemicolon { at }),
            _ => self.findings.report(UnknownCharacters { characters, at }),
        }
        self.position += length;
    }

    /// Returns the remaining text.
    pub(crate) fn rest(&self) -> &'input str {
        self.from(self.position)
    }

    fn from(&self, start: usize) -> &'input str {
        self.text.get(start..).unwrap_or("")
    }

    fn next_bytes(&self, length: usize) -> Span {
        self.findings.span(self.position, self.position + length)
    }
}

impl<'input> Iterator for Lexer<'input, '_> {
    type Item = SpannedToken<'input>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            self.blanks_and_comments();
            if self.rest().is_empty() {
                return None;
            }
            if self.skip_unneeded_end() {
                continue;
            }
            if let Some((token, length)) = self.read() {
                let start = self.position;
                self.position += length;
                self.previous = Some(token);
                return Some((start, token, self.position));
            }
            self.skip_unknown();
        }
    }
}

/// Returns `true` if no token can begin with this character.
fn is_unknown(c: char) -> bool {
    let begins_token = c.is_whitespace() || c.is_ascii_digit() || "\"'$;".contains(c);
    !begins_token && !word::begins(c) && !sign::begins(c)
}
