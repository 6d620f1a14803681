//! Lists: what stands in brackets with commas between.

use super::layout::{Break, Layout};
use super::operator::{LOOSEST, NOT, Place};
use crate::ast::*;
use crate::lexer::Sign;

impl Layout<'_> {
    /// Things with commas between, in the brackets that come next.
    pub(super) fn list<T>(
        &mut self,
        items: &[T],
        between: Break,
        print: impl FnMut(&mut Self, &T),
    ) {
        self.enclosed(Break::Soft, |list| list.items(items, between, print));
    }

    /// The same; where the text begins a line after the bracket, its lines stay.
    pub(super) fn rows<T>(
        &mut self,
        items: &[T],
        between: Break,
        print: impl FnMut(&mut Self, &T),
    ) {
        if self.second_begins_line() {
            self.enclosed(Break::Hard, |list| list.lines(items, between, print));
        } else {
            self.list(items, between, print);
        }
    }

    fn enclosed(&mut self, begin: Break, inside: impl FnOnce(&mut Self)) {
        self.group(|list| {
            list.token();
            list.indent(|list| {
                list.separate(begin);
                inside(list);
                list.comments_inside();
            });
            list.separate(Break::Soft);
            list.token();
        });
    }

    /// Things with commas or bars between.
    pub(super) fn items<T>(
        &mut self,
        items: &[T],
        between: Break,
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

    /// The same, in the lines of the text.
    fn lines<T>(&mut self, items: &[T], between: Break, mut print: impl FnMut(&mut Self, &T)) {
        for (index, item) in items.iter().enumerate() {
            if index > 0 {
                let before = self.begins_line() && !self.comment_before();
                self.comma();
                let apart = before || self.begins_line();
                self.separate(if apart { Break::Item } else { between });
            }
            print(self, item);
        }
    }

    /// A comma, or the bar between literals.
    fn comma(&mut self) {
        if self.at(Sign::Bar) {
            self.separate(Break::Blank);
        }
        self.token();
    }

    // ── collections ──

    /// `{a : b, s}`.
    pub(super) fn interval(&mut self, interval: &Interval, item: Place) {
        self.token();
        self.indent(|it| {
            it.separate(Break::Soft);
            it.placed(&interval.from, item);
            it.separate(Break::Blank);
            it.token();
            it.separate(Break::Line);
            it.placed(&interval.to, item);
            if let Some(step) = &interval.step {
                it.token();
                it.separate(Break::Line);
                it.placed(step, item);
            }
            it.comments_inside();
        });
        self.separate(Break::Soft);
        self.token();
    }

    /// `{$x in D | g : t}`, `{$x in D | g : k -> v}`.
    pub(super) fn comprehension(
        &mut self,
        comprehension: &Comprehension,
        item: Place,
        value: Option<&Term>,
    ) {
        self.token();
        self.indent(|it| {
            it.separate(Break::Soft);
            it.ranges(&comprehension.binders);
            if let Some(guard) = &comprehension.guard {
                it.separate(Break::Line);
                it.token();
                it.indent(|it| {
                    it.separate(Break::Blank);
                    it.term(guard);
                });
            }
            it.separate(Break::Line);
            it.token();
            it.indent(|it| {
                it.separate(Break::Blank);
                it.placed(&comprehension.item, item);
                if let Some(value) = value {
                    it.arrow(value);
                }
            });
            it.comments_inside();
        });
        if self.at(Sign::Bar) {
            self.separate(Break::Blank);
            self.token();
        }
        self.separate(Break::Soft);
        self.token();
    }

    /// `{k -> v, …}`, `{->}`.
    pub(super) fn map(&mut self, entries: &[(Term, Term)]) {
        if entries.is_empty() {
            return self.joined(3);
        }
        self.rows(entries, Break::Line, |list, (key, value)| {
            list.group(|it| {
                it.term(key);
                it.indent(|it| it.arrow(value));
            });
        });
    }

    fn arrow(&mut self, value: &Term) {
        self.separate(Break::Blank);
        self.token();
        self.separate(Break::Line);
        self.term(value);
    }
}

/// An element of a collection; in a bag, `<` and `>` are brackets.
pub(super) fn element(collection: Collection) -> Place {
    let least = match collection {
        Collection::Set | Collection::Seq => LOOSEST,
        Collection::Bag => NOT,
    };
    Place { least, of: None }
}
