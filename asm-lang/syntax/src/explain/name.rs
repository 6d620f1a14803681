//! Names of the wrong kind, and tokens that cannot be names.

use super::{Expected, Explainer};
use crate::codes::l054::ReservedName;
use crate::codes::l055::ComplexName;
use crate::codes::l056::Misnamed;
use crate::lexer::{Keyword, Sign, SpannedToken, Token};
use asmotion_diagnostics::{Diagnostic, Finding};

impl<'input> Explainer<'input, '_> {
    /// A complex number such as `i` or `i1` where a name is expected.
    pub(super) fn complex_name(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let named = expected.name().map(|(what, _)| what);
        let what = named.or(expected.rule().then_some("a function"))?;
        matches!(found.1, Token::Complex(_)).then(|| {
            ComplexName {
                found: self.place(found),
                what,
            }
            .diagnostic()
        })
    }

    /// A name of another kind, or a reserved word.
    pub(super) fn wrong_name(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let (what, beginning) = self.named(found, expected)?;
        let place = self.place(found);
        let after_comma = matches!(
            self.nesting.previous,
            Some((_, Token::Sign(Sign::Comma), _))
        );
        let better = match (found.1, what) {
            // after a comma, a missing name is more likely
            (Token::Keyword(_), _) if after_comma => return None,
            (Token::Keyword(_), _) => {
                return Some(ReservedName { found: place, what }.diagnostic());
            }
            (Token::Name(name), "a domain") => Some(recased(name, char::to_ascii_uppercase)),
            (Token::Name(name), "an enumeration literal") => Some(name.to_uppercase()),
            (Token::Constant(name), "a function") => Some(recased(name, char::to_ascii_lowercase)),
            (Token::Name(name), "a rule") => Some(format!("r_{name}")),
            (Token::Name(name), "a variable") => Some(format!("${name}")),
            (Token::Name(_) | Token::Constant(_) | Token::Rule(_) | Token::Variable(_), _) => None,
            _ => return None,
        };
        Some(
            Misnamed {
                what,
                beginning,
                found: place,
                better,
            }
            .diagnostic(),
        )
    }

    /// Returns what is to be named at a token, and how such a name begins.
    fn named(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<(&'static str, &'static str)> {
        let updated = matches!(found.1, Token::Constant(_))
            && expected.rule()
            && [":=", "("]
                .iter()
                .any(|sign| self.behind(found).starts_with(sign));
        if updated {
            return Some(("a function", "a lower-case letter"));
        }
        let (what, beginning) = expected.name()?;
        let in_braces = self.nesting.innermost()?.opener.1 == Token::Sign(Sign::OpenBrace);
        let literal = what == "a domain" && in_braces && self.declares(&[Keyword::Domain]);
        Some((
            if literal {
                "an enumeration literal"
            } else {
                what
            },
            beginning,
        ))
    }
}

/// Changes the case of the first letter.
fn recased(name: &str, case: fn(&char) -> char) -> String {
    let mut characters = name.chars();
    let first = characters.next().map(|first| case(&first));
    first.into_iter().chain(characters).collect()
}
