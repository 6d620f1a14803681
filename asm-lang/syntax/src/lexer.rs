//! Text to tokens, one at a time and never failing: what is no token is reported and skipped.

mod number;
mod token;

pub(crate) use number::complex_parts;
pub use token::{Keyword, Sign, Token};

use crate::ast::{Annotation, Name};
use crate::error::SyntaxError;
use crate::findings::Findings;

/// A token and the bytes it covers.
pub type Spanned<'input> = (usize, Token<'input>, usize);

/// Reads tokens from a text.
#[derive(Debug)]
pub struct Lexer<'input, 'run> {
    text: &'input str,
    findings: &'run Findings,
    /// Where the next token is looked for.
    position: usize,
    /// What was read last: three tokens depend on what stands before them.
    previous: Option<Token<'input>>,
    /// Whether a `<<` waits for its `>>`; otherwise `>>` closes two bags.
    in_rule_reference: bool,
    /// The `//@…` comments met so far.
    pub annotations: Vec<Annotation>,
}

impl<'input, 'run> Lexer<'input, 'run> {
    /// Begins at the first character.
    pub fn new(text: &'input str, findings: &'run Findings) -> Self {
        Self {
            text,
            findings,
            position: if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 },
            previous: None,
            in_rule_reference: false,
            annotations: Vec::new(),
        }
    }

    /// What is left to read.
    fn rest(&self) -> &'input str {
        self.from(self.position)
    }

    fn from(&self, start: usize) -> &'input str {
        self.text.get(start..).unwrap_or("")
    }

    fn token(&mut self) -> Option<Spanned<'input>> {
        loop {
            self.blanks_and_comments();
            let start = self.position;
            let first = self.rest().chars().next()?;
            let token = match first {
                _ if self.after(Keyword::Import) && self.path().is_some() => self.path(),
                '"' => Some(self.quoted('"', Token::Text)),
                '\'' => Some(self.quoted('\'', Token::Char)),
                '$' => self.variable(),
                '0'..='9' => Some(self.number()),
                '_' => Some(self.word()),
                _ if first.is_alphabetic() => Some(self.word()),
                _ => self.sign(),
            };
            if let Some((token, length)) = token {
                self.position = start + length;
                self.previous = Some(token);
                return Some((start, token, self.position));
            }
            self.skip_unknown();
        }
    }

    fn after(&self, keyword: Keyword) -> bool {
        self.previous == Some(Token::Keyword(keyword))
    }

    // ── between tokens ──

    fn blanks_and_comments(&mut self) {
        loop {
            let rest = self.rest();
            let blanks = rest.len() - rest.trim_start().len();
            if blanks > 0 {
                self.position += blanks;
            } else if rest.starts_with("//") {
                self.line_comment(rest);
            } else if rest.starts_with("/*") {
                self.block_comment(rest);
            } else {
                return;
            }
        }
    }

    fn line_comment(&mut self, rest: &'input str) {
        let line = rest.split(['\n', '\r']).next().unwrap_or(rest);
        if let Some(note) = line.strip_prefix("//@") {
            let length = word_length(note);
            let start = self.position + "//@".len();
            if let Some((name, arguments)) = note.split_at_checked(length).filter(|_| length > 0) {
                self.annotations.push(Annotation {
                    name: Name { text: name.into(), span: self.findings.span(start, start + length) },
                    rest: arguments.trim().to_owned(),
                });
            }
        }
        self.position += line.len();
    }

    fn block_comment(&mut self, rest: &'input str) {
        let opener = "/*".len();
        let inside = rest.get(opener..).unwrap_or("");
        let length = inside.find("*/").map(|end| opener + end + "*/".len());
        if length.is_none() {
            let open = self.findings.span(self.position, self.position + opener);
            self.findings.report(SyntaxError::OpenComment { open });
        }
        self.position += length.unwrap_or(rest.len());
    }

    /// Reports a run of characters that begin no token, once, and goes on behind it.
    fn skip_unknown(&mut self) {
        let rest = self.rest();
        let length = rest.find(|c: char| !is_unknown(c)).unwrap_or(rest.len());
        // A character that fits only in company, as `$` does, stands alone here.
        let length = length.max(rest.chars().next().map_or(0, char::len_utf8));
        let (characters, _) = rest.split_at_checked(length).unwrap_or((rest, ""));
        let at = self.findings.span(self.position, self.position + length);
        self.findings.report(match characters {
            ";" => SyntaxError::Semicolon { at },
            _ => SyntaxError::UnknownCharacters { characters: characters.chars().take(16).collect(), at },
        });
        self.position += length;
    }

    // ── tokens; each with its length in bytes ──

    /// What stands after `import`: quoted, or everything up to a blank or a bracket.
    fn path(&self) -> Option<(Token<'input>, usize)> {
        let rest = self.rest();
        if let Some(quoted) = rest.strip_prefix('"') {
            let path = quoted.split(['"', '\n']).next().unwrap_or(quoted);
            let closed = self.from(self.position + 1 + path.len()).starts_with('"');
            return closed.then_some((Token::Path(path), path.len() + 2));
        }
        let in_path = |c: char| c.is_ascii_alphanumeric() || "_-./\\:".contains(c);
        let length = rest.find(|c| !in_path(c)).unwrap_or(rest.len());
        let path = rest.get(..length).filter(|path| !path.is_empty())?;
        // `import` without a path, then the next section
        let section = Keyword::spelled(path.trim_end_matches(':')).is_some();
        (!section).then_some((Token::Path(path), length))
    }

    /// Text in quotes; a backslash keeps the character after it from ending the text.
    fn quoted(
        &self,
        quote: char,
        token: fn(&'input str) -> Token<'input>,
    ) -> (Token<'input>, usize) {
        let inside = self.from(self.position + 1);
        let mut escaped = false;
        for (offset, c) in inside.char_indices() {
            match c {
                _ if c == quote && !escaped => {
                    return (token(inside.get(..offset).unwrap_or("")), offset + 2);
                }
                '\n' | '\r' => break,
                _ => escaped = c == '\\' && !escaped,
            }
        }
        let line = inside.split(['\n', '\r']).next().unwrap_or(inside);
        let open = self.findings.span(self.position, self.position + 1 + line.len());
        self.findings.report(SyntaxError::OpenQuote { quote, open });
        (token(line), 1 + line.len())
    }

    fn variable(&self) -> Option<(Token<'input>, usize)> {
        let rest = self.rest();
        let name = rest.strip_prefix('$')?;
        let length = 1 + name.starts_with(begins_word).then(|| word_length(name))?;
        self.check_ascii(rest, length);
        Some((Token::Variable(rest.get(..length)?), length))
    }

    fn word(&self) -> (Token<'input>, usize) {
        let rest = self.rest();
        let length = word_length(rest);
        let word = rest.get(..length).unwrap_or(rest);
        let token = if self.names_file_or_state(word) {
            Token::Word(word)
        } else if let Some((found, meant)) = divided_end(rest) {
            let at = self.findings.span(self.position, self.position + found.len());
            self.findings.report(SyntaxError::Foreign { found: found.to_owned(), meant, at });
            return (Token::Keyword(Keyword::spelled(meant).unwrap_or(Keyword::Endif)), found.len());
        } else if let Some(keyword) = Keyword::spelled(word) {
            Token::Keyword(keyword)
        } else if let Some(imaginary) = number::imaginary_length(rest) {
            return (Token::Complex(rest.get(..imaginary).unwrap_or(word)), imaginary);
        } else if word.starts_with(char::is_uppercase) {
            Token::Constant(word)
        } else if word.starts_with("r_") && word.len() > "r_".len() {
            Token::Rule(word)
        } else {
            Token::Name(word)
        };
        self.check_ascii(rest, length);
        (token, length)
    }

    /// Any word may follow `asm`, `module` and `init`, except one that begins a section.
    fn names_file_or_state(&self, word: &str) -> bool {
        let sections = ["import", "export", "signature", "definitions"];
        let named = [Keyword::Asm, Keyword::Module, Keyword::Init];
        named.into_iter().any(|keyword| self.after(keyword)) && !sections.contains(&word)
    }

    fn number(&self) -> (Token<'input>, usize) {
        let (token, length) = number::read(self.rest());
        let at = self.findings.span(self.position, self.position + length);
        if let Token::Real(digits) = token {
            let number = digits.to_owned();
            if digits.ends_with('.') {
                self.findings.report(SyntaxError::BarePoint { number, at });
            } else if digits.contains(['e', 'E']) {
                self.findings.report(SyntaxError::Exponent { number, at });
            }
        }
        (token, length)
    }

    fn sign(&mut self) -> Option<(Token<'input>, usize)> {
        let rest = self.rest();
        if rest.starts_with(['+', '-'])
            && !self.previous.is_some_and(ends_operand)
            && let Some(length) = number::complex_length(rest)
        {
            return Some((Token::Complex(rest.get(..length)?), length));
        }
        // Every sign is one or two characters; the longer one wins.
        let spelled = |length| rest.get(..length).and_then(Sign::spelled);
        let Some(sign) = spelled(2).filter(|&sign| self.fits(sign)) else {
            return self.foreign().or_else(|| Some((Token::Sign(spelled(1)?), 1)));
        };
        match sign {
            Sign::OpenRule => self.in_rule_reference = true,
            Sign::CloseRule => self.in_rule_reference = false,
            _ => {}
        }
        Some((Token::Sign(sign), 2))
    }

    /// An operator of another language: reported, and read as it was meant.
    fn foreign(&self) -> Option<(Token<'input>, usize)> {
        let rest = self.rest();
        let &(found, meant) = FOREIGN.iter().find(|(found, _)| rest.starts_with(found))?;
        let at = self.findings.span(self.position, self.position + found.len());
        self.findings.report(SyntaxError::Foreign { found: found.to_owned(), meant, at });
        let token = Keyword::spelled(meant)
            .map(Token::Keyword)
            .or_else(|| Sign::spelled(meant).map(Token::Sign))?;
        Some((token, found.len()))
    }

    /// Whether a sign of two characters is meant as one: `a<-1` compares, `a <- r_x()` returns,
    /// `<<r_x>>` is a rule, `<<1>>` a bag in a bag.
    fn fits(&self, sign: Sign) -> bool {
        let before_rule = || {
            let rest = self.from(self.position + sign.spelling().len()).trim_start();
            rest.starts_with("r_")
        };
        match sign {
            Sign::Return | Sign::OpenRule => before_rule(),
            Sign::CloseRule => self.in_rule_reference,
            _ => true,
        }
    }

    fn check_ascii(&self, rest: &str, length: usize) {
        if let Some(word) = rest.get(..length).filter(|word| !word.is_ascii()) {
            let at = self.findings.span(self.position, self.position + length);
            self.findings.report(SyntaxError::ForeignLetters { word: word.to_owned(), at });
        }
    }
}

impl<'input> Iterator for Lexer<'input, '_> {
    type Item = Spanned<'input>;

    fn next(&mut self) -> Option<Self::Item> {
        self.token()
    }
}

/// Operators as other languages write them, and what they mean here; longest first.
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
];

/// `end if` for `endif`, in one line: what was found, and the word that was meant.
fn divided_end(text: &str) -> Option<(&str, &'static str)> {
    let rest = text.strip_prefix("end")?;
    let second = rest.trim_start_matches([' ', '\t']);
    let blanks = rest.len() - second.len();
    let second = second.get(..word_length(second))?;
    let ends = [
        Keyword::Endif,
        Keyword::Endpar,
        Keyword::Endseq,
        Keyword::Endlet,
        Keyword::Endswitch,
        Keyword::Enditerate,
    ];
    let meant = ends.into_iter().map(Keyword::spelling).find(|end| end.strip_prefix("end") == Some(second))?;
    let found = text.get(.."end".len() + blanks + second.len())?;
    (blanks > 0).then_some((found, meant))
}

fn begins_word(c: char) -> bool {
    c == '_' || c.is_alphabetic()
}

fn word_length(text: &str) -> usize {
    text.find(|c: char| c != '_' && !c.is_alphanumeric()).unwrap_or(text.len())
}

/// Whether no token at all begins with this character.
fn is_unknown(c: char) -> bool {
    let begins_sign = "()[]{}<>,:.|-+*/^=\"'$;".contains(c)
        || FOREIGN.iter().any(|(found, _)| found.starts_with(c));
    !c.is_whitespace() && !begins_word(c) && !c.is_ascii_digit() && !begins_sign
}

/// Whether an operand ends here, so that `+` and `-` after it are operators.
pub(crate) fn ends_operand(token: Token<'_>) -> bool {
    match token {
        Token::Keyword(word) => matches!(
            word,
            Keyword::True
                | Keyword::False
                | Keyword::Undef
                | Keyword::Endif
                | Keyword::Endswitch
                | Keyword::Endlet
        ),
        Token::Sign(sign) => {
            matches!(sign, Sign::Close | Sign::CloseBrace | Sign::CloseBracket | Sign::CloseRule)
        }
        Token::Name(_)
        | Token::Constant(_)
        | Token::Rule(_)
        | Token::Variable(_)
        | Token::Word(_)
        | Token::Path(_)
        | Token::Integer(_)
        | Token::Natural(_)
        | Token::Real(_)
        | Token::Complex(_)
        | Token::Char(_)
        | Token::Text(_) => true,
    }
}

/// The one character of a character literal; `None` for none or several.
pub(crate) fn unescaped(text: &str) -> Option<char> {
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
