//! Missing, misspelt and unusable keywords.

use super::{Expected, Explainer};
use crate::codes::l021::NoHeading;
use crate::codes::l052::MissingWord;
use crate::codes::l053::UnknownWord;
use crate::codes::l057::UnusedWord;
use crate::lexer::{Keyword, SpannedToken, Token};
use asmotion_diagnostics::{Diagnostic, Finding};

/// A missing keyword, the position it belongs to, and the construct it is part of.
type Missing<'input> = (&'static str, String, Option<SpannedToken<'input>>);

impl<'input> Explainer<'input, '_> {
    /// A reserved word without a use.
    pub(super) fn unused_word(
        &self,
        found: SpannedToken<'input>,
        _: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let unused = [
            Keyword::Try,
            Keyword::Catch,
            Keyword::Endcase,
            Keyword::Fairness,
        ];
        let Token::Keyword(word) = found.1 else {
            return None;
        };
        unused.contains(&word).then(|| {
            UnusedWord {
                found: self.place(found),
            }
            .diagnostic()
        })
    }

    /// A name that resembles an accepted keyword and is not followed by what follows a name.
    pub(super) fn misspelled_word(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let (Token::Name(name) | Token::Constant(name)) = found.1 else {
            return None;
        };
        let behind = self.behind(found);
        if [":=", "<-", "(", "[", "."]
            .iter()
            .any(|sign| behind.starts_with(sign))
        {
            return None;
        }
        let suggestion = expected.nearest(name)?.to_owned();
        Some(
            UnknownWord {
                found: self.place(found),
                meant: suggestion,
            }
            .diagnostic(),
        )
    }

    /// Text before `asm` or `module`.
    pub(super) fn missing_heading(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let first = self.nesting.declaration().is_none() && expected.item();
        first.then(|| {
            NoHeading {
                at: self.span(found),
            }
            .diagnostic()
        })
    }

    /// `f = 1` among declarations, without `function`.
    pub(super) fn missing_function(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let among = expected.item() && !self.declares(&[Keyword::Rule]);
        let defined = matches!(found.1, Token::Name(_)) && self.behind(found).starts_with('=');
        let (after, _) = self.place(self.nesting.previous?);
        (among && defined).then(|| {
            MissingWord {
                word: "function",
                after: format!("`{after}`"),
                at: self.span(found),
                opener: None,
            }
            .diagnostic()
        })
    }

    /// A missing keyword or sign between the parts of a construct.
    pub(super) fn missing_word(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        if expected.term() || expected.rule() || expected.item() {
            return None;
        }
        let (word, after, opener) = self
            .missing_in_binder(expected)
            .or_else(|| self.missing_in_construct(expected))
            .or_else(|| self.missing_in_declaration(expected))?;
        let opener = opener.map(|opener| self.place(opener));
        Some(
            MissingWord {
                word,
                after,
                at: self.span(found),
                opener,
            }
            .diagnostic(),
        )
    }

    fn missing_in_binder(&self, expected: &Expected<'_>) -> Option<Missing<'input>> {
        let Some((_, Token::Variable(name), _)) = self.nesting.previous else {
            return None;
        };
        let binder = expected.has("in") && !expected.operator();
        binder.then(|| ("in", format!("the variable `{name}`"), None))
    }

    fn missing_in_construct(&self, expected: &Expected<'_>) -> Option<Missing<'input>> {
        let innermost = self.nesting.innermost()?;
        if let Some(prefix) = innermost.prefix.filter(|_| expected.has("do")) {
            let after = format!("the {} of `{}`", head(prefix.1), prefix.1);
            return Some(("do", after, Some(prefix)));
        }
        let Token::Keyword(word) = innermost.opener.1 else {
            return None;
        };
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "only a few keywords open a construct with a part that is often forgotten"
        )]
        let (missing, after) = match word {
            Keyword::If if expected.has("then") => ("then", "the guard of `if`"),
            Keyword::Switch if expected.has(":") => (":", "the term of `case`"),
            Keyword::Switch if expected.has("case") && !expected.has("endswitch") => {
                ("case", "the term of `switch`")
            }
            Keyword::Let if expected.has("in") => ("in", "the bindings of `let`"),
            _ => return None,
        };
        Some((missing, after.to_owned(), Some(innermost.opener)))
    }

    fn missing_in_declaration(&self, expected: &Expected<'_>) -> Option<Missing<'input>> {
        if self.nesting.open().next().is_some() || expected.operator() {
            return None;
        }
        let words = ["=", ":", "over", "domain", "subsetof", "rule"];
        let word = words.into_iter().find(|word| expected.has(word))?;
        let (before, _) = self.place(self.nesting.previous?);
        Some((word, format!("`{before}`"), None))
    }
}

/// Returns the name of the part between a rule's keyword and its `do`.
fn head(prefix: Token<'_>) -> &'static str {
    if let Token::Keyword(Keyword::While | Keyword::Whilerec) = prefix {
        "guard"
    } else {
        "variables"
    }
}
