//! Operators, and the brackets that what stands between them needs.

use super::layout::{LayoutBreak, TokenLayout};
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
pub(super) struct OperandPosition {
    /// What does not hold together as tight needs brackets.
    pub(super) least: Strength,
    /// The operator it is an operand of.
    pub(super) of: Option<Operator>,
}

impl TokenLayout<'_> {
    /// A term with the brackets it needs.
    pub(super) fn bracketed(
        &mut self,
        term: &Term,
        place: OperandPosition,
        inside: impl FnOnce(&mut Self),
    ) {
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
    pub(super) fn chain(&mut self, first: &Term, links: &[ChainLink]) {
        for (index, link) in links.iter().enumerate() {
            let least = link.operator.strength();
            let of = Some(link.operator);
            if index == 0 {
                self.beginning(first, OperandPosition { least, of });
            }
            self.separate(LayoutBreak::Line);
            self.token();
            let place = OperandPosition {
                least: least + 1,
                of,
            };
            self.indent(|it| {
                it.separate(LayoutBreak::Blank);
                it.placed(&link.operand, place);
            });
        }
    }

    /// The first operand of a chain; one that is such a chain in needless brackets goes on in it.
    fn beginning(&mut self, first: &Term, place: OperandPosition) {
        match &*first.kind {
            TermKind::Chain {
                first: inner,
                links,
            } if strength_of(&first.kind) == place.least && !self.stays_bracketed(first, place) => {
                self.bracketed(first, place, |it| it.chain(inner, links));
            }
            _ => self.indent(|it| it.placed(first, place)),
        }
    }

    fn stays_bracketed(&self, term: &Term, place: OperandPosition) -> bool {
        self.brackets_around(term.span) > 0 && keeps_brackets(&term.kind, place)
    }

    /// `-a`, `not a`.
    pub(super) fn unary(&mut self, operator: Operator, operand: &Term) {
        self.token();
        let is_not = operator == Operator::Not;
        let is_signed = matches!(*operand.kind, TermKind::Unary { .. });
        // A sign that touches a complex number would be read as a part of it.
        if is_not || is_signed || self.complex_follows() {
            self.separate(LayoutBreak::Blank);
        }
        let place = OperandPosition {
            least: if is_not { NOT } else { SIGN },
            of: Some(operator),
        };
        self.placed(operand, place);
    }
}

/// Whether a term in brackets keeps them: where it would be read as something else without, and
/// where a reader would have to know the table.
fn keeps_brackets(kind: &TermKind, place: OperandPosition) -> bool {
    strength_of(kind) < place.least || place.of.is_some_and(|outer| is_unclear(kind, outer))
}

/// How tight a term holds together.
fn strength_of(kind: &TermKind) -> Strength {
    match (last_operator(kind), kind) {
        (Some(operator), _) => operator.strength(),
        (None, TermKind::Unary { operator, .. }) if *operator == Operator::Not => NOT,
        (None, TermKind::Unary { .. }) => SIGN,
        (None, _) => TIGHTEST,
    }
}

/// The operator of a chain that is applied last.
fn last_operator(kind: &TermKind) -> Option<Operator> {
    match kind {
        TermKind::Chain { links, .. } => links.last().map(|link| link.operator),
        _ => None,
    }
}

/// Whether few readers would bet on what binds tighter: the term or the operator it is an operand of.
fn is_unclear(inner: &TermKind, outer: Operator) -> bool {
    if let Some(operator) = last_operator(inner) {
        mixes(operator, outer)
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
    let is_logical = |operator: Operator| operator.strength() <= Operator::And.strength();
    let same = inner.strength() == outer.strength();
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
    operator.strength() == Operator::Eq.strength()
}
