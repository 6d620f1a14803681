//! Bindings without brackets, and comprehensions without a term.

use super::{Expected, Explainer};
use crate::ast::NameText;
use crate::codes::l065::UnbracketedLet;
use crate::codes::l066::MissingElement;
use crate::findings::SyntaxFindings;
use crate::lexer::{Keyword, Lexer, Sign, SpannedToken, Token};
use crate::nesting::closer;
use asmotion_diagnostics::{Diagnostic, FileId, Finding, Span};

/// Limit for the number of tokens that an explanation reads.
const TOKENS: usize = 2000;

const OPENING: [Token<'static>; 3] = [
    Token::Sign(Sign::Open),
    Token::Sign(Sign::OpenBrace),
    Token::Sign(Sign::OpenBracket),
];

const CLOSING: [Token<'static>; 3] = [
    Token::Sign(Sign::Close),
    Token::Sign(Sign::CloseBrace),
    Token::Sign(Sign::CloseBracket),
];

impl<'input> Explainer<'input, '_> {
    /// Explains `let $x = 1 in`, whose first name is at `start`.
    pub(crate) fn bare_let(&self, name: &NameText, start: usize, unmarked: bool) -> UnbracketedLet {
        let end = self.end_of_bindings(start);
        UnbracketedLet {
            at: name.span,
            bindings: end.map(|end| self.findings.span(start, end)),
            unmarked,
            names: end
                .filter(|_| unmarked)
                .and_then(|end| self.unmarked_names(start, end))
                .unwrap_or_default(),
        }
    }

    /// Returns the end of the token before the `in` that belongs to bindings.
    fn end_of_bindings(&self, start: usize) -> Option<usize> {
        let (mut depth, mut lets, mut last) = (0_u32, 0_u32, start);
        for (_, token, end) in self.tokens_from(start) {
            if OPENING.contains(&token) {
                depth += 1;
            } else if CLOSING.contains(&token) {
                depth = depth.checked_sub(1)?;
            } else if token == Token::Sign(Sign::Assign) {
                return None;
            } else if depth == 0 && token == Token::Keyword(Keyword::Let) {
                lets += 1;
            } else if depth == 0 && token == Token::Keyword(Keyword::In) {
                if lets == 0 {
                    return Some(last);
                }
                lets -= 1;
            }
            last = end;
        }
        None
    }

    /// Returns the names without `$` in the bindings from `start` to `end`, and their uses up to `endlet`. Returns `None` if
    /// a name is also used in a term of the bindings, where it may be a function, or if there is no `endlet`.
    fn unmarked_names(&self, start: usize, end: usize) -> Option<Vec<Span>> {
        let tokens: Vec<SpannedToken<'input>> = self.tokens_from(start).collect();
        let bindings = tokens.iter().take_while(|(_, _, behind)| *behind <= end);
        let (bindings, body) = tokens.split_at(bindings.count());
        let (mut depth, mut begins, mut names, mut places) = (0_u32, true, Vec::new(), Vec::new());
        for token in bindings {
            if OPENING.contains(&token.1) {
                depth += 1;
            } else if CLOSING.contains(&token.1) {
                depth = depth.checked_sub(1)?;
            }
            if let (Token::Name(name), true) = (token.1, begins) {
                names.push(name);
                places.push(self.span(*token));
            }
            begins = depth == 0 && token.1 == Token::Sign(Sign::Comma);
        }
        let is_use = |token: &Token<'_>| matches!(token, Token::Name(name) if names.contains(name));
        if bindings
            .iter()
            .filter(|(_, token, _)| is_use(token))
            .count()
            > places.len()
        {
            return None;
        }
        let mut lets = 0_u32;
        for (index, token) in body.iter().enumerate() {
            if token.1 == Token::Keyword(Keyword::Let) {
                lets += 1;
            } else if token.1 == Token::Keyword(Keyword::Endlet) {
                if lets == 0 {
                    return Some(places);
                }
                lets -= 1;
            }
            let is_applied = matches!(body.get(index + 1), Some((_, Token::Sign(Sign::Open), _)));
            if is_use(&token.1) && !is_applied {
                places.push(self.span(*token));
            }
        }
        None
    }

    /// Explains `{$x in D | guard}`.
    pub(super) fn missing_element(
        &self,
        found: SpannedToken<'input>,
        expected: &Expected<'_>,
    ) -> Option<Diagnostic> {
        let open = self.nesting.innermost()?.opener;
        if closer(open.1) != Some(found.1) || !expected.has(":") {
            return None;
        }
        let mut inside = self
            .tokens_from(open.2)
            .take_while(|(start, ..)| *start < found.0);
        let (Some((_, Token::Variable(first), _)), Some((_, Token::Keyword(Keyword::In), _))) =
            (inside.next(), inside.next())
        else {
            return None;
        };
        // a second binder follows a comma
        let binders = inside.filter(|(_, token, _)| *token == Token::Keyword(Keyword::In));
        let is_only = binders.count() == 0;
        let (_, _, behind) = self.nesting.previous?;
        Some(
            MissingElement {
                at: self.span(found),
                opened: self.span(open),
                variable: is_only.then(|| first.to_owned()),
                behind: self.place_of(behind),
            }
            .diagnostic(),
        )
    }

    fn place_of(&self, offset: usize) -> Span {
        self.findings.span(offset, offset)
    }

    /// Reads tokens from an offset; findings about them are reported elsewhere.
    fn tokens_from(
        &self,
        start: usize,
    ) -> impl Iterator<Item = SpannedToken<'input>> + use<'input> {
        let unheard = SyntaxFindings::new(FileId(0));
        let mut lexer = Lexer::new(self.text, &unheard);
        lexer.start_at(start);
        let tokens: Vec<SpannedToken<'input>> = lexer.take(TOKENS).collect();
        tokens.into_iter()
    }
}
