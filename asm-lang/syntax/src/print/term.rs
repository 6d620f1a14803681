//! Terms. They are broken only where they do not fit on one line.

use super::layout::{Break, Layout};
use crate::ast::*;
use crate::lexer::{Keyword, Sign, Token};

/// How tight the parts of a term hold together, as the grammar has it: from 0 for `implies` to 9 for
/// what needs no brackets anywhere.
type Strength = u8;

const LOOSEST: Strength = 0;
const NOT: Strength = 4;
const SIGN: Strength = 8;
const TIGHTEST: Strength = 9;

/// Where a term stands.
#[derive(Clone, Copy)]
struct Place {
    /// What does not hold together as tight needs brackets.
    least: Strength,
    /// The operator it is an operand of.
    of: Option<Operator>,
}

impl Layout<'_> {
    /// A term where any may stand.
    pub(super) fn term(&mut self, term: &Term) {
        self.placed(
            term,
            Place {
                least: LOOSEST,
                of: None,
            },
        );
    }

    /// `t` after `:=` or `=`: on the next line where it does not fit, but collections begin here.
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
            self.separate(Break::Blank);
            return self.term(term);
        }
        self.indent(|it| {
            it.separate(Break::Line);
            it.term(term);
        });
    }

    /// A term without the brackets it does not need.
    fn placed(&mut self, term: &Term, place: Place) {
        self.bracketed(term, place, |it| {
            let lines = it.in_lines(term.span);
            it.group(|it| it.term_kind(&term.kind, lines));
        });
    }

    fn bracketed(&mut self, term: &Term, place: Place, inside: impl FnOnce(&mut Self)) {
        let around = self.brackets_around(term.span);
        let own = match &*term.kind {
            TermKind::Tuple(_) | TermKind::Quantified { .. } => 1,
            _ => 0,
        };
        let around = around.saturating_sub(own);
        let kept = around > 0 && keeps_brackets(&term.kind, place);
        let needless = around - usize::from(kept);
        for _ in 0..needless {
            self.leave_out();
            self.new_line();
        }
        if kept {
            self.token();
            self.indent(|it| {
                inside(it);
                it.comments_inside();
            });
            self.token();
        } else {
            inside(self);
        }
        for _ in 0..needless {
            self.leave_out();
        }
    }

    fn term_kind(&mut self, kind: &TermKind, lines: bool) {
        match kind {
            TermKind::Literal(_)
            | TermKind::Variable(_)
            | TermKind::Constant(_)
            | TermKind::Invalid => self.token(),
            TermKind::Apply { arguments, .. } => self.applied(false, arguments),
            TermKind::Dot { arguments, .. } => self.applied(true, arguments),
            TermKind::Binary {
                operator,
                left,
                right,
                ..
            } => self.chain(*operator, left, right),
            TermKind::Unary {
                operator, operand, ..
            } => self.unary(*operator, operand),
            TermKind::Tuple(items) => self.list(items, Break::Line, Self::term),
            TermKind::If {
                guard,
                then,
                otherwise,
            } => self.if_term(guard, then, otherwise.as_ref(), lines),
            TermKind::Switch {
                subject,
                cases,
                otherwise,
            } => self.switch_term(subject, cases, otherwise.as_ref(), lines),
            TermKind::Let { bindings, body } => {
                self.bindings(bindings);
                self.part(body, lines);
                self.separate(Break::line(lines));
                self.token();
            }
            TermKind::Quantified { binders, guard, .. } => self.quantified(binders, guard.as_ref()),
            TermKind::Listed { collection, items } => {
                let item = element(*collection);
                let between = if items.iter().all(|item| item.depth <= 2) {
                    Break::Fill
                } else {
                    Break::Line
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
                self.tokens(2);
                self.types(&domains.iter().collect::<Vec<_>>());
                self.token();
            }
            TermKind::Domain(domain) => self.type_(domain),
        }
    }

    // ── functions and operators ──

    /// `f`, `f(t…)`, `a.f(t…)`.
    pub(super) fn applied(&mut self, dotted: bool, arguments: &[Term]) {
        self.tokens(if dotted { 3 } else { 1 });
        if !arguments.is_empty() {
            self.arguments(arguments);
        } else if self.at(Sign::Open) {
            self.leave_out();
            self.leave_out();
        }
    }

    /// Terms in brackets.
    pub(super) fn arguments(&mut self, arguments: &[Term]) {
        self.list(arguments, Break::Line, Self::term);
    }

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

    /// `a + b - c`: operators of equal strength in one go, each at the beginning of its line.
    fn chain(&mut self, operator: Operator, left: &Term, right: &Term) {
        let strength = strength(operator);
        let place = Place {
            least: strength,
            of: Some(operator),
        };
        if let TermKind::Binary {
            operator: before,
            left: first,
            right: second,
            ..
        } = &*left.kind
            && self::strength(*before) == strength
            && !self.stays_bracketed(left, place)
        {
            self.bracketed(left, place, |it| it.chain(*before, first, second));
        } else {
            self.indent(|it| it.placed(left, place));
        }
        self.separate(Break::Line);
        self.token();
        let place = Place {
            least: strength + 1,
            of: Some(operator),
        };
        self.indent(|it| {
            it.separate(Break::Blank);
            it.placed(right, place);
        });
    }

    fn stays_bracketed(&self, term: &Term, place: Place) -> bool {
        self.brackets_around(term.span) > 0 && keeps_brackets(&term.kind, place)
    }

    fn unary(&mut self, operator: Operator, operand: &Term) {
        self.token();
        let is_not = operator == Operator::Not;
        let is_signed = matches!(*operand.kind, TermKind::Unary { .. });
        // A sign that touches a complex number would be read as a part of it.
        if is_not || is_signed || self.complex_follows() {
            self.separate(Break::Blank);
        }
        let place = Place {
            least: if is_not { NOT } else { SIGN },
            of: Some(operator),
        };
        self.placed(operand, place);
    }

    // ── terms with words ──

    /// A term between words.
    fn part(&mut self, term: &Term, lines: bool) {
        self.indent(|it| {
            it.separate(Break::line(lines));
            it.term(term);
            it.comments_inside();
        });
    }

    fn if_term(&mut self, guard: &Term, then: &Term, otherwise: Option<&Term>, lines: bool) {
        self.guarded(guard);
        self.part(then, lines);
        let mut chained = false;
        if let Some(otherwise) = otherwise {
            self.separate(Break::line(lines));
            chained = self.else_if();
            self.token();
            if let TermKind::If {
                guard,
                then,
                otherwise,
            } = &*otherwise.kind
                && chained
            {
                self.separate(Break::Blank);
                self.if_term(guard, then, otherwise.as_ref(), lines);
            } else {
                self.part(otherwise, lines);
            }
        }
        self.separate(if chained {
            Break::Blank
        } else {
            Break::line(lines)
        });
        self.token();
    }

    fn switch_term(
        &mut self,
        subject: &Term,
        cases: &[(Term, Term)],
        otherwise: Option<&Term>,
        lines: bool,
    ) {
        self.subject(subject);
        self.indent(|it| {
            for (case, value) in cases {
                it.separate(if lines { Break::Item } else { Break::Line });
                let apart = it.in_lines(case.span.to(value.span));
                it.case(case, apart, |it| it.term(value));
            }
            if let Some(otherwise) = otherwise {
                it.separate(if lines { Break::Item } else { Break::Line });
                it.otherwise(otherwise.span, |it| it.term(otherwise));
            }
        });
        self.separate(Break::line(lines));
        self.token();
    }

    /// `(forall $x in D with g)`.
    fn quantified(&mut self, binders: &[Binder], guard: Option<&Term>) {
        self.tokens(2);
        if self.peek() == Some(Token::Keyword(Keyword::Unique)) {
            self.separate(Break::Blank);
            self.token();
        }
        self.binders(binders, guard);
        self.token();
    }

    /// `$x in D, $y in E with g`.
    pub(super) fn binders(&mut self, binders: &[Binder], guard: Option<&Term>) {
        self.indent(|it| {
            it.separate(Break::Blank);
            it.ranges(binders);
            if let Some(guard) = guard {
                it.separate(Break::Line);
                it.token();
                it.indent(|it| {
                    it.separate(Break::Blank);
                    it.term(guard);
                });
            }
            it.comments_inside();
        });
    }

    /// `$x in D, $y in E`.
    fn ranges(&mut self, binders: &[Binder]) {
        self.group(|it| {
            it.items(binders, Break::Line, |it, binder| {
                it.token();
                it.separate(Break::Blank);
                it.token();
                it.indent(|it| {
                    it.separate(Break::Blank);
                    it.term(&binder.range);
                });
            });
        });
    }

    // ── collections ──

    /// `{a : b, s}`.
    fn interval(&mut self, interval: &Interval, item: Place) {
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
    fn comprehension(&mut self, comprehension: &Comprehension, item: Place, value: Option<&Term>) {
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
    fn map(&mut self, entries: &[(Term, Term)]) {
        if entries.is_empty() {
            return self.tokens(3);
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
fn element(collection: Collection) -> Place {
    let least = match collection {
        Collection::Set | Collection::Seq => LOOSEST,
        Collection::Bag => NOT,
    };
    Place { least, of: None }
}

/// Whether a term in brackets keeps them: where it would be read as something else without, and
/// where a reader would have to know the table.
fn keeps_brackets(kind: &TermKind, place: Place) -> bool {
    strength_of(kind) < place.least || place.of.is_some_and(|outer| is_unclear(kind, outer))
}

/// How tight a term holds together.
fn strength_of(kind: &TermKind) -> Strength {
    if let TermKind::Binary { operator, .. } = kind {
        strength(*operator)
    } else if let TermKind::Unary { operator, .. } = kind {
        if *operator == Operator::Not {
            NOT
        } else {
            SIGN
        }
    } else {
        TIGHTEST
    }
}

/// Whether few readers would bet on what binds tighter: the term or the operator it is an operand of.
fn is_unclear(inner: &TermKind, outer: Operator) -> bool {
    if let TermKind::Binary { operator, .. } = inner {
        mixes(*operator, outer)
    } else if let TermKind::Unary { operator, .. } = inner {
        if *operator == Operator::Not {
            is_relation(outer)
        } else {
            outer == Operator::Pwr
        }
    } else {
        matches!(
            inner,
            TermKind::If { .. } | TermKind::Switch { .. } | TermKind::Let { .. }
        )
    }
}

/// Whether two binary operators next to each other make a reader think.
fn mixes(inner: Operator, outer: Operator) -> bool {
    let is_logical = |operator| strength(operator) <= strength(Operator::And);
    let same = strength(inner) == strength(outer);
    if is_logical(inner) && is_logical(outer) {
        let associates = matches!(inner, Operator::And | Operator::Or);
        inner != outer || !associates
    } else if is_relation(inner) || inner == Operator::Pwr {
        same
    } else {
        same && (inner == Operator::Mod || outer == Operator::Mod)
    }
}

fn is_relation(operator: Operator) -> bool {
    strength(operator) == strength(Operator::Eq)
}

fn strength(operator: Operator) -> Strength {
    match operator {
        Operator::Implies | Operator::Iff => LOOSEST,
        Operator::Or | Operator::Xor => 1,
        Operator::And => 2,
        Operator::Eq
        | Operator::Neq
        | Operator::Lt
        | Operator::Le
        | Operator::Gt
        | Operator::Ge => 3,
        Operator::Not => NOT,
        Operator::Plus | Operator::Minus => 5,
        Operator::Mult | Operator::Div | Operator::Mod => 6,
        Operator::Pwr => 7,
    }
}
