//! Strings and characters.

use super::{Lexer, Token, TokenLength};
use crate::codes::l004::OpenQuote;

impl<'input> Lexer<'input, '_> {
    /// Reads the text between two quotes, keeping escapes as written. A backslash protects the
    /// character after it from ending the text.
    pub(super) fn quoted(
        &self,
        quote: char,
        token: fn(&'input str) -> Token<'input>,
    ) -> TokenLength<'input> {
        let quote_length = quote.len_utf8();
        let inside = self.from(self.position + quote_length);
        let mut escaped = false;
        let end = inside.find(|c| {
            let ends = (c == quote && !escaped) || c == '\n' || c == '\r';
            escaped = c == '\\' && !escaped;
            ends
        });
        let text = inside.get(..end.unwrap_or(inside.len())).unwrap_or(inside);
        let closed = inside
            .get(text.len()..)
            .is_some_and(|rest| rest.starts_with(quote));
        let length = quote_length + text.len();
        if closed {
            return (token(text), length + quote_length);
        }
        self.findings.report(OpenQuote {
            quote,
            open: self.next_bytes(length),
        });
        (token(text), length)
    }
}

/// Returns the single character between quotes; `None` if there are none or several.
pub(crate) fn character(text: &str) -> Option<char> {
    let Some(escape) = text.strip_prefix('\\') else {
        return only(text);
    };
    match only(escape) {
        Some('n') => Some('\n'),
        Some('t') => Some('\t'),
        Some('r') => Some('\r'),
        Some('b') => Some('\u{8}'),
        Some('f') => Some('\u{c}'),
        Some(quote @ ('\'' | '"' | '\\')) => Some(quote),
        _ => u8::from_str_radix(escape, 8).ok().map(char::from),
    }
}

fn only(text: &str) -> Option<char> {
    let mut characters = text.chars();
    characters.next().filter(|_| characters.next().is_none())
}
