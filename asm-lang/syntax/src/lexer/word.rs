//! Words: keywords, names, variables and paths.

use super::{Keyword, Lexer, Sign, Token, TokenLength, number};
use crate::codes::l002::ForeignLetters;
use crate::codes::l011::ElementName;
use crate::codes::l064::UnneededEnd;
use crate::codes::l078::InfixDivision;
use crate::codes::l080::QualifiedElement;

/// Returns `true` if a word can begin with this character.
pub(super) fn begins(c: char) -> bool {
    c == '_' || c.is_alphabetic()
}

/// Returns `true` if a word can contain this character.
pub(super) fn goes_on(c: char) -> bool {
    c == '_' || c.is_alphanumeric()
}

/// Returns the length of the word at the beginning of a text, including the number of an element
/// such as `person!1`.
pub(crate) fn length(text: &str) -> usize {
    let word = text.find(|c| !goes_on(c)).unwrap_or(text.len());
    let number = text
        .get(word..)
        .and_then(|rest| rest.strip_prefix('!'))
        .unwrap_or("");
    let digits = number
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(number.len());
    if digits > 0 {
        word + "!".len() + digits
    } else {
        word
    }
}

/// Returns the length of a word with the parts that follow it directly and begin with `$`, as in `X$next`.
fn with_dollars(text: &str, word: usize) -> usize {
    let behind = text.get(word..).and_then(|rest| rest.strip_prefix('$'));
    match behind.filter(|rest| rest.starts_with(begins)) {
        Some(rest) => with_dollars(text, word + "$".len() + length(rest)),
        None => word,
    }
}

impl<'input> Lexer<'input, '_> {
    pub(super) fn word(&self) -> TokenLength<'input> {
        let rest = self.rest();
        let word = rest.get(..length(rest)).unwrap_or(rest);
        if self.names_file_or_state(word) {
            return self.name(Token::Word(word), word);
        }
        if let Some(foreign) = self.foreign_word(word) {
            return foreign;
        }
        if let Some(foreign) = self
            .qualified_element(word)
            .or_else(|| self.infix_division(word))
        {
            return foreign;
        }
        if let Some(keyword) = Keyword::spelled(word) {
            return (Token::Keyword(keyword), word.len());
        }
        if let Some(length) = number::imaginary_length(rest) {
            return (Token::Complex(rest.get(..length).unwrap_or(word)), length);
        }
        let word = rest.get(..with_dollars(rest, word.len())).unwrap_or(word);
        let is_rule = word.strip_prefix("r_").is_some_and(|name| !name.is_empty());
        let token = match word {
            _ if word.starts_with(char::is_uppercase) => Token::Constant(word),
            _ if is_rule => Token::Rule(word),
            _ => Token::Name(word),
        };
        self.name(token, word)
    }

    /// Reads a variable: `$x`.
    pub(super) fn variable(&self) -> Option<TokenLength<'input>> {
        let rest = self.rest();
        let name = rest
            .strip_prefix('$')
            .filter(|name| name.starts_with(begins))?;
        let variable = rest.get(..with_dollars(rest, 1 + length(name)))?;
        Some(self.name(Token::Variable(variable), variable))
    }

    /// Reads the path after `import`: in quotes, or up to a blank or a bracket.
    pub(super) fn path(&self) -> Option<TokenLength<'input>> {
        let rest = self.rest();
        if let Some(quoted) = rest.strip_prefix('"') {
            let path = quoted.get(..quoted.find(['"', '\n'])?)?;
            let closed = quoted.get(path.len()..)?.starts_with('"');
            return closed.then_some((Token::Path(path), path.len() + 2));
        }
        let in_path = |c: char| c.is_ascii_alphanumeric() || "_-./\\:".contains(c);
        let path = rest.get(..rest.find(|c| !in_path(c)).unwrap_or(rest.len()))?;
        // the path is missing, and the next section follows
        let section = Keyword::spelled(path.trim_end_matches(':')).is_some();
        (!path.is_empty() && !section).then_some((Token::Path(path), path.len()))
    }

    /// Returns `true` if the word names a file or a state: any word after `asm`, `module` and
    /// `init` that begins no section.
    fn names_file_or_state(&self, word: &str) -> bool {
        let Some(Token::Keyword(before)) = self.previous else {
            return false;
        };
        let named = matches!(before, Keyword::Asm | Keyword::Module | Keyword::Init);
        named && !["import", "export", "signature", "definitions"].contains(&word)
    }

    /// Reads a block keyword of other languages: reports it, and returns its equivalent.
    fn foreign_word(&self, word: &'input str) -> Option<TokenLength<'input>> {
        if ["elseif", "elsif", "elif"].contains(&word) {
            self.report_foreign(word, "else if");
            // the next token is the `if`
            return Some((Token::Keyword(Keyword::Else), word.len() - "if".len()));
        }
        if word != "end" {
            return None;
        }
        // `end if` on one line
        let rest = self.rest();
        let second = rest.get(word.len()..)?.trim_start_matches([' ', '\t']);
        let second = second.get(..length(second))?;
        let suggestion = ENDS
            .iter()
            .find(|end| end.spelling().strip_prefix("end") == Some(second))?;
        let found = rest.get(..rest.find(second)? + second.len())?;
        self.report_foreign(found, suggestion.spelling());
        Some((Token::Keyword(*suggestion), found.len()))
    }

    /// Reads an element with its domain, `Mode.RUN` or `Mode::RUN`: reports it, and returns the element.
    fn qualified_element(&self, domain: &str) -> Option<TokenLength<'input>> {
        let rest = self.rest();
        let behind = rest.get(domain.len()..)?;
        let element = behind
            .strip_prefix("::")
            .or_else(|| behind.strip_prefix('.'))?;
        let element = element.get(..length(element))?;
        let is_constant = |word: &str| word.starts_with(char::is_uppercase);
        if !is_constant(domain) || !is_constant(element) {
            return None;
        }
        let dots = behind.find(element)?;
        let written = rest.get(..domain.len() + dots + element.len())?;
        self.findings.report(QualifiedElement {
            written: written.to_owned(),
            element: element.to_owned(),
            at: self.next_bytes(written.len()),
        });
        Some((Token::Constant(element), written.len()))
    }

    /// Reads `div` between two operands: reports it, and returns an operator whose result has the type of its operands.
    fn infix_division(&self, word: &str) -> Option<TokenLength<'input>> {
        let behind = self.rest().get(word.len()..)?.trim_start();
        let is_operator = word == "div"
            && self.previous.is_some_and(Token::ends_operand)
            && ![":=", "(", "<-", "="]
                .iter()
                .any(|sign| behind.starts_with(sign));
        is_operator.then(|| {
            self.findings.report(InfixDivision {
                at: self.next_bytes(word.len()),
            });
            (Token::Sign(Sign::Star), word.len())
        })
    }

    /// Reports the end keyword of a rule that has none, and skips it.
    pub(super) fn skip_unneeded_end(&mut self) -> bool {
        let rest = self.rest();
        let word = rest.get(..length(rest)).unwrap_or("");
        if !UNNEEDED_ENDS.contains(&word) || self.names_file_or_state(word) {
            return false;
        }
        let start = self.position;
        let before = self.text.get(..start).unwrap_or("");
        let line = before.trim_end_matches([' ', '\t']);
        let behind = rest.get(word.len()..).unwrap_or("");
        let ends_line = behind
            .trim_start_matches([' ', '\t'])
            .starts_with(['\n', '\r']);
        let kept = match line.strip_suffix('\n') {
            // the word stands alone on its line
            Some(above) if ends_line => above.strip_suffix('\r').unwrap_or(above),
            Some(_) => before,
            None => line,
        };
        let end = start + word.len();
        self.findings.report(UnneededEnd {
            word: word.to_owned(),
            at: self.findings.span(start, end),
            removed: self.findings.span(kept.len(), end),
        });
        self.position = end;
        true
    }

    /// Checks the characters of a name.
    fn name(&self, token: Token<'input>, word: &'input str) -> TokenLength<'input> {
        let at = self.next_bytes(word.len());
        let has_dollar = word.get(1..).is_some_and(|rest| rest.contains('$'));
        if !word.is_ascii() || has_dollar {
            self.findings.report(ForeignLetters {
                word: word.to_owned(),
                at,
            });
        } else if word.contains('!') && !self.names_elements {
            self.findings.report(ElementName {
                word: word.to_owned(),
                at,
            });
        }
        (token, word.len())
    }
}

/// Keywords of other dialects for the ends of rules that end with the rule in their body.
const UNNEEDED_ENDS: &[&str] = &["endchoose", "endforall", "endwhile", "endextend"];

const ENDS: &[Keyword] = &[
    Keyword::Endif,
    Keyword::Endpar,
    Keyword::Endseq,
    Keyword::Endlet,
    Keyword::Endswitch,
    Keyword::Enditerate,
];
