//! Signs, including those of other languages.

use super::{Keyword, Lexer, Sign, Token, TokenLength, number, word};
use crate::codes::l009::ForeignSign;
use crate::codes::l077::CompoundAssignment;

/// Operators of other languages, with their equivalents; longer ones first.
const FOREIGN: &[(&str, &str)] = &[
    ("&&", "and"),
    ("&", "and"),
    ("∧", "and"),
    ("||", "or"),
    ("∨", "or"),
    ("!", "not"),
    ("¬", "not"),
    ("==", "="),
    ("=>", "implies"),
    ("⇒", "implies"),
    ("≠", "!="),
    ("≤", "<="),
    ("≥", ">="),
    ("→", "->"),
    ("≔", ":="),
    ("%", "mod"),
    ("**", "^"),
    ("~", "not"),
    ("/\\", "and"),
    ("\\/", "or"),
];

/// Assignment operators of other languages.
const COMPOUND: &[&str] = &["++", "--", "+=", "-=", "*="];

/// Returns `true` if the text behind `++` or `--` can be an operand rather than what follows a rule.
fn begins_operand(behind: &str) -> bool {
    let behind = behind.trim_start_matches([' ', '\t']);
    if behind.starts_with(|c: char| c.is_ascii_digit() || "($[{".contains(c)) {
        return true;
    }
    let name = behind.get(..word::length(behind)).unwrap_or("");
    let after = behind.get(name.len()..).unwrap_or("").trim_start();
    let is_rule = Keyword::spelled(name).is_some()
        || name.starts_with("r_")
        || [":=", "++", "--", "+=", "-="]
            .iter()
            .any(|sign| after.starts_with(sign));
    !name.is_empty() && !is_rule
}

/// Returns the location without arguments or with simple ones at the end of a text.
fn assigned(before: &str) -> Option<&str> {
    let before = before.trim_end();
    let name = match before.strip_suffix(')') {
        Some(inside) => {
            let (name, arguments) = inside.rsplit_once('(')?;
            if arguments.contains(')') {
                return None;
            }
            name
        }
        None => before,
    };
    let is_part = |c: char| word::goes_on(c) || c == '$';
    let start = name.trim_end_matches(is_part).len();
    before.get(start..).filter(|_| start < name.len())
}

/// Returns `true` if a sign, possibly one of another language, begins with this character. The
/// first character of every sign is a sign itself.
pub(super) fn begins(c: char) -> bool {
    Sign::spelled(c.encode_utf8(&mut [0; 4])).is_some()
        || FOREIGN.iter().any(|(sign, _)| sign.starts_with(c))
}

impl<'input> Lexer<'input, '_> {
    /// Reads the longest valid sign, or the number that begins with it.
    pub(super) fn sign(&mut self) -> Option<TokenLength<'input>> {
        let rest = self.rest();
        if rest.starts_with(['+', '-']) && !self.previous.is_some_and(Token::ends_operand) {
            let complex = number::complex_length(rest).and_then(|length| rest.get(..length));
            if let Some(complex) = complex {
                return Some((Token::Complex(complex), complex.len()));
            }
        }
        if let Some(foreign) = self.compound_assignment() {
            return Some(foreign);
        }
        let spelled = |length| rest.get(..length).and_then(Sign::spelled);
        let Some(sign) = spelled(2).filter(|&sign| self.makes_sense(sign)) else {
            return self
                .foreign_sign()
                .or_else(|| Some((Token::Sign(spelled(1)?), 1)));
        };
        if matches!(sign, Sign::OpenRule | Sign::CloseRule) {
            self.in_rule_reference = sign == Sign::OpenRule;
        }
        Some((Token::Sign(sign), 2))
    }

    /// Returns `true` if two characters form one sign: `a<-1` compares, `a <- r_x()` returns a
    /// result, `<<r_x>>` is a rule, `<<1>>` a nested bag.
    fn makes_sense(&self, sign: Sign) -> bool {
        if let Sign::Return | Sign::OpenRule = sign {
            self.from(self.position + 2).trim_start().starts_with("r_")
        } else {
            sign != Sign::CloseRule || self.in_rule_reference
        }
    }

    /// Reads an assignment operator of another language: reports it, and returns `:=`. The second sign of `++` becomes `undef`.
    fn compound_assignment(&self) -> Option<TokenLength<'input>> {
        let rest = self.rest();
        let before = self.text.get(..self.position)?;
        if self.previous == Some(Token::Sign(Sign::Assign)) && !before.trim_end().ends_with('=') {
            return Some((Token::Keyword(Keyword::Undef), 1));
        }
        let found = *COMPOUND.iter().find(|found| rest.starts_with(**found))?;
        let behind = rest.get(found.len()..)?;
        let is_step = matches!(found, "++" | "--");
        if !self.previous.is_some_and(Token::ends_operand) || is_step && begins_operand(behind) {
            return None;
        }
        let (sign, term) = (found.get(..1)?, if is_step { " 1" } else { "" });
        // behind `-` and `*`, an operand may need brackets
        let location = assigned(before).filter(|_| is_step || sign == "+");
        let update = location.map(|location| {
            let blank = if before.ends_with(' ') { "" } else { " " };
            let operand = if is_step { "1" } else { "…" };
            let whole = format!("{location} := {location} {sign} {operand}");
            (whole, format!("{blank}:= {location} {sign}{term}"))
        });
        self.findings.report(CompoundAssignment {
            found,
            update,
            at: self.next_bytes(found.len()),
        });
        Some((
            Token::Sign(Sign::Assign),
            if is_step { 1 } else { found.len() },
        ))
    }

    /// Reads a sign of another language: reports it, and returns its equivalent.
    fn foreign_sign(&self) -> Option<TokenLength<'input>> {
        let rest = self.rest();
        let &(found, meant) = FOREIGN.iter().find(|(found, _)| rest.starts_with(found))?;
        let keyword = Keyword::spelled(meant).map(Token::Keyword);
        let token = keyword.or_else(|| Sign::spelled(meant).map(Token::Sign))?;
        self.report_foreign(found, meant);
        Some((token, found.len()))
    }

    /// Reports the notation of another language for `meant`. The fix adds blanks where words would
    /// touch.
    pub(super) fn report_foreign(&self, found: &str, meant: &'static str) {
        let at = self.next_bytes(found.len());
        let before = self
            .text
            .get(..self.position)
            .is_some_and(|text| text.ends_with(word::goes_on));
        let after = self
            .from(self.position + found.len())
            .starts_with(word::goes_on);
        let blank = |needed| if needed { " " } else { "" };
        let text = format!("{}{meant}{}", blank(before), blank(after));
        self.findings.report(ForeignSign {
            found: found.to_owned(),
            meant,
            text,
            at,
        });
    }
}
