//! Construction of terms and rules with decided parts removed. A part is removed only if a machine would not evaluate it, or if its
//! evaluation can neither fail nor read an input.

use crate::program::{FAULT, GroundCandidate, GroundRule, GroundTerm, TableIndex, UNDEF};
use asmotion_ir::{Arithmetic, Comparison, Connective, Origin, Quantifier};

/// The number of `false`.
const FALSE: GroundTerm = GroundTerm::Constant(0);
/// The number of `true`.
const TRUE: GroundTerm = GroundTerm::Constant(1);

impl GroundTerm {
    /// Returns the number of a constant.
    pub fn constant(&self) -> Option<i64> {
        if let Self::Constant(number) = self {
            Some(*number)
        } else {
            None
        }
    }

    /// Returns `true` if the evaluation reads no input and cannot fail.
    pub fn is_silent(&self) -> bool {
        match self {
            Self::Constant(number) => *number != FAULT,
            Self::Variable(_) => true,
            Self::Input(_) | Self::Arithmetic(..) | Self::If(..) | Self::Table { .. } => false,
            Self::Not(_)
            | Self::Logic(..)
            | Self::Quantified(..)
            | Self::Equal(..)
            | Self::Compare(..)
            | Self::After(..) => self.parts().into_iter().all(Self::is_silent),
        }
    }
}

pub(crate) fn not(operand: GroundTerm) -> GroundTerm {
    match operand.constant() {
        Some(0) => return TRUE,
        Some(1) => return FALSE,
        Some(_) => return operand,
        None => {}
    }
    if let GroundTerm::Not(inner) = operand {
        *inner
    } else {
        GroundTerm::Not(Box::new(operand))
    }
}

/// Evaluates a term for its faults and inputs only, and returns another.
pub(crate) fn after(first: Vec<GroundTerm>, last: GroundTerm) -> GroundTerm {
    let loud: Vec<GroundTerm> = first.into_iter().filter(|term| !term.is_silent()).collect();
    if loud.is_empty() {
        last
    } else {
        GroundTerm::After(loud, Box::new(last))
    }
}

pub(crate) fn logic(connective: Connective, left: GroundTerm, right: GroundTerm) -> GroundTerm {
    let whole = |left, right| GroundTerm::Logic(connective, Box::new(left), Box::new(right));
    if left == GroundTerm::Constant(FAULT) {
        return left;
    }
    match (connective, left.constant(), right.constant()) {
        (Connective::And, Some(0), _) => FALSE,
        (Connective::Or, Some(1), _) | (Connective::Implies, Some(0), _) => TRUE,
        (Connective::And | Connective::Implies, Some(1), _) | (Connective::Or, Some(0), _) => right,
        (Connective::And, None, Some(0)) => after(vec![left], FALSE),
        (Connective::Or | Connective::Implies, None, Some(1)) => after(vec![left], TRUE),
        (Connective::And, None, Some(1)) | (Connective::Or, None, Some(0)) => left,
        (Connective::Implies, None, Some(0)) | (Connective::Xor, None, Some(1)) => not(left),
        (Connective::Iff, None, Some(0)) => not(left),
        (Connective::Iff, None, Some(1)) | (Connective::Xor, None, Some(0)) => left,
        (Connective::Iff, Some(1), None) | (Connective::Xor, Some(0), None) => right,
        (Connective::Iff, Some(0), None) | (Connective::Xor, Some(1), None) => not(right),
        (Connective::Iff, Some(a @ (0 | 1)), Some(b @ (0 | 1))) => {
            GroundTerm::Constant(i64::from(a == b))
        }
        (Connective::Xor, Some(a @ (0 | 1)), Some(b @ (0 | 1))) => {
            GroundTerm::Constant(i64::from(a != b))
        }
        _ => whole(left, right),
    }
}

pub(crate) fn quantified(quantifier: Quantifier, instances: Vec<GroundTerm>) -> GroundTerm {
    let (neutral, deciding) = match quantifier {
        Quantifier::Forall => (1, 0),
        Quantifier::Exists => (0, 1),
        Quantifier::ExistsUnique => return GroundTerm::Quantified(quantifier, instances),
    };
    let mut kept = Vec::new();
    for instance in instances {
        match instance.constant() {
            Some(number) if number == neutral => {}
            Some(number) if number == deciding => {
                // no later instance is evaluated
                return if kept.iter().all(GroundTerm::is_silent) {
                    GroundTerm::Constant(deciding)
                } else {
                    kept.push(instance);
                    GroundTerm::Quantified(quantifier, kept)
                };
            }
            Some(_) | None => kept.push(instance),
        }
    }
    match kept.len() {
        0 => GroundTerm::Constant(neutral),
        1 => kept.remove(0),
        _ => GroundTerm::Quantified(quantifier, kept),
    }
}

pub(crate) fn equal(left: GroundTerm, right: GroundTerm) -> GroundTerm {
    match (left.constant(), right.constant()) {
        (Some(FAULT), _) | (_, Some(FAULT)) => GroundTerm::Constant(FAULT),
        (Some(left), Some(right)) => GroundTerm::Constant(i64::from(left == right)),
        // constants are on the right
        (Some(_), None) => GroundTerm::Equal(Box::new(right), Box::new(left)),
        (None, _) if left == right && left.is_silent() => TRUE,
        (None, _) => GroundTerm::Equal(Box::new(left), Box::new(right)),
    }
}

pub(crate) fn compare(comparison: Comparison, left: GroundTerm, right: GroundTerm) -> GroundTerm {
    match (left.constant(), right.constant()) {
        (Some(FAULT), _) | (_, Some(FAULT)) => GroundTerm::Constant(FAULT),
        (Some(left), Some(right)) => GroundTerm::Constant(compared(comparison, left, right)),
        _ => GroundTerm::Compare(comparison, Box::new(left), Box::new(right)),
    }
}

pub(crate) fn arithmetic(operation: Arithmetic, left: GroundTerm, right: GroundTerm) -> GroundTerm {
    match (left.constant(), right.constant()) {
        (Some(FAULT), _) | (_, Some(FAULT)) => GroundTerm::Constant(FAULT),
        (Some(left), Some(right)) => GroundTerm::Constant(computed(operation, left, right)),
        _ => GroundTerm::Arithmetic(operation, Box::new(left), Box::new(right)),
    }
}

pub(crate) fn branch(guard: GroundTerm, then: GroundTerm, otherwise: GroundTerm) -> GroundTerm {
    match guard.constant() {
        Some(1) => then,
        Some(0) => otherwise,
        Some(_) => GroundTerm::Constant(FAULT),
        None => GroundTerm::If(Box::new(guard), Box::new(then), Box::new(otherwise)),
    }
}

/// Returns the element of a table, with the constant arguments resolved.
pub(crate) fn table(
    indices: Vec<TableIndex>,
    elements: Vec<GroundTerm>,
    undefined: GroundTerm,
) -> GroundTerm {
    let Some((indices, elements)) = resolved(indices, elements) else {
        return GroundTerm::Constant(FAULT);
    };
    match (indices.is_empty(), elements.as_slice()) {
        (true, [one]) => one.clone(),
        (true, _) => GroundTerm::Constant(FAULT),
        (false, _) => GroundTerm::Table {
            indices,
            elements,
            undefined: Box::new(undefined),
        },
    }
}

/// Selects the part of a table that its constant arguments leave. `None` if one of them is in no row.
pub(crate) fn resolved<T: Clone>(
    indices: Vec<TableIndex>,
    elements: Vec<T>,
) -> Option<(Vec<TableIndex>, Vec<T>)> {
    let mut fixed = 0usize;
    let mut open: Vec<TableIndex> = Vec::new();
    for index in indices {
        match index.term.constant() {
            Some(number) => {
                let row = number.checked_sub(index.low)?;
                let row = u32::try_from(row).ok().filter(|row| *row < index.count)?;
                fixed += row as usize * index.stride as usize;
            }
            None => open.push(index),
        }
    }
    // the elements that remain, with new strides, the last argument's being 1
    let mut positions = vec![fixed];
    for index in &open {
        let rows = 0..index.count as usize;
        let row = |at: usize| {
            let stride = index.stride as usize;
            rows.clone().map(move |row| at + row * stride)
        };
        positions = positions.into_iter().flat_map(row).collect();
    }
    let mut stride = 1u32;
    for index in open.iter_mut().rev() {
        index.stride = stride;
        stride = stride.checked_mul(index.count)?;
    }
    let selected = positions.iter().map(|at| elements.get(*at).cloned());
    Some((open, selected.collect::<Option<Vec<T>>>()?))
}

/// Compares two numbers; undef if one of them is.
#[inline]
pub(crate) fn compared(comparison: Comparison, left: i64, right: i64) -> i64 {
    if left == FAULT || right == FAULT {
        return FAULT;
    }
    if left == UNDEF || right == UNDEF {
        return UNDEF;
    }
    i64::from(match comparison {
        Comparison::Lt => left < right,
        Comparison::Le => left <= right,
        Comparison::Gt => left > right,
        Comparison::Ge => left >= right,
    })
}

/// Computes an operation on two numbers; undef if one of them is, [`FAULT`] if it fails.
#[inline]
pub(crate) fn computed(operation: Arithmetic, left: i64, right: i64) -> i64 {
    if left == FAULT || right == FAULT {
        return FAULT;
    }
    if left == UNDEF || right == UNDEF {
        return UNDEF;
    }
    let result = match operation {
        Arithmetic::Plus => left.checked_add(right),
        Arithmetic::Minus => left.checked_sub(right),
        Arithmetic::Mult => left.checked_mul(right),
        Arithmetic::Mod => (right != 0).then(|| left.wrapping_rem(right)),
    };
    // the two least integers stand for `undef` and faults
    result.filter(|number| *number > FAULT).unwrap_or(FAULT)
}

/// Executes rules in parallel.
pub(crate) fn par(rules: Vec<GroundRule>) -> GroundRule {
    let mut flat = Vec::new();
    for rule in rules {
        match rule {
            GroundRule::Skip => {}
            GroundRule::Par(inner) => flat.extend(inner),
            GroundRule::Update(..)
            | GroundRule::Seq(_)
            | GroundRule::If(..)
            | GroundRule::Choose(..)
            | GroundRule::After(..)
            | GroundRule::Counted(..)
            | GroundRule::Machine => flat.push(rule),
        }
    }
    match flat.len() {
        0 => GroundRule::Skip,
        1 => flat.remove(0),
        _ => GroundRule::Par(flat),
    }
}

/// Executes a rule after evaluating terms for their faults and inputs only.
pub(crate) fn rule_after(terms: Vec<GroundTerm>, rule: GroundRule) -> GroundRule {
    let loud: Vec<GroundTerm> = terms.into_iter().filter(|term| !term.is_silent()).collect();
    if loud.is_empty() {
        rule
    } else if loud.contains(&GroundTerm::Constant(FAULT)) {
        GroundRule::Machine
    } else {
        GroundRule::After(loud, Box::new(rule))
    }
}

/// Executes one of two rules.
pub(crate) fn rule_branch(
    guard: GroundTerm,
    then: GroundRule,
    otherwise: GroundRule,
) -> GroundRule {
    match guard.constant() {
        Some(1) => then,
        Some(0) => otherwise,
        Some(_) => GroundRule::Machine,
        None => GroundRule::If(guard, Box::new(then), Box::new(otherwise)),
    }
}

/// Chooses one of the candidates.
pub(crate) fn choose(
    candidates: Vec<GroundCandidate>,
    otherwise: GroundRule,
    origin: Origin,
) -> GroundRule {
    let possible = |it: &GroundCandidate| it.guard != FALSE;
    let candidates: Vec<GroundCandidate> = candidates.into_iter().filter(possible).collect();
    if candidates.is_empty() {
        otherwise
    } else {
        GroundRule::Choose(candidates, Box::new(otherwise), origin)
    }
}
