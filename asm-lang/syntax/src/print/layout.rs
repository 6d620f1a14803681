//! Puts tokens on lines: the tokens come from the text, in its order, with their comments; where a
//! line may end is said by who walks the tree.

use super::trivia::TriviaTokens;
use super::{INDENT, WIDTH};
use crate::lexer::{Keyword, Sign, Token};
use asmotion_diagnostics::Span;
use pretty::{Arena, BuildDoc, Doc, DocAllocator, DocBuilder, RefDoc};
use std::borrow::Cow;

pub(super) type LayoutDoc<'text> = DocBuilder<'text, Arena<'text>>;

/// What stands between two tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LayoutBreak {
    /// A blank.
    Blank,
    /// A blank; a new line where the group does not fit on one.
    Line,
    /// Nothing; a new line where the group does not fit on one.
    Soft,
    /// A blank; a new line where the next piece does not fit.
    Fill,
    /// Two blanks, for rules have no sign between; a new line where the group does not fit on one.
    Rule,
    /// A new line.
    Hard,
    /// A new line, and a blank one where the text has some.
    Item,
    /// A blank line.
    Section,
}

impl LayoutBreak {
    /// A new line where it must be, otherwise where the group does not fit on one.
    pub(super) fn line(must: bool) -> Self {
        if must { Self::Hard } else { Self::Line }
    }

    /// What it comes to where a comment asks for a new line, or the text has a blank one.
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

/// What was printed last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LastPrinted {
    Nothing,
    Token,
    /// A comment with something behind it.
    Comment,
    /// A comment with nothing behind it.
    LineEnd,
}

/// Prints the tokens of a text one after the other.
pub(super) struct TokenLayout<'text> {
    pub(super) arena: &'text Arena<'text>,
    pub(super) tokens: TriviaTokens<'text>,
    /// The token to print next.
    pub(super) next: usize,
    /// The groups that are open, from the outside in.
    open: Vec<Vec<LayoutPart<'text>>>,
    /// Where the break before the next piece stands: which group, which part of it.
    pub(super) pending: Option<(usize, usize)>,
    pub(super) last: LastPrinted,
    /// How far lines are indented here.
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

    /// The text, once all is printed.
    pub(super) fn finish(mut self) -> String {
        self.leading_comments();
        let parts = self.open.pop().unwrap_or_default();
        let all = self.concat(parts);
        let mut text = String::with_capacity(self.tokens.text.len());
        // Writing to a `String` does not fail.
        let _ = all.render_fmt(WIDTH, &mut text);
        with_tabs(&text)
    }

    // ── what comes next ──

    /// The token to print next.
    pub(super) fn peek(&self) -> Option<Token<'text>> {
        self.tokens.get(self.next).map(|(_, token, _)| token)
    }

    /// The token after it.
    pub(super) fn peek_second(&self) -> Option<Token<'text>> {
        self.tokens.get(self.next + 1).map(|(_, token, _)| token)
    }

    /// Whether the token to print next is this sign.
    pub(super) fn at(&self, sign: Sign) -> bool {
        self.peek() == Some(Token::Sign(sign))
    }

    /// Where the token to print next begins.
    pub(super) fn start(&self) -> usize {
        self.tokens.start(self.next)
    }

    /// Whether a complex number is printed next, brackets apart.
    pub(super) fn complex_follows(&self) -> bool {
        let mut rest = (self.next..).map_while(|index| self.tokens.get(index));
        let first = rest.find(|&(_, token, _)| token != Token::Sign(Sign::Open));
        matches!(first, Some((_, Token::Complex(_), _)))
    }

    /// Whether an opening bracket was printed last.
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

    /// Whether the token to print next begins a line of the text.
    pub(super) fn begins_line(&self) -> bool {
        self.tokens.gap(self.next).breaks
    }

    /// Whether a comment stands directly before the token to print next.
    pub(super) fn comment_before(&self) -> bool {
        self.last == LastPrinted::LineEnd || !self.tokens.gap(self.next).leading.is_empty()
    }

    /// Whether the token after the next one begins a line of the text.
    pub(super) fn second_begins_line(&self) -> bool {
        self.tokens.gap(self.next + 1).breaks
    }

    /// Whether the token after the next one stands in the same line of the text, without a comment.
    pub(super) fn goes_on(&self) -> bool {
        let gap = self.tokens.gap(self.next + 1);
        !gap.breaks && gap.leading.is_empty()
    }

    /// Whether the text has this in several lines.
    pub(super) fn in_lines(&self, span: Span) -> bool {
        let range = span.range();
        self.tokens.several_lines(range.start, range.end)
    }

    /// How many pairs of brackets enclose exactly what is to be printed next and ends where `span`
    /// does.
    pub(super) fn brackets_around(&self, span: Span) -> usize {
        self.tokens.brackets_around(self.next, span.range().end)
    }

    // ── groups ──

    /// On one line where it fits; otherwise each [`LayoutBreak::Line`] and [`LayoutBreak::Soft`] directly inside
    /// begins a new one.
    pub(super) fn group(&mut self, inside: impl FnOnce(&mut Self)) {
        self.nested(inside, |piece| piece.group());
    }

    /// Lines that begin inside are indented.
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

    /// What stands before the next token; the last word counts.
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

    /// The next token, with its comments.
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
            _ => self.tokens.text.get(start..end).unwrap_or(""),
        };
        self.push(LayoutPart::Piece(self.text(text)));
        self.last = LastPrinted::Token;
        self.next += 1;
        self.trailing_comments();
    }

    /// The next tokens, so many, with nothing between.
    pub(super) fn joined(&mut self, count: usize) {
        for _ in 0..count {
            self.token();
        }
    }

    /// The tokens before this place, with a blank after each.
    pub(super) fn words_before(&mut self, place: Span) {
        while self.start() < place.range().start {
            self.token();
            self.separate(LayoutBreak::Blank);
        }
    }

    /// Leaves the next token out; its comments stay.
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

    /// Decides the break before a piece; on a line of its own where it must be.
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

    /// Takes back the break before the next piece.
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

/// Tabs where lines begin, nothing where they end, one line end at the end.
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
