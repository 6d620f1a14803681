//! Why the parser stopped, in the user's words.
//!
//! The parser knows a token and the tokens it would rather have seen. A second look at the text up
//! to there tells what was open; both together tell the user's mistake from its traces.

mod expected;

use crate::error::{Place, SyntaxError};
use crate::findings::Findings;
use crate::lexer::{Keyword, Lexer, Sign, Spanned, Token};
use crate::nesting::{Nesting, closer, opener, starts_item};
use crate::spelling::nearest;
use expected::{Expected, starts_rule};
use lalrpop_util::ParseError;
use source::Span;
use std::convert::Infallible;

/// An error as the parser found it.
pub(crate) type Failure<'input> = ParseError<usize, Token<'input>, Infallible>;

/// So many bytes count as one line, however long it is.
const LINE: usize = 1000;

/// Follows the parser from error to error.
#[derive(Debug)]
pub(crate) struct Explainer<'input, 'run> {
    text: &'input str,
    findings: &'run Findings,
    lexer: Lexer<'input, 'run>,
    ahead: Option<Spanned<'input>>,
    nesting: Nesting<'input>,
    /// Where the last three tokens begin, the oldest first.
    recent: [usize; 3],
    last: Option<Last>,
}

/// The error explained last.
#[derive(Clone, Copy, Debug)]
struct Last {
    at: usize,
    /// Where reading went on.
    resumed: usize,
}

impl<'input, 'run> Explainer<'input, 'run> {
    /// Reads `text` once more; what is wrong with its tokens goes to `unheard`.
    pub(crate) fn new(
        text: &'input str,
        findings: &'run Findings,
        unheard: &'run Findings,
    ) -> Self {
        let mut lexer = Lexer::new(text, unheard);
        let ahead = lexer.next();
        let nesting = Nesting::new(text);
        Self { text, findings, lexer, ahead, nesting, recent: [0; 3], last: None }
    }

    /// Reports an error, unless it only follows from one before. What the parser gave up for it
    /// reaches from `start` to `resumed`.
    pub(crate) fn explain(&mut self, failure: &Failure<'_>, start: usize, resumed: usize) {
        let (found, expected) = match failure {
            ParseError::UnrecognizedToken { token: (start, _, end), expected } => {
                (*start..*end, Expected::new(expected))
            }
            ParseError::UnrecognizedEof { location, expected } => {
                (*location..*location, Expected::new(expected))
            }
            // Neither is made by a parser whose lexer cannot fail.
            ParseError::InvalidToken { location } => (*location..*location, Expected::default()),
            ParseError::ExtraToken { token: (start, _, end) } => {
                (*start..*end, Expected::default())
            }
            ParseError::User { error } => match *error {},
        };
        self.advance(found.start.max(usize::from(found.is_empty()) * self.text.len()));
        let at = self.findings.span(found.start, found.end);
        self.findings.caught(at);
        let error = match self.ahead {
            Some(token) => self.token(token, &expected),
            None => self.end(at, &expected),
        };
        if !self.follows(&error, start, found.start) {
            if matches!(error, SyntaxError::Unclosed { .. } | SyntaxError::CutOff { .. }) {
                // What looks like several rules is the inside of what was not closed.
                self.findings.retract("L024", start);
            }
            self.findings.report(error);
        }
        self.last = Some(Last { at: found.start, resumed: resumed.max(found.end) });
    }

    /// Reads up to the token that begins at `offset`.
    fn advance(&mut self, offset: usize) {
        while let Some(token) = self.ahead.filter(|token| token.0 < offset) {
            self.nesting.step(token);
            self.recent = [self.recent[1], self.recent[2], token.0];
            self.ahead = self.lexer.next();
        }
    }

    /// Whether the error is but a trace of one before: in the same declaration, and near it, or
    /// around it, or an end whose beginning was lost.
    fn follows(&self, error: &SyntaxError, start: usize, found: usize) -> bool {
        let declaration = self.nesting.declaration().map_or(0, |(start, _, _)| start);
        let line = self.text.as_bytes().get(found.saturating_sub(LINE)..found).unwrap_or(&[]);
        let line = line.iter().rev().take_while(|&&byte| byte != b'\n').count();
        let line = (found - line).max(declaration);
        if self.findings.error_between(line, found) {
            return true;
        }
        let Some(last) = self.last.filter(|last| last.at >= declaration) else { return false };
        let ends = matches!(error, SyntaxError::ClosesNothing { .. } | SyntaxError::NoRule { .. });
        let [oldest, ..] = self.recent;
        start <= last.at || oldest <= last.resumed || line <= last.resumed || ends
    }

    // ── at the end of the text ──

    fn end(&self, at: Span, expected: &Expected<'_>) -> SyntaxError {
        let open: Vec<Place> = self.nesting.open().take(3).map(|open| self.place(open.opener)).collect();
        let missing = match self.unclosed(expected) {
            Some(missing) => format!("`{missing}`"),
            None => expected.to_string(),
        };
        SyntaxError::CutOff { missing, at, open }
    }

    // ── at a token ──

    fn token(&self, spanned: Spanned<'input>, expected: &Expected<'_>) -> SyntaxError {
        let found = self.place(spanned);
        self.reserved(spanned, expected)
            .or_else(|| self.wrong_sign(spanned, expected))
            .or_else(|| self.misspelled(spanned, expected))
            .or_else(|| self.no_heading(spanned, expected))
            .or_else(|| self.rule_out_of_place(spanned, expected))
            .or_else(|| self.missing_end(spanned, expected))
            .or_else(|| self.missing_word(spanned, expected))
            .or_else(|| self.misnamed(spanned, expected))
            .or_else(|| self.missing_rule(spanned, expected))
            .or_else(|| self.bare(spanned, expected))
            .unwrap_or_else(|| {
                let bracket = self.nesting.innermost().map(|open| open.opener).filter(
                    |opener| closer(opener.1).is_some_and(|closer| expected.has(&closer.to_string())),
                );
                let open = bracket.map(|opener| self.place(opener));
                let before = self.nesting.previous.filter(|_| self.on_a_new_line(spanned));
                let after = before.map(|before| self.place(before));
                SyntaxError::Expected { what: expected.to_string(), found, after, open }
            })
    }

    /// Words that no rule of the grammar has.
    fn reserved(&self, found: Spanned<'input>, _: &Expected<'_>) -> Option<SyntaxError> {
        let unused = matches!(
            found.1,
            Token::Keyword(
                Keyword::Try | Keyword::Catch | Keyword::Endcase | Keyword::Fairness
            )
        );
        unused.then(|| SyntaxError::Unused { found: self.place(found) })
    }

    /// `=` for `:=` and the reverse.
    fn wrong_sign(&self, found: Spanned<'input>, expected: &Expected<'_>) -> Option<SyntaxError> {
        let at = self.findings.span(found.0, found.2);
        match found.1 {
            Token::Sign(Sign::Eq) if expected.has(":=") => Some(SyntaxError::EqualsForUpdate { at }),
            Token::Sign(Sign::Assign) if expected.operator() => {
                Some(SyntaxError::UpdateForEquals { at })
            }
            _ => None,
        }
    }

    /// A name that is nearly a word expected here; words that go on like names are names.
    fn misspelled(&self, found: Spanned<'input>, expected: &Expected<'_>) -> Option<SyntaxError> {
        let (Token::Name(name) | Token::Constant(name)) = found.1 else { return None };
        let rest = self.text.get(found.2..).unwrap_or("").trim_start();
        if [":=", "<-", "(", "[", "."].iter().any(|sign| rest.starts_with(sign)) {
            return None;
        }
        let meant = expected.nearest(name)?;
        Some(SyntaxError::UnknownWord { found: self.place(found), meant: meant.to_owned() })
    }

    /// Something else before `asm` or `module`.
    fn no_heading(&self, found: Spanned<'input>, expected: &Expected<'_>) -> Option<SyntaxError> {
        let at = self.findings.span(found.0, found.2);
        let first = self.nesting.declaration().is_none() && expected.item();
        first.then_some(SyntaxError::NoHeading { at })
    }

    /// A second rule where a declaration has one, or a rule in brackets.
    fn rule_out_of_place(
        &self,
        found: Spanned<'input>,
        expected: &Expected<'_>,
    ) -> Option<SyntaxError> {
        let (declaration_start, declaration, declaration_end) = self.nesting.declaration()?;
        let in_rule = matches!(
            declaration,
            Token::Keyword(Keyword::Rule | Keyword::Main | Keyword::Turbo | Keyword::Macro)
        );
        if in_rule && expected.item() && starts_rule(found.1) {
            return Some(SyntaxError::SeveralRules {
                first: self.findings.span(declaration_start, declaration_end),
                second: self.findings.span(found.0, found.2),
                all: None,
            });
        }
        let bracketed = found.1 == Token::Sign(Sign::Open) && expected.rule();
        let after_rule = matches!(self.nesting.previous, Some((_, Token::Rule(_), _)));
        (bracketed && !after_rule)
            .then(|| SyntaxError::BracketedRule { at: self.findings.span(found.0, found.2) })
    }

    /// An end that is missing before this token, or an end without a beginning.
    fn missing_end(&self, found: Spanned<'input>, expected: &Expected<'_>) -> Option<SyntaxError> {
        let ends = opener(found.1).is_some() && found.1 != Token::Sign(Sign::Gt);
        let in_bracket = self.nesting.innermost().is_some_and(|open| {
            matches!(open.opener.1, Token::Sign(_)) && self.on_a_new_line(found)
        });
        if !ends && !goes_on(found.1) && !in_bracket {
            return None;
        }
        let innermost = self.nesting.innermost()?;
        if let Some(missing) = self.unclosed(expected) {
            if let Some(suspect) = innermost.suspect {
                let meant = nearest(self.place(suspect).0.as_str(), [missing.as_str()])?.to_owned();
                return Some(SyntaxError::UnknownWord { found: self.place(suspect), meant });
            }
            return Some(match innermost.else_if {
                Some(inner) => SyntaxError::ElseIf {
                    found: self.place(found),
                    outer: self.span(innermost.opener),
                    inner: self.span(inner),
                },
                None => SyntaxError::Unclosed {
                    missing,
                    found: self.place(found),
                    open: self.place(innermost.opener),
                    misaligned: self
                        .nesting
                        .misaligned
                        .map(|(inner, end)| (self.place(inner), self.place(end))),
                },
            });
        }
        let closes = opener(found.1).is_some_and(|opener| {
            self.nesting.open().any(|open| open.opener.1 == opener)
        });
        (ends && !closes).then(|| SyntaxError::ClosesNothing { found: self.place(found) })
    }

    /// The word between the parts of a construct.
    fn missing_word(&self, found: Spanned<'input>, expected: &Expected<'_>) -> Option<SyntaxError> {
        if expected.term() || expected.rule() || expected.item() {
            return None;
        }
        let innermost = self.nesting.innermost()?;
        let (word, after, opener) = match (innermost.prefix, innermost.opener.1, self.nesting.previous) {
            (_, _, Some((start, Token::Variable(name), end))) if expected.has("in") && !expected.has("=") => {
                let _ = (start, end);
                ("in", format!("the variable `{name}`"), None)
            }
            (Some(prefix), _, _) if expected.has("do") => {
                ("do", format!("the {} of `{}`", head(prefix.1), prefix.1), Some(prefix))
            }
            (_, Token::Keyword(Keyword::If), _) if expected.has("then") => {
                ("then", "the guard of `if`".to_owned(), Some(innermost.opener))
            }
            (_, Token::Keyword(Keyword::Switch), _) if expected.has("case") && !expected.has("endswitch") => {
                ("case", "the term of `switch`".to_owned(), Some(innermost.opener))
            }
            (_, Token::Keyword(Keyword::Switch), _) if expected.has(":") => {
                (":", "the term of `case`".to_owned(), Some(innermost.opener))
            }
            (_, Token::Keyword(Keyword::Let), _) if expected.has("in") => {
                ("in", "the bindings of `let`".to_owned(), Some(innermost.opener))
            }
            (_, Token::Keyword(word), previous) if self.nesting.open().next().is_none() => {
                let signs = ["=", ":", "over", "domain", "subsetof", "rule"];
                let word_expected = signs.into_iter().find(|sign| expected.has(sign) && !expected.operator())?;
                let after = match previous {
                    Some(previous) if previous.1 != Token::Keyword(word) => {
                        format!("`{}`", self.place(previous).0)
                    }
                    _ => format!("`{}`", word.spelling()),
                };
                (word_expected, after, None)
            }
            _ => return None,
        };
        let opener = opener.map(|opener| self.place(opener));
        Some(SyntaxError::MissingWord { word, after, found: self.place(found), opener })
    }

    /// A name of the wrong kind, or a word that cannot be a name.
    fn misnamed(&self, found: Spanned<'input>, expected: &Expected<'_>) -> Option<SyntaxError> {
        let place = self.place(found);
        if let Token::Complex(_) = found.1
            && (expected.rule() || expected.name().is_some())
        {
            return Some(SyntaxError::ComplexName { found: place, what: "a function" });
        }
        let (what, beginning) = expected.name()?;
        let better = match (found.1, what) {
            (Token::Name(name), "a domain") => capitalised(name),
            (Token::Name(name), "a rule") => Some(format!("r_{name}")),
            (Token::Name(name), "a variable") => Some(format!("${name}")),
            (Token::Constant(name), "a function") => uncapitalised(name),
            (Token::Keyword(_), _) => {
                return Some(SyntaxError::ReservedName { found: place, what });
            }
            (Token::Name(_) | Token::Constant(_) | Token::Rule(_) | Token::Variable(_), _) => None,
            _ => return None,
        };
        Some(SyntaxError::Misnamed { what, beginning, found: place, better })
    }

    /// `then else`, `par … do endpar`.
    fn missing_rule(&self, found: Spanned<'input>, expected: &Expected<'_>) -> Option<SyntaxError> {
        let ends = opener(found.1).is_some() || goes_on(found.1);
        (ends && expected.rule() && !expected.item()).then(|| SyntaxError::NoRule {
            found: self.place(found),
            after: self.nesting.previous.map(|previous| self.place(previous)),
        })
    }

    /// What wants brackets and has none.
    fn bare(&self, found: Spanned<'input>, expected: &Expected<'_>) -> Option<SyntaxError> {
        if let Some(previous @ (_, Token::Rule(rule), _)) = self.nesting.previous
            && expected.has("[")
            && expected.has("(")
        {
            return Some(SyntaxError::CallWithoutBrackets { rule: rule.to_owned(), at: self.span(previous) });
        }
        let quantifier = matches!(
            found.1,
            Token::Keyword(Keyword::Forall | Keyword::Exists | Keyword::Exist)
        );
        (quantifier && expected.term()).then(|| SyntaxError::BareQuantifier {
            word: found.1.to_string(),
            at: self.span(found),
        })
    }

    /// The end the innermost opener waits for, if it may stand here.
    fn unclosed(&self, expected: &Expected<'_>) -> Option<String> {
        let innermost = self.nesting.open().next()?;
        let end = closer(innermost.opener.1)?.to_string();
        expected.has(&end).then_some(end)
    }

    fn on_a_new_line(&self, (start, _, _): Spanned<'_>) -> bool {
        let between = self.nesting.previous.map_or(0, |(_, _, end)| end)..start;
        self.text.get(between).is_some_and(|between| between.contains('\n'))
    }

    fn span(&self, (start, _, end): Spanned<'_>) -> Span {
        self.findings.span(start, end)
    }

    fn place(&self, spanned: Spanned<'_>) -> Place {
        let text = self.text.get(spanned.0..spanned.2).unwrap_or("");
        let word = if text.chars().count() > 40 {
            text.chars().take(40).chain(['…']).collect()
        } else {
            text.to_owned()
        };
        (word, self.span(spanned))
    }
}

/// Whether this token goes on with something begun before, or begins a declaration: it cannot
/// stand where something is still to come.
fn goes_on(token: Token<'_>) -> bool {
    let connects = matches!(
        token,
        Token::Keyword(
            Keyword::Then
                | Keyword::Else
                | Keyword::Case
                | Keyword::Otherwise
                | Keyword::Do
                | Keyword::Ifnone
                | Keyword::With
                | Keyword::In
        ) | Token::Sign(Sign::Assign | Sign::Colon | Sign::Bar | Sign::Arrow)
    );
    connects || starts_item(token)
}

/// What stands between the first word of a rule and its `do`.
fn head(prefix: Token<'_>) -> &'static str {
    match prefix {
        Token::Keyword(Keyword::While | Keyword::Whilerec) => "guard",
        _ => "variables",
    }
}

fn capitalised(name: &str) -> Option<String> {
    let mut characters = name.chars();
    let first = characters.next()?;
    Some(first.to_uppercase().chain(characters).collect())
}

fn uncapitalised(name: &str) -> Option<String> {
    let mut characters = name.chars();
    let first = characters.next()?;
    Some(first.to_lowercase().chain(characters).collect())
}
