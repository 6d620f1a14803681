//! Parts of a formula that do not matter for its truth.

use crate::bits::Bits;
use crate::ctl::Ctl;
use crate::error::TemporalError;
use crate::fairness::Fairness;
use crate::formula::{Formula, Polarity};
use crate::graph::Graph;
use crate::ltl::Ltl;
use crate::product::FairGraph;
use crate::satisfaction::holds_ctl;
use crate::verdict::TemporalVerdict;

/// An occurrence of an atom in a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtomOccurrence {
    /// The index of the atom.
    pub atom: usize,
    /// The number of the occurrence among those of all atoms, from left to right.
    pub occurrence: usize,
}

/// Parts of a formula that holds, although they could be anything.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Vacuity {
    /// Atoms, each of which could be replaced by any other formula, and the formula would hold.
    pub irrelevant: Vec<AtomOccurrence>,
    /// Implications whose antecedent is never true on a fair path: their numbers among all implications, from left to right, an outer
    /// one before those in its operands.
    pub unmet: Vec<usize>,
}

/// Returns what does not matter for a CTL formula; nothing if the formula is violated.
///
/// An atom does not matter if the formula holds with this occurrence replaced by the constant that makes it strongest (Beer, Ben-David,
/// Eisner and Rodeh, "Efficient detection of vacuity in temporal model checking", 2001), or below `iff` with each of both constants.
///
/// # Errors
/// The same as of [`check_ctl`](crate::check_ctl).
pub fn vacuity_ctl(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ctl,
    fairness: &[Fairness],
) -> Result<Vacuity, TemporalError> {
    vacuity_ctl_while(graph, atoms, formula, fairness, &|_| true)
}

/// Returns what does not matter for a CTL formula like [`vacuity_ctl`], as long as `goes_on` returns true: see
/// [`check_ctl_while`](crate::check_ctl_while).
///
/// # Errors
/// The same as of [`check_ctl_while`](crate::check_ctl_while).
pub fn vacuity_ctl_while(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ctl,
    fairness: &[Fairness],
    goes_on: &dyn Fn(usize) -> bool,
) -> Result<Vacuity, TemporalError> {
    vacuity(formula, |it| holds_ctl(graph, atoms, it, fairness, goes_on))
}

/// Returns what does not matter for an LTL formula; nothing if the formula is violated. See [`vacuity_ctl`].
///
/// # Errors
/// The same as of [`check_ltl`](crate::check_ltl).
pub fn vacuity_ltl(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ltl,
    fairness: &[Fairness],
) -> Result<Vacuity, TemporalError> {
    let graph = FairGraph::new(graph, atoms, fairness)?;
    vacuity(formula, |it| graph.holds(it, &|_| true))
}

/// Checks an LTL formula as [`check_ltl`](crate::check_ltl) does, and returns what does not matter for it as [`vacuity_ltl`] does. This
/// takes less time than both: fair paths and the product with the formula itself are computed once.
///
/// # Errors
/// The same as of [`check_ltl`](crate::check_ltl).
pub fn check_ltl_with_vacuity(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ltl,
    fairness: &[Fairness],
) -> Result<(TemporalVerdict, Vacuity), TemporalError> {
    let checked = check_ltl_with_vacuity_while(graph, atoms, formula, fairness, &|_| true)?;
    Ok((checked.0, checked.1.unwrap_or_default()))
}

/// Checks an LTL formula like [`check_ltl_with_vacuity`], as long as `goes_on` returns true: see
/// [`check_ltl_while`](crate::check_ltl_while). If it ends after the verdict, what does not matter for the formula is `None`.
///
/// # Errors
/// The same as of [`check_ltl_while`](crate::check_ltl_while).
pub fn check_ltl_with_vacuity_while(
    graph: &Graph,
    atoms: &[Bits],
    formula: &Ltl,
    fairness: &[Fairness],
    goes_on: &dyn Fn(usize) -> bool,
) -> Result<(TemporalVerdict, Option<Vacuity>), TemporalError> {
    let graph = FairGraph::new(graph, atoms, fairness)?;
    let verdict = graph.verdict(formula, goes_on)?;
    let vacuity = match verdict.violation {
        Some(_) => Ok(Vacuity::default()),
        None => vacuity_of_valid(formula, |it| graph.holds(it, goes_on)),
    };
    match vacuity {
        Ok(vacuity) => Ok((verdict, Some(vacuity))),
        Err(TemporalError::Interrupted) => Ok((verdict, None)),
        Err(error) => Err(error),
    }
}

/// Returns what does not matter for a CTL formula, by another procedure that decides whether a formula holds, such as one over sets
/// of states. See [`vacuity_ctl`].
///
/// # Errors
/// The errors of the procedure.
pub fn vacuity_ctl_by<E>(
    formula: &Ctl,
    holds: impl Fn(&Ctl) -> Result<bool, E>,
) -> Result<Vacuity, E> {
    vacuity(formula, holds)
}

/// Returns what does not matter for an LTL formula, by another procedure. See [`vacuity_ctl_by`].
///
/// # Errors
/// The errors of the procedure.
pub fn vacuity_ltl_by<E>(
    formula: &Ltl,
    holds: impl Fn(&Ltl) -> Result<bool, E>,
) -> Result<Vacuity, E> {
    vacuity(formula, holds)
}

fn vacuity<F: Formula, E>(
    formula: &F,
    holds: impl Fn(&F) -> Result<bool, E>,
) -> Result<Vacuity, E> {
    if !holds(formula)? {
        return Ok(Vacuity::default());
    }
    vacuity_of_valid(formula, holds)
}

/// Returns what does not matter for a formula that holds.
fn vacuity_of_valid<F: Formula, E>(
    formula: &F,
    holds: impl Fn(&F) -> Result<bool, E>,
) -> Result<Vacuity, E> {
    let mut found = Vacuity::default();
    let mut occurrences = Vec::new();
    let mut antecedents = Vec::new();
    copy(formula, Polarity::Positive, &mut |it, polarity| {
        occurrences.extend(it.as_atom().map(|atom| (atom, polarity)));
        antecedents.extend(it.antecedent().map(|it| whole(it).never()));
        None
    });
    for (occurrence, (atom, polarity)) in occurrences.into_iter().enumerate() {
        let strongest: &[bool] = match polarity {
            Polarity::Positive => &[false],
            Polarity::Negative => &[true],
            Polarity::Mixed => &[false, true],
        };
        let mut matters = false;
        for value in strongest {
            matters = matters || !holds(&replaced(formula, occurrence, *value))?;
        }
        if !matters {
            found.irrelevant.push(AtomOccurrence { atom, occurrence });
        }
    }
    for (at, never) in antecedents.iter().enumerate() {
        if holds(never)? {
            found.unmet.push(at);
        }
    }
    Ok(found)
}

/// Returns the formula with one occurrence of an atom replaced by a constant.
fn replaced<F: Formula>(formula: &F, occurrence: usize, value: bool) -> F {
    let mut at = 0;
    copy(formula, Polarity::Positive, &mut |it, _| {
        it.as_atom()?;
        at += 1;
        (at == occurrence + 1).then(|| F::constant(value))
    })
}

fn whole<F: Formula>(formula: &F) -> F {
    copy(formula, Polarity::Positive, &mut |_, _| None)
}

/// Copies a formula, with the sub-formulas replaced for which `replace` returns others. Visits a formula before its operands.
fn copy<F: Formula>(
    formula: &F,
    polarity: Polarity,
    replace: &mut dyn FnMut(&F, Polarity) -> Option<F>,
) -> F {
    replace(formula, polarity).unwrap_or_else(|| {
        formula.with_operands(&mut |operand, inner| copy(operand, polarity.of(inner), replace))
    })
}
