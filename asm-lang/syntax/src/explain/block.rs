//! Beginnings without an end, ends without a beginning, and rules too many or too few.

use super::{Expected, Explainer};
use crate::error::SyntaxError;
use crate::lexer::{Keyword, Sign, Spanned, Token};
use crate::nesting::{opener, starts_item};
use crate::spelling::nearest;

impl<'input> Explainer<'input, '_> {
    /// A token that cannot stand inside of what is open.
    pub(super) fn unclosed(
        &self,
        found: Spanned<'input>,
        expected: &Expected<'_>,
    ) -> Option<SyntaxError> {
        let (open, missing) = self.missing_end(expected)?;
        let in_brackets = matches!(open.opener.1, Token::Sign(_));
        let outside = ends(found.1) || goes_on(found.1) || (in_brackets && self.begins_line(found));
        if !outside {
            return None;
        }
        if found.1 == Token::Keyword(Keyword::Default) && expected.has("otherwise") {
            return Some(SyntaxError::Foreign {
                found: "default".to_owned(),
                meant: "otherwise",
                text: "otherwise".to_owned(),
                at: self.span(found),
            });
        }
        if let Some(suspect) = open.suspect.map(|suspect| self.place(suspect))
            && nearest(&suspect.0, [missing.as_str()]).is_some()
        {
            return Some(SyntaxError::UnknownWord {
                found: suspect,
                meant: missing,
            });
        }
        if let Some(inner) = open.else_if {
            let (outer, inner) = (self.span(open.opener), self.span(inner));
            return Some(SyntaxError::ElseIf {
                at: self.span(found),
                outer,
                inner,
            });
        }
        let misaligned = self.nesting.misaligned;
        Some(SyntaxError::Unclosed {
            missing,
            at: self.span(found),
            open: self.place(open.opener),
            misaligned: misaligned.map(|(inner, end)| (self.place(inner), self.place(end))),
        })
    }

    /// An end without a beginning.
    pub(super) fn closes_nothing(
        &self,
        found: Spanned<'input>,
        _: &Expected<'_>,
    ) -> Option<SyntaxError> {
        let begin = opener(found.1).filter(|_| ends(found.1))?;
        let closes = self.nesting.open().any(|open| open.opener.1 == begin);
        (!closes).then(|| SyntaxError::ClosesNothing {
            found: self.place(found),
        })
    }

    /// A second rule where a declaration has one.
    pub(super) fn several_rules(
        &self,
        found: Spanned<'input>,
        expected: &Expected<'_>,
    ) -> Option<SyntaxError> {
        let second = self.declares(&[Keyword::Rule]) && expected.item() && begins_rule(found.1);
        second.then_some(SyntaxError::SeveralRules {
            first: self.span(self.nesting.declaration()?),
            second: self.span(found),
            all: None,
        })
    }

    /// `then else`: what goes on where a rule has to begin.
    pub(super) fn missing_rule(
        &self,
        found: Spanned<'input>,
        expected: &Expected<'_>,
    ) -> Option<SyntaxError> {
        let missing = expected.rule() && !expected.item() && (ends(found.1) || goes_on(found.1));
        missing.then(|| SyntaxError::NoRule {
            found: self.place(found),
            after: self.nesting.previous.map(|previous| self.place(previous)),
        })
    }

    /// `r_x` alone.
    pub(super) fn call_without_brackets(
        &self,
        _: Spanned<'input>,
        expected: &Expected<'_>,
    ) -> Option<SyntaxError> {
        let call = self.nesting.previous?;
        let is_call = matches!(call.1, Token::Rule(_)) && expected.has("[") && expected.has("(");
        is_call.then(|| SyntaxError::CallWithoutBrackets {
            call: self.place(call),
        })
    }

    /// `exists` without `(`.
    pub(super) fn bare_quantifier(
        &self,
        found: Spanned<'input>,
        expected: &Expected<'_>,
    ) -> Option<SyntaxError> {
        let Token::Keyword(word @ (Keyword::Forall | Keyword::Exists | Keyword::Exist)) = found.1
        else {
            return None;
        };
        expected.term().then(|| SyntaxError::BareQuantifier {
            word: word.spelling(),
            at: self.span(found),
        })
    }
}

/// Whether this token ends something; a `>` may also compare.
fn ends(token: Token<'_>) -> bool {
    opener(token).is_some() && token != Token::Sign(Sign::Gt)
}

/// Whether this token goes on with something begun before, or begins a declaration: it cannot
/// stand where something is still to come.
fn goes_on(token: Token<'_>) -> bool {
    let connects = match token {
        Token::Keyword(word) => matches!(
            word,
            Keyword::Then
                | Keyword::Else
                | Keyword::Case
                | Keyword::Otherwise
                | Keyword::Do
                | Keyword::Ifnone
                | Keyword::With
                | Keyword::In
        ),
        Token::Sign(sign) => matches!(sign, Sign::Assign | Sign::Colon | Sign::Bar | Sign::Arrow),
        _ => false,
    };
    connects || starts_item(token)
}

/// Whether a rule can begin with this token.
fn begins_rule(token: Token<'_>) -> bool {
    match token {
        Token::Name(_) | Token::Variable(_) | Token::Rule(_) => true,
        Token::Keyword(word) => Expected::RULE.contains(&word.spelling()),
        _ => false,
    }
}
