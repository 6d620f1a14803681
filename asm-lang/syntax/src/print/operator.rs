//! Operators, and the brackets that what stands between them needs.

use super::layout::{Break, Layout};
use crate::ast::*;

/// How tight the parts of a term hold together, as the grammar has it: from 0 for `implies` to 9 for
/// what needs no brackets anywhere.
pub(super) type Strength = u8;

pub(super) const LOOSEST: Strength = 0;
pub(super) const NOT: Strength = 4;
const SIGN: Strength = 8;
const TIGHTEST: Strength = 9;

/// Where a term stands.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// What does not hold together as tight needs brackets.
    pub(super) least: Strength,
    /// The operator it is an operand of.
    pub(super) of: Option<Operator>,
}

impl Layout<'_> {
    /// A term with the brackets it needs.
    pub(super) fn bracketed(&mut self, term: &Term, place: Place, inside: impl FnOnce(&mut Self)) {
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

    /// `a + b - c`: operators of equal strength in one go, each at the beginning of its line.
    pub(super) fn chain(&mut self, operator: Operator, left: &Term, right: &Term) {
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

    /// `-a`, `not a`.
    pub(super) fn unary(&mut self, operator: Operator, operand: &Term) {
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
