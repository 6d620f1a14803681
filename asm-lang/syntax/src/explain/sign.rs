//! Signs in the wrong place, or of another notation.

use super::{Expected, Explainer};
use crate::error::SyntaxError;
use crate::lexer::{Keyword, Sign, Spanned, Token};

/// What begins the declaration of a function.
const FUNCTIONS: &[Keyword] = &[
    Keyword::Static,
    Keyword::Derived,
    Keyword::Monitored,
    Keyword::Controlled,
    Keyword::Shared,
    Keyword::Out,
];

impl<'input> Explainer<'input, '_> {
    pub(super) fn wrong_sign(
        &self,
        found: Spanned<'input>,
        expected: &Expected<'_>,
    ) -> Option<SyntaxError> {
        let at = self.span(found);
        let previous = self.nesting.previous.map(|(_, token, _)| token);
        let Token::Sign(sign) = found.1 else {
            let membership = found.1 == Token::Keyword(Keyword::In) && expected.operator();
            return membership.then_some(SyntaxError::InfixMembership { at });
        };
        match sign {
            Sign::Eq if expected.has(":=") => Some(SyntaxError::EqualsForUpdate { at }),
            Sign::Assign if expected.operator() => Some(SyntaxError::UpdateForEquals { at }),
            Sign::Assign if previous == Some(Token::Sign(Sign::CloseBracket)) => {
                Some(SyntaxError::SquareArguments {
                    at: self.span(self.nesting.previous?),
                })
            }
            // The lexer reads `<-` in two where no name of a rule follows.
            Sign::Lt if expected.has("<-") && self.behind(found).starts_with('-') => {
                Some(SyntaxError::ReturnOfNoRule { at })
            }
            Sign::Star if self.declares(FUNCTIONS) => Some(SyntaxError::ProductSign { at }),
            Sign::Arrow if expected.operator() && !expected.has("->") => {
                Some(SyntaxError::Foreign {
                    found: "->".to_owned(),
                    meant: "implies",
                    text: "implies".to_owned(),
                    at,
                })
            }
            Sign::Comma if expected.rule() => Some(SyntaxError::CommaBetweenRules { at }),
            Sign::Open | Sign::OpenBrace | Sign::OpenBracket
                if expected.rule() && !matches!(previous, Some(Token::Rule(_))) =>
            {
                Some(SyntaxError::BracketedRule { at })
            }
            _ => None,
        }
    }
}
