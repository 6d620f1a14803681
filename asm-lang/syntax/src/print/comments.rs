//! Comments: each stays where it stands, and what follows a line comment begins a new line.

use super::layout::{LastPrinted, LayoutBreak, LayoutDoc, LayoutPart, TokenLayout};
use super::trivia::{Comment, indentation};
use pretty::DocAllocator;

impl<'text> TokenLayout<'text> {
    /// The comments before the next token that stand further right than what follows them: they
    /// belong to the block that ends here.
    pub(super) fn comments_inside(&mut self) {
        let next = self.next;
        let outside = self.tokens.indentation(self.tokens.line_of(next));
        while let Some(comment) = self.tokens.gap_mut(next).leading.pop_front() {
            let further = self.tokens.indentation(comment.start) > outside;
            if comment.own_line && !(further && comment.ends_line) {
                self.tokens.gap_mut(next).leading.push_front(comment);
                return;
            }
            if comment.own_line {
                self.separate(LayoutBreak::Item);
            }
            self.comment(&comment);
        }
    }

    /// The comments between a break and the group that begins behind it: they are not indented with
    /// its lines.
    pub(super) fn comments_outside(&mut self) {
        if self.pending.is_some() && !self.tokens.gap(self.next).leading.is_empty() {
            self.leading_comments();
            self.new_line();
        }
    }

    /// Goes on in a new line where a comment ended the last one.
    pub(super) fn new_line(&mut self) {
        if self.last == LastPrinted::LineEnd && self.pending.is_none() {
            self.separate(LayoutBreak::Item);
        }
    }

    pub(super) fn leading_comments(&mut self) {
        let next = self.next;
        while let Some(comment) = self.tokens.gap_mut(next).leading.pop_front() {
            self.comment(&comment);
        }
    }

    pub(super) fn trailing_comments(&mut self) {
        let next = self.next;
        while let Some(comment) = self.tokens.gap_mut(next).trailing.pop_front() {
            self.drop_break();
            self.push(LayoutPart::Piece(self.text_of_width(" ", 0)));
            self.comment_text(&comment);
        }
    }

    fn comment(&mut self, comment: &Comment<'text>) {
        let touches =
            self.pending.is_none() && self.last == LastPrinted::Token && !self.after_bracket();
        if touches && !comment.own_line {
            self.push(LayoutPart::Break(LayoutBreak::Blank));
        }
        self.place(comment.own_line, comment.blank);
        self.comment_text(comment);
    }

    /// A comment does not count for the width of its line: it may not tear apart what it speaks of.
    fn comment_text(&mut self, comment: &Comment<'text>) {
        let mut lines = comment.text.split('\n');
        let first = lines.next().unwrap_or("").trim_end();
        self.push(LayoutPart::Piece(self.text_of_width(first, 0)));
        let column = self.tokens.indentation(comment.start);
        for line in lines {
            let line = self.further_line(line, comment.own_line.then_some(column));
            self.push(LayoutPart::Piece(line));
        }
        self.last = if comment.ends_line {
            LastPrinted::LineEnd
        } else {
            LastPrinted::Comment
        };
    }

    /// A line of a comment of several: it moves with the first one where that begins its line.
    fn further_line(&self, line: &'text str, column: Option<usize>) -> LayoutDoc<'text> {
        let newline = self.arena.hardline();
        match column {
            Some(column) => {
                let further = indentation(line).saturating_sub(column);
                let text = " ".repeat(further) + line.trim();
                newline.append(self.text_of_width(text, 0))
            }
            None => newline
                .append(self.text_of_width(line.trim_end(), 0))
                .nest(-self.indentation.cast_signed()),
        }
    }
}
