//! Misplaced signs, and signs of other languages.

use super::{Expected, Explainer};
use crate::codes::l009::ForeignSign;
use crate::codes::l036::BracketedRule;
use crate::codes::l040::CommaBetweenRules;
use crate::codes::l041::SquareArguments;
use crate::codes::l050::EqualsForUpdate;
use crate::codes::l051::UpdateForEquals;
use crate::codes::l059::ProductSign;
use crate::codes::l060::InfixMembership;
use crate::codes::l061::ReturnOfNoRule;
use crate::codes::l079::BareInterval;
use crate::lexer::{Keyword, Sign, SpannedToken, Token};
use asmotion_diagnostics::{Diagnostic, Finding};

/// Keywords that begin the declaration of a function.
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
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let at = self.span(found);
        let previous = self.nesting.previous.map(|(_, token, _)| token);
        let Token::Sign(sign) = found.1 else {
            let membership = found.1 == Token::Keyword(Keyword::In) && expected.operator();
            return membership.then_some(InfixMembership { at }.diagnostic());
        };
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "only a few signs are typical mistakes"
        )]
        match sign {
            Sign::Eq if expected.has(":=") => Some(EqualsForUpdate { at }.diagnostic()),
            Sign::Assign if expected.operator() => Some(UpdateForEquals { at }.diagnostic()),
            Sign::Assign if previous == Some(Token::Sign(Sign::CloseBracket)) => Some(
                SquareArguments {
                    at: self.span(self.nesting.previous?),
                }
                .diagnostic(),
            ),
            // the lexer splits `<-` unless a rule name follows
            Sign::Lt if expected.has("<-") && self.behind(found).starts_with('-') => {
                Some(ReturnOfNoRule { at }.diagnostic())
            }
            Sign::Dots if expected.operator() => Some(BareInterval { at }.diagnostic()),
            Sign::Star if self.declares(FUNCTIONS) => Some(ProductSign { at }.diagnostic()),
            Sign::Arrow if expected.operator() && !expected.has("->") => Some(
                ForeignSign {
                    found: "->".to_owned(),
                    meant: "implies",
                    text: "implies".to_owned(),
                    at,
                }
                .diagnostic(),
            ),
            Sign::Comma if expected.rule() => Some(CommaBetweenRules { at }.diagnostic()),
            Sign::Open | Sign::OpenBrace | Sign::OpenBracket
                if expected.rule() && !matches!(previous, Some(Token::Rule(_))) =>
            {
                Some(BracketedRule { at }.diagnostic())
            }
            _ => None,
        }
    }
}
