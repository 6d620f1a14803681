//! Layout of comments: each keeps its position, and a line comment is followed by a line break.

use super::layout::{LastPrinted, LayoutBreak, LayoutDoc, LayoutPart, TokenLayout};
use super::trivia::{Comment, indentation};
use pretty::DocAllocator;

impl<'text> TokenLayout<'text> {
    /// Prints the comments before the next token that are indented further than it: they belong to
    /// the block that ends here.
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

    /// Prints the comments between a break and the group that follows it, which are not indented
    /// with the lines of the group.
    pub(super) fn comments_outside(&mut self) {
        if self.pending.is_some() && !self.tokens.gap(self.next).leading.is_empty() {
            self.leading_comments();
            self.new_line();
        }
    }

    /// Requests a line break if a comment has ended the last line.
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

    /// Prints a comment with width 0, so that it does not break the line it refers to.
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

    /// Prints a further line of a block comment, keeping its indentation relative to the first
    /// line.
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
