//! Arranges tokens in lines. The tokens and comments come from the source text; the code that
//! traverses the tree determines where lines may be broken.

use super::trivia::TriviaTokens;
use super::{INDENT, WIDTH};
use crate::lexer::{Keyword, Sign, Token};
use asmotion_diagnostics::Span;
use pretty::{Arena, BuildDoc, Doc, DocAllocator, DocBuilder, RefDoc};
use std::borrow::Cow;

pub(super) type LayoutDoc<'text> = DocBuilder<'text, Arena<'text>>;

/// The separator of two tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LayoutBreak {
    /// A blank.
    Blank,
    /// A blank, or a line break if the group does not fit on one line.
    Line,
    /// Nothing, or a line break if the group does not fit on one line.
    Soft,
    /// A blank, or a line break if the next piece does not fit.
    Fill,
    /// Two blanks, because rules have no other separator, or a line break if the group does not fit
    /// on one line.
    Rule,
    /// A line break.
    Hard,
    /// A line break, with a blank line if the source has one.
    Item,
    /// A blank line.
    Section,
}

impl LayoutBreak {
    /// Returns [`LayoutBreak::Hard`] if a break is required, otherwise [`LayoutBreak::Line`].
    pub(super) fn line(must: bool) -> Self {
        if must { Self::Hard } else { Self::Line }
    }

    /// Returns the separator to print: `forced` if a comment requires a line break, `blank` if the
    /// source has a blank line.
    fn resolved(self, forced: bool, blank: bool) -> Self {
        match self {
            Self::Blank | Self::Line | Self::Soft | Self::Fill | Self::Rule if forced => Self::Hard,
            Self::Item if blank => Self::Section,
            Self::Item => Self::Hard,
            Self::Blank | Self::Line | Self::Soft | Self::Fill | Self::Rule => self,
            Self::Hard | Self::Section => self,
        }
    }
}

/// A part of a group.
pub(super) enum LayoutPart<'text> {
    Piece(LayoutDoc<'text>),
    Break(LayoutBreak),
}

/// The kind of the last piece printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LastPrinted {
    Nothing,
    Token,
    /// A comment within a line.
    Comment,
    /// A comment at the end of a line.
    LineEnd,
}

/// Prints the tokens of a text in order.
pub(super) struct TokenLayout<'text> {
    pub(super) arena: &'text Arena<'text>,
    pub(super) tokens: TriviaTokens<'text>,
    /// Index of the next token.
    pub(super) next: usize,
    /// The open groups, outermost first.
    open: Vec<Vec<LayoutPart<'text>>>,
    /// The separator before the next piece: index of its group, and index within the group.
    pub(super) pending: Option<(usize, usize)>,
    pub(super) last: LastPrinted,
    /// Current indentation in characters.
    pub(super) indentation: usize,
}

impl<'text> TokenLayout<'text> {
    pub(super) fn new(arena: &'text Arena<'text>, tokens: TriviaTokens<'text>) -> Self {
        Self {
            arena,
            tokens,
            next: 0,
            open: vec![Vec::new()],
            pending: None,
            last: LastPrinted::Nothing,
            indentation: 0,
        }
    }

    /// Returns the formatted text.
    pub(super) fn finish(mut self) -> String {
        self.leading_comments();
        let parts = self.open.pop().unwrap_or_default();
        let all = self.concat(parts);
        let mut text = String::with_capacity(self.tokens.text.len());
        // writing to a `String` cannot fail
        let _ = all.render_fmt(WIDTH, &mut text);
        with_tabs(&text)
    }

    // ── inspecting the next tokens ──

    /// Returns the next token.
    pub(super) fn peek(&self) -> Option<Token<'text>> {
        self.tokens.get(self.next).map(|(_, token, _)| token)
    }

    /// Returns the token after the next one.
    pub(super) fn peek_second(&self) -> Option<Token<'text>> {
        self.tokens.get(self.next + 1).map(|(_, token, _)| token)
    }

    /// Returns `true` if the next token is this sign.
    pub(super) fn at(&self, sign: Sign) -> bool {
        self.peek() == Some(Token::Sign(sign))
    }

    /// Returns the offset of the next token.
    pub(super) fn start(&self) -> usize {
        self.tokens.start(self.next)
    }

    /// Returns `true` if a complex number follows, possibly in parentheses.
    pub(super) fn complex_follows(&self) -> bool {
        let mut rest = (self.next..).map_while(|index| self.tokens.get(index));
        let first = rest.find(|&(_, token, _)| token != Token::Sign(Sign::Open));
        matches!(first, Some((_, Token::Complex(_), _)))
    }

    /// Returns `true` if the last token is an opening bracket.
    pub(super) fn after_bracket(&self) -> bool {
        let last = self
            .next
            .checked_sub(1)
            .and_then(|last| self.tokens.get(last));
        let Some((_, Token::Sign(sign), _)) = last else {
            return false;
        };
        matches!(sign, Sign::Open | Sign::OpenBrace | Sign::OpenBracket)
    }

    /// Returns `true` if the next token begins a line of the source.
    pub(super) fn begins_line(&self) -> bool {
        self.tokens.gap(self.next).breaks
    }

    /// Returns `true` if a comment directly precedes the next token.
    pub(super) fn comment_before(&self) -> bool {
        self.last == LastPrinted::LineEnd || !self.tokens.gap(self.next).leading.is_empty()
    }

    /// Returns `true` if the token after the next one begins a line of the source.
    pub(super) fn second_begins_line(&self) -> bool {
        self.tokens.gap(self.next + 1).breaks
    }

    /// Returns `true` if the token after the next one is on the same line of the source, without a
    /// comment between.
    pub(super) fn goes_on(&self) -> bool {
        let gap = self.tokens.gap(self.next + 1);
        !gap.breaks && gap.leading.is_empty()
    }

    /// Returns `true` if the source has this span on several lines.
    pub(super) fn in_lines(&self, span: Span) -> bool {
        let range = span.range();
        self.tokens.several_lines(range.start, range.end)
    }

    /// Returns the number of pairs of parentheses around the text from the next token to the end of
    /// `span`.
    pub(super) fn brackets_around(&self, span: Span) -> usize {
        self.tokens.brackets_around(self.next, span.range().end)
    }

    // ── groups ──

    /// Prints a group: on one line if it fits, otherwise with a line break at each
    /// [`LayoutBreak::Line`] and [`LayoutBreak::Soft`] directly inside it.
    pub(super) fn group(&mut self, inside: impl FnOnce(&mut Self)) {
        self.nested(inside, |piece| piece.group());
    }

    /// Indents the lines that begin inside.
    pub(super) fn indent(&mut self, inside: impl FnOnce(&mut Self)) {
        self.indentation += INDENT;
        self.nested(inside, |piece| piece.nest(INDENT.cast_signed()));
        self.indentation -= INDENT;
    }

    fn nested(
        &mut self,
        inside: impl FnOnce(&mut Self),
        wrap: impl FnOnce(LayoutDoc<'text>) -> LayoutDoc<'text>,
    ) {
        self.comments_outside();
        self.open.push(Vec::new());
        inside(self);
        let parts = self.open.pop().unwrap_or_default();
        let piece = wrap(self.concat(parts));
        self.push(LayoutPart::Piece(piece));
    }

    fn concat(&mut self, parts: Vec<LayoutPart<'text>>) -> LayoutDoc<'text> {
        self.pending = self.pending.filter(|&(group, _)| group < self.open.len());
        let pieces = parts.into_iter().map(|part| match part {
            LayoutPart::Piece(piece) => piece,
            LayoutPart::Break(at) => self.space(at),
        });
        self.arena.concat(pieces)
    }

    fn space(&self, at: LayoutBreak) -> LayoutDoc<'text> {
        match at {
            LayoutBreak::Blank => self.arena.space(),
            LayoutBreak::Line => self.arena.line(),
            LayoutBreak::Soft => self.arena.line_(),
            LayoutBreak::Fill => self.arena.softline(),
            LayoutBreak::Rule => self.arena.hardline().flat_alt(self.arena.text("  ")),
            LayoutBreak::Hard | LayoutBreak::Item => self.arena.hardline(),
            LayoutBreak::Section => self.arena.hardline().append(self.arena.hardline()),
        }
    }

    // ── pieces ──

    /// Sets the separator before the next token, replacing an earlier one.
    pub(super) fn separate(&mut self, at: LayoutBreak) {
        if self.last == LastPrinted::Nothing {
            return;
        }
        self.drop_break();
        let group = self.open.len() - 1;
        self.push(LayoutPart::Break(at));
        let part = self.open.last().map_or(0, |parts| parts.len() - 1);
        self.pending = Some((group, part));
    }

    /// Prints the next token with its comments.
    pub(super) fn token(&mut self) {
        let Some((start, token, end)) = self.tokens.get(self.next) else {
            return;
        };
        self.leading_comments();
        let blank = self.tokens.gap(self.next).blank;
        self.place(false, blank);
        let text = match token {
            Token::Keyword(Keyword::Exist) => Keyword::Exists.spelling(),
            Token::Sign(Sign::Dots) => Sign::Colon.spelling(),
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
            | Token::Start(_) => self.tokens.text.get(start..end).unwrap_or(""),
        };
        self.push(LayoutPart::Piece(self.text(text)));
        self.last = LastPrinted::Token;
        self.next += 1;
        self.trailing_comments();
    }

    /// Prints the next `count` tokens without separators.
    pub(super) fn joined(&mut self, count: usize) {
        for _ in 0..count {
            self.token();
        }
    }

    /// Prints the tokens before a span, each followed by a blank.
    pub(super) fn words_before(&mut self, place: Span) {
        while self.start() < place.range().start {
            self.token();
            self.separate(LayoutBreak::Blank);
        }
    }

    /// Omits the next token but keeps its comments.
    pub(super) fn leave_out(&mut self) {
        let mut before = std::mem::take(self.tokens.gap_mut(self.next));
        self.next += 1;
        if before.leading.is_empty() {
            return self.trailing_comments();
        }
        let after = self.tokens.gap_mut(self.next);
        before.leading.append(&mut after.trailing);
        before.leading.append(&mut after.leading);
        after.leading = before.leading;
    }

    pub(super) fn push(&mut self, part: LayoutPart<'text>) {
        if let Some(parts) = self.open.last_mut() {
            parts.push(part);
        }
    }

    fn text(&self, text: &'text str) -> LayoutDoc<'text> {
        self.text_of_width(text, text.chars().count())
    }

    pub(super) fn text_of_width(
        &self,
        text: impl Into<Cow<'text, str>>,
        width: usize,
    ) -> LayoutDoc<'text> {
        let text: RefDoc<'text> = self.arena.alloc(match text.into() {
            Cow::Borrowed(text) => Doc::BorrowedText(text),
            Cow::Owned(text) => Doc::OwnedText(text.into()),
        });
        DocBuilder(self.arena, BuildDoc::Doc(Doc::RenderLen(width, text)))
    }

    /// Resolves the separator before a piece, which begins a new line if `own_line` is set.
    pub(super) fn place(&mut self, own_line: bool, blank: bool) {
        let forced = own_line || self.last == LastPrinted::LineEnd;
        let pending = self.pending.take();
        if let Some((group, part)) = pending {
            if let Some(LayoutPart::Break(at)) = self
                .open
                .get_mut(group)
                .and_then(|parts| parts.get_mut(part))
            {
                *at = at.resolved(forced, blank);
            }
            return;
        }
        match self.last {
            LastPrinted::Nothing => {}
            LastPrinted::Token | LastPrinted::Comment | LastPrinted::LineEnd if forced => {
                self.push(LayoutPart::Break(LayoutBreak::Item.resolved(true, blank)));
            }
            LastPrinted::Comment => self.push(LayoutPart::Break(LayoutBreak::Blank)),
            LastPrinted::Token | LastPrinted::LineEnd => {}
        }
    }

    /// Removes the separator before the next piece.
    pub(super) fn drop_break(&mut self) {
        if let Some((group, part)) = self.pending.take()
            && let Some(part) = self
                .open
                .get_mut(group)
                .and_then(|parts| parts.get_mut(part))
        {
            *part = LayoutPart::Piece(self.arena.nil());
        }
    }
}

/// Replaces indentation by tabs, and trims the ends of lines and of the text.
fn with_tabs(text: &str) -> String {
    let mut all = String::with_capacity(text.len());
    for line in text.lines() {
        let line = line.trim_end();
        let inside = line.trim_start_matches(' ');
        let blanks = line.len() - inside.len();
        all.extend(std::iter::repeat_n('\t', blanks / INDENT));
        all.extend(std::iter::repeat_n(' ', blanks % INDENT));
        all.push_str(inside);
        all.push('\n');
    }
    all
}
