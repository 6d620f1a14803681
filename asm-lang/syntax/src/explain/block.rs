//! Errors in block structure: missing or superfluous closing tokens, too many or too few rules.

use super::{Expected, Explainer};
use crate::codes::l009::ForeignSign;
use crate::codes::l031::UnclosedBlock;
use crate::codes::l032::UnclosedElseIf;
use crate::codes::l033::ClosesNothing;
use crate::codes::l034::SeveralRules;
use crate::codes::l035::MissingRule;
use crate::codes::l037::CallWithoutBrackets;
use crate::codes::l038::BareQuantifier;
use crate::codes::l053::UnknownWord;
use crate::lexer::{Keyword, Sign, SpannedToken, Token};
use crate::nesting::{opener, starts_item};
use crate::spelling::nearest;
use asmotion_diagnostics::{Diagnostic, Finding};

impl<'input> Explainer<'input, '_> {
    /// A token that cannot stand within the innermost open construct.
    pub(super) fn unclosed(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let (open, missing) = self.missing_end(expected)?;
        let in_brackets = matches!(open.opener.1, Token::Sign(_));
        let outside = ends(found.1) || goes_on(found.1) || (in_brackets && self.begins_line(found));
        if !outside {
            return None;
        }
        let is_default = found.1 == Token::Keyword(Keyword::Default);
        if is_default && expected.has("otherwise") && !self.precedes_init(found) {
            return Some(
                ForeignSign {
                    found: "default".to_owned(),
                    meant: "otherwise",
                    text: "otherwise".to_owned(),
                    at: self.span(found),
                }
                .diagnostic(),
            );
        }
        if let Some(suspect) = open.suspect.map(|suspect| self.place(suspect))
            && nearest(&suspect.0, [missing.as_str()]).is_some()
        {
            return Some(
                UnknownWord {
                    found: suspect,
                    meant: missing,
                }
                .diagnostic(),
            );
        }
        if let Some(inner) = open.else_if {
            let (outer, inner) = (self.span(open.opener), self.span(inner));
            return Some(
                UnclosedElseIf {
                    at: self.span(found),
                    outer,
                    inner,
                }
                .diagnostic(),
            );
        }
        let misaligned = self.nesting.misaligned;
        Some(
            UnclosedBlock {
                missing,
                at: self.span(found),
                open: self.place(open.opener),
                misaligned: misaligned.map(|(inner, end)| (self.place(inner), self.place(end))),
            }
            .diagnostic(),
        )
    }

    /// Returns `true` if the next word is `init`, so that `default` begins the section of initial states.
    fn precedes_init(&self, found: SpannedToken<'_>) -> bool {
        let mut words = self.behind(found).split(char::is_whitespace);
        words.next() == Some("init")
    }

    /// A closing token without an opening one.
    pub(super) fn closes_nothing(
        &self,
        found: SpannedToken<'input>,
        _: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let begin = opener(found.1).filter(|_| ends(found.1))?;
        let closes = self.nesting.open().any(|open| open.opener.1 == begin);
        (!closes).then(|| {
            ClosesNothing {
                found: self.place(found),
            }
            .diagnostic()
        })
    }

    /// A second rule in a declaration.
    pub(super) fn several_rules(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let second = self.declares(&[Keyword::Rule]) && expected.item() && begins_rule(found.1);
        second.then_some(
            SeveralRules {
                first: self.span(self.nesting.declaration()?),
                second: self.span(found),
                all: None,
            }
            .diagnostic(),
        )
    }

    /// A missing rule, as in `then else`.
    pub(super) fn missing_rule(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let missing = expected.rule() && !expected.item() && (ends(found.1) || goes_on(found.1));
        missing.then(|| {
            MissingRule {
                found: self.place(found),
                after: self.nesting.previous.map(|previous| self.place(previous)),
            }
            .diagnostic()
        })
    }

    /// A rule name without brackets: `r_x`.
    pub(super) fn call_without_brackets(
        &self,
        _: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let call = self.nesting.previous?;
        let is_call = matches!(call.1, Token::Rule(_)) && expected.has("[") && expected.has("(");
        is_call.then(|| {
            CallWithoutBrackets {
                call: self.place(call),
            }
            .diagnostic()
        })
    }

    /// A quantifier without `(`.
    pub(super) fn bare_quantifier(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let Token::Keyword(word @ (Keyword::Forall | Keyword::Exists | Keyword::Exist)) = found.1
        else {
            return None;
        };
        expected.term().then(|| {
            BareQuantifier {
                word: word.spelling(),
                at: self.span(found),
            }
            .diagnostic()
        })
    }
}

/// Returns `true` if a token closes a construct. `>` is excluded, because it usually compares.
fn ends(token: Token<'_>) -> bool {
    opener(token).is_some() && token != Token::Sign(Sign::Gt)
}

/// Returns `true` if a token continues a construct or begins a declaration, so that something is
/// missing before it.
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

/// Returns `true` if a rule can begin with this token.
fn begins_rule(token: Token<'_>) -> bool {
    if let Token::Keyword(word) = token {
        Expected::RULE.contains(&word.spelling())
    } else {
        matches!(token, Token::Name(_) | Token::Variable(_) | Token::Rule(_))
    }
}
