//! Layout of lists: bracketed items separated by commas.

use super::layout::{LayoutBreak, TokenLayout};
use super::operator::{LOOSEST, NOT, OperandPosition};
use crate::ast::*;
use crate::lexer::Sign;

impl TokenLayout<'_> {
    /// Prints a list in the brackets that follow.
    pub(super) fn list<T>(
        &mut self,
        items: &[T],
        between: LayoutBreak,
        print: impl FnMut(&mut Self, &T),
    ) {
        self.enclosed(LayoutBreak::Soft, |list| list.items(items, between, print));
    }

    /// Prints a list like `list`, but keeps the lines of the source if it has a line break after
    /// the bracket.
    pub(super) fn rows<T>(
        &mut self,
        items: &[T],
        between: LayoutBreak,
        print: impl FnMut(&mut Self, &T),
    ) {
        if self.second_begins_line() {
            self.enclosed(LayoutBreak::Hard, |list| list.lines(items, between, print));
        } else {
            self.list(items, between, print);
        }
    }

    fn enclosed(&mut self, begin: LayoutBreak, inside: impl FnOnce(&mut Self)) {
        self.group(|list| {
            list.token();
            list.indent(|list| {
                list.separate(begin);
                inside(list);
                list.comments_inside();
            });
            list.separate(LayoutBreak::Soft);
            list.token();
        });
    }

    /// Prints items separated by commas or bars.
    pub(super) fn items<T>(
        &mut self,
        items: &[T],
        between: LayoutBreak,
        mut print: impl FnMut(&mut Self, &T),
    ) {
        for (index, item) in items.iter().enumerate() {
            if index > 0 {
                self.comma();
                self.separate(between);
            }
            print(self, item);
        }
    }

    /// Prints items in the lines of the source.
    fn lines<T>(
        &mut self,
        items: &[T],
        between: LayoutBreak,
        mut print: impl FnMut(&mut Self, &T),
    ) {
        for (index, item) in items.iter().enumerate() {
            if index > 0 {
                let before = self.begins_line() && !self.comment_before();
                self.comma();
                let apart = before || self.begins_line();
                self.separate(if apart { LayoutBreak::Item } else { between });
            }
            print(self, item);
        }
    }

    /// Prints a comma, or the bar between enumeration literals.
    fn comma(&mut self) {
        if self.at(Sign::Bar) {
            self.separate(LayoutBreak::Blank);
        }
        self.token();
    }

    // ── collections ──

    /// Prints an interval: `{a : b, s}`.
    pub(super) fn interval(&mut self, interval: &Interval, item: OperandPosition) {
        self.token();
        self.indent(|it| {
            it.separate(LayoutBreak::Soft);
            it.placed(&interval.from, item);
            it.separate(LayoutBreak::Blank);
            it.token();
            it.separate(LayoutBreak::Line);
            it.placed(&interval.to, item);
            if let Some(step) = &interval.step {
                it.token();
                it.separate(LayoutBreak::Line);
                it.placed(step, item);
            }
            it.comments_inside();
        });
        self.separate(LayoutBreak::Soft);
        self.token();
    }

    /// Prints a comprehension: `{$x in D | g : t}`, `{$x in D | g : k -> v}`.
    pub(super) fn comprehension(
        &mut self,
        comprehension: &Comprehension,
        item: OperandPosition,
        value: Option<&Term>,
    ) {
        self.token();
        self.indent(|it| {
            it.separate(LayoutBreak::Soft);
            it.ranges(&comprehension.binders);
            if let Some(guard) = &comprehension.guard {
                it.separate(LayoutBreak::Line);
                it.token();
                it.indent(|it| {
                    it.separate(LayoutBreak::Blank);
                    it.term(guard);
                });
            }
            it.separate(LayoutBreak::Line);
            it.token();
            it.indent(|it| {
                it.separate(LayoutBreak::Blank);
                it.placed(&comprehension.item, item);
                if let Some(value) = value {
                    it.arrow(value);
                }
            });
            it.comments_inside();
        });
        if self.at(Sign::Bar) {
            self.separate(LayoutBreak::Blank);
            self.token();
        }
        self.separate(LayoutBreak::Soft);
        self.token();
    }

    /// Prints a map: `{k -> v, …}`, `{->}`.
    pub(super) fn map(&mut self, entries: &[(Term, Term)]) {
        if entries.is_empty() {
            return self.joined(3);
        }
        self.rows(entries, LayoutBreak::Line, |list, (key, value)| {
            list.group(|it| {
                it.term(key);
                it.indent(|it| it.arrow(value));
            });
        });
    }

    fn arrow(&mut self, value: &Term) {
        self.separate(LayoutBreak::Blank);
        self.token();
        self.separate(LayoutBreak::Line);
        self.term(value);
    }
}

/// Returns the position of an element in a collection; in a bag, `<` and `>` are brackets.
pub(super) fn element(collection: Collection) -> OperandPosition {
    let least = match collection {
        Collection::Set | Collection::Seq => LOOSEST,
        Collection::Bag => NOT,
    };
    OperandPosition { least, of: None }
}
