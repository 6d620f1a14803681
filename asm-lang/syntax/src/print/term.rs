//! Layout of terms, which are broken only if they do not fit on one line.

use super::branch::If;
use super::layout::{LayoutBreak, TokenLayout};
use super::list::element;
use super::operator::{LOOSEST, OperandPosition};
use crate::ast::*;
use crate::lexer::{Keyword, Sign, Token};

impl TokenLayout<'_> {
    /// Prints a term in a position that accepts any precedence.
    pub(super) fn term(&mut self, term: &Term) {
        self.placed(
            term,
            OperandPosition {
                least: LOOSEST,
                of: None,
            },
        );
    }

    /// Prints the term after `:=` or `=`, on the next line if it does not fit. Collections begin on
    /// the same line.
    pub(super) fn value(&mut self, term: &Term) {
        let is_collection = matches!(
            *term.kind,
            TermKind::Listed { .. }
                | TermKind::Interval { .. }
                | TermKind::Comprehension { .. }
                | TermKind::Map(_)
                | TermKind::MapComprehension { .. }
        );
        if is_collection && !self.comment_before() {
            self.separate(LayoutBreak::Blank);
            return self.term(term);
        }
        self.indent(|it| {
            it.separate(LayoutBreak::Line);
            it.term(term);
        });
    }

    /// Prints a term without superfluous parentheses.
    pub(super) fn placed(&mut self, term: &Term, place: OperandPosition) {
        self.bracketed(term, place, |it| {
            let lines = it.in_lines(term.span);
            it.group(|it| it.term_kind(&term.kind, lines));
        });
    }

    fn term_kind(&mut self, kind: &TermKind, lines: bool) {
        match kind {
            TermKind::Literal(_)
            | TermKind::Variable(_)
            | TermKind::Constant(_)
            | TermKind::Invalid => self.token(),
            TermKind::Apply { arguments, .. } => self.applied(false, arguments),
            TermKind::Dot { arguments, .. } => self.applied(true, arguments),
            TermKind::Chain { first, links } => self.chain(first, links),
            TermKind::Unary {
                operator, operand, ..
            } => self.unary(*operator, operand),
            TermKind::Tuple(items) => self.list(items, LayoutBreak::Line, Self::term),
            TermKind::If {
                guard,
                then,
                otherwise,
            } => self.choose_if(&If::of(guard, then, otherwise), lines),
            TermKind::Switch {
                subject,
                cases,
                otherwise,
            } => self.choose_case(subject, cases, otherwise.as_ref(), lines),
            TermKind::Let { bindings, body } => {
                self.bindings(bindings);
                self.branch(body, lines);
                self.separate(LayoutBreak::line(lines));
                self.token();
            }
            TermKind::Quantified { binders, guard, .. } => self.quantified(binders, guard.as_ref()),
            TermKind::Listed { collection, items } => {
                let item = element(*collection);
                let between = if items.iter().all(|item| item.depth <= 2) {
                    LayoutBreak::Fill
                } else {
                    LayoutBreak::Line
                };
                self.rows(items, between, |list, it| list.placed(it, item));
            }
            TermKind::Interval {
                collection,
                interval,
            } => self.interval(interval, element(*collection)),
            TermKind::Comprehension {
                collection,
                comprehension,
            } => self.comprehension(comprehension, element(*collection), None),
            TermKind::Map(entries) => self.map(entries),
            TermKind::MapComprehension {
                comprehension,
                value,
            } => self.comprehension(comprehension, element(Collection::Set), Some(value)),
            TermKind::RuleRef { domains, .. } => {
                self.joined(2);
                self.types(&domains.iter().collect::<Vec<_>>());
                self.token();
            }
            TermKind::Domain(domain) => self.type_(domain),
        }
    }

    // ── functions ──

    /// Prints `f`, `f(t…)` or `a.f(t…)`.
    pub(super) fn applied(&mut self, dotted: bool, arguments: &[Term]) {
        self.joined(if dotted { 3 } else { 1 });
        if !arguments.is_empty() {
            self.arguments(arguments);
        } else if self.at(Sign::Open) {
            self.leave_out();
            self.leave_out();
        }
    }

    /// Prints arguments in brackets.
    pub(super) fn arguments(&mut self, arguments: &[Term]) {
        self.list(arguments, LayoutBreak::Line, Self::term);
    }

    // ── terms with keywords ──

    /// Prints `(forall $x in D with g)`.
    fn quantified(&mut self, binders: &[Binder], guard: Option<&Term>) {
        self.joined(2);
        if self.peek() == Some(Token::Keyword(Keyword::Unique)) {
            self.separate(LayoutBreak::Blank);
            self.token();
        }
        self.binders(binders, guard);
        self.token();
    }

    /// Prints `$x in D, $y in E with g`.
    pub(super) fn binders(&mut self, binders: &[Binder], guard: Option<&Term>) {
        self.indent(|it| {
            it.separate(LayoutBreak::Blank);
            it.ranges(binders);
            if let Some(guard) = guard {
                it.separate(LayoutBreak::Line);
                it.token();
                it.indent(|it| {
                    it.separate(LayoutBreak::Blank);
                    it.term(guard);
                });
            }
            it.comments_inside();
        });
    }

    /// Prints `$x in D, $y in E`.
    pub(super) fn ranges(&mut self, binders: &[Binder]) {
        self.group(|it| {
            it.items(binders, LayoutBreak::Line, |it, binder| {
                it.token();
                it.separate(LayoutBreak::Blank);
                it.token();
                it.indent(|it| {
                    it.separate(LayoutBreak::Blank);
                    it.term(&binder.range);
                });
            });
        });
    }
}
