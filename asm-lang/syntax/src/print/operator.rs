//! Layout of operators, and the parentheses of their operands.

use super::layout::{LayoutBreak, TokenLayout};
use crate::ast::*;

/// Precedence of a term according to the grammar, from 0 for `implies` to 9 for a term that never
/// needs parentheses.
pub(super) type Strength = u8;

pub(super) const LOOSEST: Strength = 0;
pub(super) const NOT: Strength = 4;
const SIGN: Strength = 8;
const TIGHTEST: Strength = 9;

/// The position of a term.
#[derive(Clone, Copy)]
pub(super) struct OperandPosition {
    /// Least precedence that needs no parentheses here.
    pub(super) least: Strength,
    /// The operator that the term is an operand of, if any.
    pub(super) of: Option<Operator>,
}

impl TokenLayout<'_> {
    /// Prints a term with the parentheses it needs.
    pub(super) fn bracketed(
        &mut self,
        term: &Term,
        place: OperandPosition,
        inside: impl FnOnce(&mut Self),
    ) {
        let around = self.brackets_around(term.span);
        let brings_own = matches!(
            &*term.kind,
            TermKind::Tuple(_) | TermKind::Quantified { .. }
        );
        let own = usize::from(brings_own);
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

    /// Prints a chain `a + b - c`; if it is broken, each operator begins a line.
    pub(super) fn chain(&mut self, first: &Term, links: &[ChainLink]) {
        for (index, link) in links.iter().enumerate() {
            let least = link.operator.strength();
            let of = Some(link.operator);
            if index == 0 {
                self.first_operand(first, OperandPosition { least, of });
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

    /// Prints the first operand of a chain, removing superfluous parentheses around a chain of the
    /// same precedence.
    fn first_operand(&mut self, first: &Term, place: OperandPosition) {
        if let TermKind::Chain {
            first: inner,
            links,
        } = &*first.kind
            && strength_of(&first.kind) == place.least
            && !self.stays_bracketed(first, place)
        {
            self.bracketed(first, place, |it| it.chain(inner, links));
        } else {
            self.indent(|it| it.placed(first, place));
        }
    }

    fn stays_bracketed(&self, term: &Term, place: OperandPosition) -> bool {
        self.brackets_around(term.span) > 0 && keeps_brackets(&term.kind, place)
    }

    /// Prints `-a` or `not a`.
    pub(super) fn unary(&mut self, operator: Operator, operand: &Term) {
        self.token();
        let is_not = operator == Operator::Not;
        let is_signed = matches!(*operand.kind, TermKind::Unary { .. });
        // without a blank, a sign before a complex number would be read as part of it
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

/// Returns `true` if a term keeps its parentheses, because they are required or help the reader.
fn keeps_brackets(kind: &TermKind, place: OperandPosition) -> bool {
    strength_of(kind) < place.least || place.of.is_some_and(|outer| is_unclear(kind, outer))
}

/// Returns the precedence of a term.
fn strength_of(kind: &TermKind) -> Strength {
    match (last_operator(kind), kind) {
        (Some(operator), _) => operator.strength(),
        (None, TermKind::Unary { operator, .. }) if *operator == Operator::Not => NOT,
        (None, TermKind::Unary { .. }) => SIGN,
        (None, _) => TIGHTEST,
    }
}

/// Returns the operator of a chain that is applied last.
fn last_operator(kind: &TermKind) -> Option<Operator> {
    let TermKind::Chain { links, .. } = kind else {
        return None;
    };
    links.last().map(|link| link.operator)
}

/// Returns `true` if the relative precedence of a term and its operator is not obvious to readers.
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

/// Returns `true` if the relative precedence of two adjacent binary operators is not obvious.
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
