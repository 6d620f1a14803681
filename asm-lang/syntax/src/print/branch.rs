//! Layout of `if` and `switch`, shared by rules and terms.

use super::layout::{LayoutBreak, TokenLayout};
use crate::ast::*;
use crate::lexer::{Keyword, Token};
use asmotion_diagnostics::Span;

/// A branch of `if` or `switch`: a rule or a term.
pub(super) trait PrintBranch: Sized {
    fn span(&self) -> Span;

    /// Returns its parts if it is an `if` itself.
    fn as_if(&self) -> Option<If<'_, Self>>;

    fn print(&self, layout: &mut TokenLayout<'_>);
}

/// The parts of `if guard then … else … endif`.
pub(super) struct If<'tree, T> {
    guard: &'tree Term,
    then: &'tree T,
    otherwise: Option<&'tree T>,
}

impl<'tree, T> If<'tree, T> {
    /// Collects the parts from a node of the tree.
    pub(super) fn of(guard: &'tree Term, then: &'tree T, otherwise: &'tree Option<T>) -> Self {
        Self {
            guard,
            then,
            otherwise: otherwise.as_ref(),
        }
    }
}

impl PrintBranch for Rule {
    fn span(&self) -> Span {
        self.span
    }

    fn as_if(&self) -> Option<If<'_, Self>> {
        if let RuleKind::If {
            guard,
            then,
            otherwise,
        } = &*self.kind
        {
            Some(If::of(guard, then, otherwise))
        } else {
            None
        }
    }

    fn print(&self, layout: &mut TokenLayout<'_>) {
        layout.rule(self);
    }
}

impl PrintBranch for Term {
    fn span(&self) -> Span {
        self.span
    }

    fn as_if(&self) -> Option<If<'_, Self>> {
        if let TermKind::If {
            guard,
            then,
            otherwise,
        } = &*self.kind
        {
            Some(If::of(guard, then, otherwise))
        } else {
            None
        }
    }

    fn print(&self, layout: &mut TokenLayout<'_>) {
        layout.term(self);
    }
}

impl TokenLayout<'_> {
    /// Prints `if g then … else … endif`; an `else if` on one line stays at the same indentation.
    pub(super) fn choose_if<T: PrintBranch>(&mut self, branch: &If<'_, T>, lines: bool) {
        self.guarded(branch.guard);
        self.branch(branch.then, lines);
        let mut chained = false;
        if let Some(otherwise) = branch.otherwise {
            self.separate(LayoutBreak::line(lines));
            chained = self.else_if();
            self.token();
            match otherwise.as_if().filter(|_| chained) {
                Some(next) => {
                    self.separate(LayoutBreak::Blank);
                    self.choose_if(&next, lines);
                }
                None => self.branch(otherwise, lines),
            }
        }
        self.separate(if chained {
            LayoutBreak::Blank
        } else {
            LayoutBreak::line(lines)
        });
        self.token();
    }

    /// Returns `true` if `else if` follows on one line.
    fn else_if(&self) -> bool {
        self.peek_second() == Some(Token::Keyword(Keyword::If)) && self.goes_on()
    }

    /// Prints `switch t case c: … otherwise … endswitch`.
    pub(super) fn choose_case<T: PrintBranch>(
        &mut self,
        subject: &Term,
        cases: &[(Term, T)],
        otherwise: Option<&T>,
        lines: bool,
    ) {
        self.subject(subject);
        let between = if lines {
            LayoutBreak::Item
        } else {
            LayoutBreak::Line
        };
        self.indent(|it| {
            for (case, body) in cases {
                it.separate(between);
                it.case(case, body);
            }
            if let Some(otherwise) = otherwise {
                it.separate(between);
                it.otherwise(otherwise);
            }
        });
        self.separate(LayoutBreak::line(lines));
        self.token();
    }

    /// Prints `switch t`.
    fn subject(&mut self, subject: &Term) {
        self.token();
        self.indent(|it| {
            it.separate(LayoutBreak::Blank);
            it.term(subject);
        });
    }

    /// Prints `case c: …`.
    fn case<T: PrintBranch>(&mut self, case: &Term, body: &T) {
        let apart = self.in_lines(case.span.to(body.span()));
        self.group(|it| {
            it.token();
            it.indent(|it| {
                it.separate(LayoutBreak::Blank);
                it.term(case);
                it.token();
                it.separate(LayoutBreak::line(apart));
                body.print(it);
                it.comments_inside();
            });
        });
    }

    /// Prints `otherwise …`.
    fn otherwise<T: PrintBranch>(&mut self, body: &T) {
        let place = body.span();
        let apart = self.in_lines(Span {
            start: u32::try_from(self.start()).unwrap_or(place.start),
            ..place
        });
        self.group(|it| {
            it.token();
            it.branch(body, apart);
        });
    }

    /// Prints a branch between keywords.
    pub(super) fn branch<T: PrintBranch>(&mut self, part: &T, lines: bool) {
        self.indent(|it| {
            it.separate(LayoutBreak::line(lines));
            part.print(it);
            it.comments_inside();
        });
    }
}
