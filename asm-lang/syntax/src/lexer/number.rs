//! Numbers, including complex ones.

use super::{Lexer, Token, TokenLength, word};
use crate::codes::l007::ExponentInNumber;
use crate::codes::l008::BarePoint;

impl<'input> Lexer<'input, '_> {
    pub(super) fn number(&self) -> TokenLength<'input> {
        let (token, length) = read(self.rest());
        if let Token::Real(digits) = token {
            let (number, at) = (digits.to_owned(), self.next_bytes(length));
            if digits.ends_with('.') {
                self.findings.report(BarePoint { number, at });
            } else if digits.contains(['e', 'E']) {
                self.findings.report(ExponentInNumber { number, at });
            }
        }
        (token, length)
    }
}

/// Reads the number at the beginning of `text`; returns it with its length.
///
/// `1..3` is an interval in the old notation. A dot therefore belongs to the number only before a
/// digit, or where it cannot have another meaning.
fn read(text: &str) -> TokenLength<'_> {
    if let Some(length) = complex_length(text) {
        return (Token::Complex(text.get(..length).unwrap_or(text)), length);
    }
    let whole = digits(text);
    let real = real_length(text);
    let real = real + exponent_length(text.get(real..).unwrap_or(""));
    let after = text.get(whole..).unwrap_or("");
    if real > whole {
        (Token::Real(text.get(..real).unwrap_or(text)), real)
    } else if after.starts_with('n') && word_ends(after.get(1..)) {
        (Token::Natural(text.get(..whole).unwrap_or(text)), whole + 1)
    } else if after.starts_with('.') && !after.starts_with("..") {
        (Token::Real(text.get(..=whole).unwrap_or(text)), whole + 1)
    } else {
        (Token::Integer(text.get(..whole).unwrap_or(text)), whole)
    }
}

/// Returns the length of the complex number at the beginning of `text`: an optional sign, a real
/// part, a sign, an imaginary part. Either part may be missing, but not both.
///
/// No letter may follow the imaginary part: `5+index` is a sum.
pub(super) fn complex_length(text: &str) -> Option<usize> {
    let sign = usize::from(text.starts_with(['+', '-']));
    let real = sign + real_length(text.get(sign..)?);
    let between = if real > sign {
        usize::from(text.get(real..)?.starts_with(['+', '-']))
    } else {
        0
    };
    if real > sign && between == 0 {
        return None;
    }
    Some(real + between + imaginary_length(text.get(real + between..)?)?)
}

/// Returns the length of `i`, `i2` or `i2.5`.
pub(super) fn imaginary_length(text: &str) -> Option<usize> {
    let part = text.strip_prefix('i')?;
    let length = real_length(part);
    word_ends(part.get(length..)).then_some(1 + length)
}

/// Splits the text of a complex number into its parts.
pub(crate) fn complex_parts(text: &str) -> (f64, f64) {
    let (real, imaginary) = text.split_once('i').unwrap_or((text, "0"));
    let size = if imaginary.is_empty() {
        1.0
    } else {
        imaginary.parse().unwrap_or(f64::NAN)
    };
    let sign = if real.ends_with('-') { -1.0 } else { 1.0 };
    // empty after a lone sign: `-i2` has no real part
    let real = real.strip_suffix(['+', '-']).unwrap_or(real);
    let real = if real.is_empty() {
        0.0
    } else {
        real.parse().unwrap_or(f64::NAN)
    };
    (real, sign * size)
}

/// Returns the length of an integer or a real.
fn real_length(text: &str) -> usize {
    let whole = digits(text);
    let fraction = text
        .get(whole..)
        .and_then(|rest| rest.strip_prefix('.'))
        .map_or(0, digits);
    if whole > 0 && fraction > 0 {
        whole + 1 + fraction
    } else {
        whole
    }
}

/// Returns the length of an exponent such as `E3` or `e-3`, which is read only in order to report
/// it.
fn exponent_length(text: &str) -> usize {
    let Some(rest) = text.strip_prefix(['e', 'E']) else {
        return 0;
    };
    let sign = usize::from(rest.starts_with(['+', '-']));
    let size = rest.get(sign..).map_or(0, digits);
    let ends = word_ends(rest.get(sign + size..));
    if size > 0 && ends { 1 + sign + size } else { 0 }
}

fn digits(text: &str) -> usize {
    text.find(|c: char| !c.is_ascii_digit())
        .unwrap_or(text.len())
}

fn word_ends(rest: Option<&str>) -> bool {
    !rest.unwrap_or("").starts_with(word::goes_on)
}
