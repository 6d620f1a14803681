//! Conditions of a position of a run: Boolean combinations of atoms and past operators, with a bounded memory of the past.
//!
//! The value of an atom can be unknown; a condition is then unknown if its value depends on it (Kleene's three-valued logic).

use crate::ltl::Ltl;

/// Returns the value of an atom at the current position; `None` if it is not known yet.
pub type Letter<'a> = &'a dyn Fn(usize) -> Option<bool>;

/// A condition.
#[derive(Clone, Debug, PartialEq, Eq)]
enum PastTerm {
    Constant(bool),
    Atom(usize),
    /// The value of a past operator at the current position.
    Cell(usize),
    Not(Box<PastTerm>),
    All(Vec<PastTerm>),
    Any(Vec<PastTerm>),
    Iff(Box<PastTerm>, Box<PastTerm>),
}

/// A past operator, whose value at a position follows from its operands there and one bit about the position before.
#[derive(Clone, Debug, PartialEq, Eq)]
struct PastCell {
    operator: PastOperator,
    left: PastTerm,
    right: PastTerm,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PastOperator {
    /// `Y` and `Z`: the operand at the previous position; at the first one, this value.
    Previous(bool),
    /// `O` and `S`
    Since,
    /// `H` and `T`
    Triggered,
}

/// Conditions that share their memory.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Conditions {
    /// The operands of each cell refer to earlier cells only.
    cells: Vec<PastCell>,
    roots: Vec<PastTerm>,
}

/// The values of all cells at a position.
pub(crate) struct PositionValues(Vec<Option<bool>>);

impl Conditions {
    /// Adds a formula as a condition and returns its index; `None` if it contains operators about the future.
    pub fn add(&mut self, formula: &Ltl) -> Option<usize> {
        let cells = self.cells.len();
        let Some(root) = self.term(formula) else {
            self.cells.truncate(cells);
            return None;
        };
        let known = self.roots.iter().position(|it| *it == root);
        Some(known.unwrap_or_else(|| {
            self.roots.push(root);
            self.roots.len() - 1
        }))
    }

    /// Returns the memory before the first position.
    pub fn memory(&self) -> Vec<bool> {
        let initial = |cell: &PastCell| match cell.operator {
            PastOperator::Previous(initially) => initially,
            PastOperator::Since => false,
            PastOperator::Triggered => true,
        };
        self.cells.iter().map(initial).collect()
    }

    /// Returns the values of the cells at the current position.
    pub fn values(&self, memory: &[bool], letter: Letter<'_>) -> PositionValues {
        let mut values = PositionValues(Vec::with_capacity(self.cells.len()));
        for (cell, before) in self.cells.iter().zip(memory) {
            let value = match cell.operator {
                PastOperator::Previous(_) => Some(*before),
                PastOperator::Since => {
                    let kept = and(cell.left.value(&values, letter), Some(*before));
                    or(cell.right.value(&values, letter), kept)
                }
                PastOperator::Triggered => {
                    let kept = or(cell.left.value(&values, letter), Some(*before));
                    and(cell.right.value(&values, letter), kept)
                }
            };
            values.0.push(value);
        }
        values
    }

    /// Returns the value of a condition.
    pub fn value(
        &self,
        condition: usize,
        values: &PositionValues,
        letter: Letter<'_>,
    ) -> Option<bool> {
        let root = self.roots.get(condition)?;
        root.value(values, letter)
    }

    /// Remembers the current position, whose atoms are known. An unknown value counts as false.
    pub fn remember(&self, memory: &mut [bool], values: &PositionValues, letter: Letter<'_>) {
        for ((cell, bit), value) in self.cells.iter().zip(memory).zip(&values.0) {
            let value = match cell.operator {
                PastOperator::Previous(_) => cell.right.value(values, letter),
                PastOperator::Since | PastOperator::Triggered => *value,
            };
            *bit = value.unwrap_or_default();
        }
    }

    fn term(&mut self, formula: &Ltl) -> Option<PastTerm> {
        Some(match formula {
            Ltl::True => PastTerm::Constant(true),
            Ltl::False => PastTerm::Constant(false),
            Ltl::Atom(atom) => PastTerm::Atom(*atom),
            Ltl::Not(of) => PastTerm::Not(Box::new(self.term(of)?)),
            Ltl::And(parts) => PastTerm::All(self.terms(parts)?),
            Ltl::Or(parts) => PastTerm::Any(self.terms(parts)?),
            Ltl::Implies(left, right) => {
                let left = PastTerm::Not(Box::new(self.term(left)?));
                PastTerm::Any(vec![left, self.term(right)?])
            }
            Ltl::Iff(left, right) => {
                PastTerm::Iff(Box::new(self.term(left)?), Box::new(self.term(right)?))
            }
            Ltl::Yesterday(of) => self.cell(PastOperator::Previous(false), &Ltl::True, of)?,
            Ltl::WeakYesterday(of) => self.cell(PastOperator::Previous(true), &Ltl::True, of)?,
            Ltl::Once(of) => self.cell(PastOperator::Since, &Ltl::True, of)?,
            Ltl::Historically(of) => self.cell(PastOperator::Triggered, &Ltl::False, of)?,
            Ltl::Since(left, right) => self.cell(PastOperator::Since, left, right)?,
            Ltl::Triggered(left, right) => self.cell(PastOperator::Triggered, left, right)?,
            Ltl::Next(_)
            | Ltl::Finally(_)
            | Ltl::Globally(_)
            | Ltl::Until(..)
            | Ltl::Release(..)
            | Ltl::WeakUntil(..) => return None,
        })
    }

    fn terms(&mut self, formulas: &[Ltl]) -> Option<Vec<PastTerm>> {
        formulas.iter().map(|it| self.term(it)).collect()
    }

    fn cell(&mut self, operator: PastOperator, left: &Ltl, right: &Ltl) -> Option<PastTerm> {
        let (left, right) = (self.term(left)?, self.term(right)?);
        let cell = PastCell {
            operator,
            left,
            right,
        };
        let known = self.cells.iter().position(|it| *it == cell);
        Some(PastTerm::Cell(known.unwrap_or_else(|| {
            self.cells.push(cell);
            self.cells.len() - 1
        })))
    }
}

impl PastTerm {
    fn value(&self, values: &PositionValues, letter: Letter<'_>) -> Option<bool> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Atom(atom) => letter(*atom),
            Self::Cell(cell) => values.0.get(*cell).copied().flatten(),
            Self::Not(of) => of.value(values, letter).map(|it| !it),
            Self::All(parts) => combined(parts, true, values, letter),
            Self::Any(parts) => combined(parts, false, values, letter),
            Self::Iff(left, right) => {
                let (left, right) = (left.value(values, letter)?, right.value(values, letter)?);
                Some(left == right)
            }
        }
    }
}

/// A conjunction if `is_all`, and otherwise a disjunction.
fn combined(
    parts: &[PastTerm],
    is_all: bool,
    values: &PositionValues,
    letter: Letter<'_>,
) -> Option<bool> {
    let mut result = Some(is_all);
    for part in parts {
        let value = part.value(values, letter);
        result = if is_all {
            and(result, value)
        } else {
            or(result, value)
        };
    }
    result
}

fn and(left: Option<bool>, right: Option<bool>) -> Option<bool> {
    match (left, right) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), Some(true)) => Some(true),
        (None, _) | (_, None) => None,
    }
}

fn or(left: Option<bool>, right: Option<bool>) -> Option<bool> {
    match (left, right) {
        (Some(true), _) | (_, Some(true)) => Some(true),
        (Some(false), Some(false)) => Some(false),
        (None, _) | (_, None) => None,
    }
}
