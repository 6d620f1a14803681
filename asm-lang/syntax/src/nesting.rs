//! Tracks open constructs, which bounds the parser's stack and provides context for messages.

use crate::ast::MAX_DEPTH;
use crate::codes::l039::NestedTooDeep;
use crate::findings::SyntaxFindings;
use crate::lexer::{Keyword, Lexer, Sign, SpannedToken, Token};
use crate::spelling::nearest;

/// A bracket, a block or a declaration that has begun but not ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpenConstruct<'input> {
    /// The token that opened it.
    pub(crate) opener: SpannedToken<'input>,
    /// The first keyword of an unfinished rule that ends with another rule, such as `forall`.
    pub(crate) prefix: Option<SpannedToken<'input>>,
    /// The `if` that directly follows the `else` of this one.
    pub(crate) else_if: Option<SpannedToken<'input>>,
    /// A name directly inside that resembles the closing keyword.
    pub(crate) suspect: Option<SpannedToken<'input>>,
    /// Indentation of the opening token if it is the first of its line.
    indent: Option<usize>,
    /// Number of directly nested rules that end with another rule.
    chain: u32,
    /// Nesting depth of the enclosing constructs.
    outside: u32,
    /// `true` if `>` compares, as in the range and the guard of a bag.
    compares: bool,
}

/// The constructs that are open after the tokens read so far.
#[derive(Debug)]
pub(crate) struct Nesting<'input> {
    text: &'input str,
    /// Open constructs, outermost first; the first one is the declaration.
    open: Vec<OpenConstruct<'input>>,
    pub(crate) previous: Option<SpannedToken<'input>>,
    /// The first closing token that is indented differently from its opening token, with that
    /// token.
    pub(crate) misaligned: Option<(SpannedToken<'input>, SpannedToken<'input>)>,
    /// Number of consecutive signs and `not`s.
    signs: u32,
}

impl<'input> Nesting<'input> {
    pub(crate) fn new(text: &'input str) -> Self {
        Self {
            text,
            open: Vec::new(),
            previous: None,
            misaligned: None,
            signs: 0,
        }
    }

    /// Returns the first token of the current declaration.
    pub(crate) fn declaration(&self) -> Option<SpannedToken<'input>> {
        self.open.first().map(|open| open.opener)
    }

    /// Iterates over the open constructs, innermost first, without the declaration.
    pub(crate) fn open(&self) -> impl Iterator<Item = &OpenConstruct<'input>> {
        self.open.iter().skip(1).rev()
    }

    /// Returns the innermost open construct, possibly the declaration.
    pub(crate) fn innermost(&self) -> Option<&OpenConstruct<'input>> {
        self.open.last()
    }

    /// Returns the nesting depth of the next token; the size of the parser's stack is a small
    /// multiple of it.
    fn depth(&self) -> u32 {
        self.signs + self.open.last().map_or(0, |open| open.outside + open.chain)
    }

    /// Processes the next token.
    pub(crate) fn step(&mut self, spanned: SpannedToken<'input>) {
        let (_, token, _) = spanned;
        let operand_before = self
            .previous
            .is_some_and(|(_, token, _)| token.ends_operand());
        if starts_item(token) {
            self.open.clear();
            self.misaligned = None;
            self.push(spanned);
        } else if let Some(opener) = opener(token) {
            self.close(opener, spanned);
        } else if closer(token).is_some() || (is_lt(token) && !operand_before) {
            self.mark_else_if(spanned);
            self.push(spanned);
        } else {
            self.inside(token, spanned);
        }
        let sign = matches!(
            token,
            Token::Keyword(Keyword::Not) | Token::Sign(Sign::Plus | Sign::Minus)
        );
        self.signs = if sign && !operand_before {
            self.signs + 1
        } else {
            0
        };
        self.previous = Some(spanned);
    }

    fn push(&mut self, opener: SpannedToken<'input>) {
        let outside = 1 + self.depth();
        if outside > MAX_DEPTH + 1 {
            return; // deeper than any caller looks
        }
        self.open.push(OpenConstruct {
            opener,
            prefix: None,
            else_if: None,
            suspect: None,
            indent: self.indent(opener),
            chain: 0,
            outside,
            compares: false,
        });
    }

    /// Returns the indentation of a token if it is the first of its line.
    fn indent(&self, (start, _, _): SpannedToken<'_>) -> Option<usize> {
        let before = self.text.as_bytes().get(..start)?;
        let blanks = before
            .iter()
            .rev()
            .take_while(|&&byte| byte == b' ' || byte == b'\t')
            .count();
        before
            .get(..start - blanks)?
            .last()
            .is_none_or(|&byte| byte == b'\n')
            .then_some(blanks)
    }

    /// Closes the innermost `opener` together with everything left open inside it.
    fn close(&mut self, opener: Token<'_>, closer: SpannedToken<'input>) {
        let same = |open: &OpenConstruct<'_>| open.opener.1 == opener;
        let Some(at) = self.open.iter().rposition(same).filter(|&at| at > 0) else {
            return;
        };
        let Some(open) = self.open.get(at) else {
            return;
        };
        // in the guard of a bag, and in constructs open inside it, `>` compares
        if is_lt(opener) && (open.compares || at + 1 < self.open.len()) {
            return;
        }
        if self.misaligned.is_none()
            && let (Some(begun), Some(ended)) = (open.indent, self.indent(closer))
            && begun != ended
        {
            self.misaligned = Some((open.opener, closer));
        }
        self.open.truncate(at);
    }

    fn mark_else_if(&mut self, spanned: SpannedToken<'input>) {
        let after_else = matches!(self.previous, Some((_, Token::Keyword(Keyword::Else), _)));
        if let Some(open) = self.open.last_mut()
            && after_else
            && spanned.1 == Token::Keyword(Keyword::If)
        {
            open.else_if = Some(spanned);
        }
    }

    /// Processes a token that neither opens nor closes a construct.
    fn inside(&mut self, token: Token<'input>, spanned: SpannedToken<'input>) {
        let nested = matches!(
            self.previous,
            Some((_, Token::Keyword(Keyword::Do | Keyword::Ifnone), _))
        );
        let Some(open) = self.open.last_mut() else {
            return;
        };
        match token {
            Token::Keyword(
                Keyword::Choose
                | Keyword::Forall
                | Keyword::Extend
                | Keyword::While
                | Keyword::Whilerec,
            ) => {
                open.chain = if nested { open.chain + 1 } else { 1 };
                open.prefix = Some(spanned);
            }
            // the text after `local f: D [R]` cannot be distinguished from that after a call
            Token::Keyword(Keyword::Local) => open.chain += 1,
            Token::Keyword(Keyword::Do) => open.prefix = None,
            Token::Name(name) if name.starts_with('e') => {
                let end = closer(open.opener.1).map(|end| end.to_string());
                if nearest(name, end.as_deref()).is_some() {
                    open.suspect = Some(spanned);
                }
            }
            Token::Keyword(Keyword::In) => open.compares = true,
            Token::Sign(Sign::Colon) => open.compares = false,
            Token::Keyword(_)
            | Token::Sign(_)
            | Token::Name(_)
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
            | Token::Text(_)
            | Token::Start(_) => {}
        }
    }
}

/// The tokens of a text for the parser, with limits on nesting and on errors.
#[derive(Debug)]
pub(crate) struct NestedTokens<'input, 'run> {
    pub(crate) lexer: Lexer<'input, 'run>,
    nesting: Nesting<'input>,
    findings: &'run SyntaxFindings,
}

impl<'input, 'run> NestedTokens<'input, 'run> {
    pub(crate) fn new(text: &'input str, findings: &'run SyntaxFindings) -> Self {
        Self {
            lexer: Lexer::new(text, findings),
            nesting: Nesting::new(text),
            findings,
        }
    }

    /// Skips the text up to the next declaration.
    fn next_item(&mut self) -> Option<SpannedToken<'input>> {
        self.lexer
            .by_ref()
            .find(|&(_, token, _)| starts_item(token))
    }
}

impl<'input> Iterator for NestedTokens<'input, '_> {
    type Item = SpannedToken<'input>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.findings.is_full() {
            return None;
        }
        let mut spanned = self.lexer.next()?;
        self.nesting.step(spanned);
        let too_deep = self.nesting.depth() > MAX_DEPTH;
        if too_deep {
            let at = self.findings.span(spanned.0, spanned.2);
            self.findings.report(NestedTooDeep { at });
        }
        if too_deep || self.findings.token_taken() {
            spanned = self.next_item()?;
            self.nesting.step(spanned);
        }
        Some(spanned)
    }
}

/// Returns `true` if this token can only begin a declaration, a section or a part of one.
pub(crate) fn starts_item(token: Token<'_>) -> bool {
    let Token::Keyword(word) = token else {
        return false;
    };
    matches!(
        word,
        Keyword::Asm
            | Keyword::Module
            | Keyword::Asyncr
            | Keyword::Import
            | Keyword::Export
            | Keyword::Signature
            | Keyword::Definitions
            | Keyword::Default
            | Keyword::Init
            | Keyword::Agent
            | Keyword::Domain
            | Keyword::Anydomain
            | Keyword::Basic
            | Keyword::Abstract
            | Keyword::Enum
            | Keyword::Function
            | Keyword::Static
            | Keyword::Derived
            | Keyword::Monitored
            | Keyword::Controlled
            | Keyword::Shared
            | Keyword::Out
            | Keyword::Rule
            | Keyword::Macro
            | Keyword::Turbo
            | Keyword::Main
            | Keyword::Invariant
            | Keyword::Invar
            | Keyword::Justice
            | Keyword::Compassion
            | Keyword::Ctlspec
            | Keyword::Ltlspec
    )
}

/// Opening tokens with their closing tokens.
const PAIRS: &[(Token<'static>, Token<'static>)] = &[
    (Token::Sign(Sign::Open), Token::Sign(Sign::Close)),
    (Token::Sign(Sign::OpenBrace), Token::Sign(Sign::CloseBrace)),
    (
        Token::Sign(Sign::OpenBracket),
        Token::Sign(Sign::CloseBracket),
    ),
    (Token::Sign(Sign::OpenRule), Token::Sign(Sign::CloseRule)),
    (Token::Keyword(Keyword::If), Token::Keyword(Keyword::Endif)),
    (
        Token::Keyword(Keyword::Switch),
        Token::Keyword(Keyword::Endswitch),
    ),
    (
        Token::Keyword(Keyword::Par),
        Token::Keyword(Keyword::Endpar),
    ),
    (
        Token::Keyword(Keyword::Seq),
        Token::Keyword(Keyword::Endseq),
    ),
    (
        Token::Keyword(Keyword::Let),
        Token::Keyword(Keyword::Endlet),
    ),
    (
        Token::Keyword(Keyword::Iterate),
        Token::Keyword(Keyword::Enditerate),
    ),
];

/// Returns the closing token for an opening one.
pub(crate) fn closer(opener: Token<'_>) -> Option<Token<'static>> {
    PAIRS
        .iter()
        .find(|(begin, _)| *begin == opener)
        .map(|&(_, end)| end)
}

/// Returns `true` if a token continues the construct of an opening one.
pub(crate) fn continues(opener: Token<'_>, token: Token<'_>) -> bool {
    let (Token::Keyword(opener), Token::Keyword(word)) = (opener, token) else {
        return false;
    };
    matches!(
        (opener, word),
        (Keyword::If, Keyword::Then | Keyword::Else)
            | (Keyword::Switch, Keyword::Case | Keyword::Otherwise)
            | (Keyword::Let, Keyword::In)
    )
}

/// Returns the opening token for a closing one; `>` may close a bag.
pub(crate) fn opener(closer: Token<'_>) -> Option<Token<'static>> {
    if closer == Token::Sign(Sign::Gt) {
        return Some(Token::Sign(Sign::Lt));
    }
    PAIRS
        .iter()
        .find(|(_, end)| *end == closer)
        .map(|&(begin, _)| begin)
}

fn is_lt(token: Token<'_>) -> bool {
    token == Token::Sign(Sign::Lt)
}
