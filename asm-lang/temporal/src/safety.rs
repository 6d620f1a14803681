//! The safety part of a formula, in positive normal form.

use crate::ctl::Ctl;
use crate::formula::Formula;
use crate::ltl::Ltl;
use crate::past::Conditions;
use std::collections::BTreeSet;

/// The largest number of subformulas that can be pending. The number of alternatives is at most the largest number of sets none of
/// which contains another (Sperner): 924 for 12.
const MAX_PENDING: usize = 12;

/// The reason for which a formula, or a part of it, cannot be monitored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum NotMonitorable {
    /// Something has to happen at some time.
    #[error("something has to happen, but at no definite time, so that no finite run violates it")]
    Liveness,
    /// Something has to be possible.
    #[error("something has to be possible, which one run cannot refute")]
    Existence,
    /// Nothing can violate it.
    #[error("no run violates it")]
    Trivial,
    /// A past operator has an operand about the future.
    #[error("a past operator has an operand about the future")]
    PastOfFuture,
    /// Too many subformulas can be pending.
    #[error(
        "it has more than {MAX_PENDING} temporal subformulas, or a number of steps that is too large"
    )]
    TooLarge,
}

/// The largest number of steps of `AX` and `EX`.
const MAX_STEPS: u32 = MAX_PENDING as u32;

/// A formula in positive normal form without *until*; operands are indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum SafetyNode {
    /// A condition of the position, and the value that it has to have.
    Condition(usize, bool),
    /// True without parts.
    All(Vec<usize>),
    /// False without parts.
    Any(Vec<usize>),
    Next(usize),
    /// The second operand holds up to and including the position at which the first does, or for ever.
    Release(usize, usize),
}

/// The safety part of a formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SafetyForm {
    pub nodes: Vec<SafetyNode>,
    pub conditions: Conditions,
    /// Index of the whole formula.
    pub root: usize,
    /// Reasons for which parts of the formula are left out.
    pub unwatched: BTreeSet<NotMonitorable>,
}

impl SafetyForm {
    /// Compiles the safety part of a formula; `unwatched` are reasons for which parts of it have been left out before.
    ///
    /// # Errors
    /// Nothing of it can be watched.
    pub fn of(formula: &Ltl, unwatched: BTreeSet<NotMonitorable>) -> Result<Self, NotMonitorable> {
        let mut builder = SafetyBuilder {
            nodes: Vec::new(),
            conditions: Conditions::default(),
            unwatched,
        };
        let root = builder.node(&folded(formula), true);
        if builder.unwatched.contains(&NotMonitorable::TooLarge) {
            return Err(NotMonitorable::TooLarge);
        }
        if builder.truth(root) == Some(true) {
            let reason = builder.unwatched.first().copied();
            return Err(reason.unwrap_or(NotMonitorable::Trivial));
        }
        let mut pending = BTreeSet::new();
        for (index, node) in builder.nodes.iter().enumerate() {
            match node {
                SafetyNode::Next(operand) => pending.insert(*operand),
                SafetyNode::Release(..) => pending.insert(index),
                SafetyNode::Condition(..) | SafetyNode::All(_) | SafetyNode::Any(_) => false,
            };
        }
        if pending.len() > MAX_PENDING {
            return Err(NotMonitorable::TooLarge);
        }
        Ok(Self {
            nodes: builder.nodes,
            conditions: builder.conditions,
            root,
            unwatched: builder.unwatched,
        })
    }
}

/// Returns a formula of LTL that every path satisfies if the formula of CTL holds: without the path quantifiers, and without the
/// parts about the existence of paths. `positive` is `false` below an odd number of negations.
pub(crate) fn linear(
    formula: &Ctl,
    positive: bool,
    unwatched: &mut BTreeSet<NotMonitorable>,
) -> Ltl {
    let mut same = |of: &Ctl| linear(of, positive, unwatched);
    match formula {
        Ctl::True => Ltl::True,
        Ctl::False => Ltl::False,
        Ctl::Atom(atom) => Ltl::Atom(*atom),
        Ctl::Not(of) => Ltl::negation(linear(of, !positive, unwatched)),
        Ctl::And(parts) => Ltl::And(parts.iter().map(same).collect()),
        Ctl::Or(parts) => Ltl::Or(parts.iter().map(same).collect()),
        Ctl::Implies(left, right) => {
            let left = linear(left, !positive, unwatched);
            Ltl::implies(left, linear(right, positive, unwatched))
        }
        Ctl::Iff(left, right) => {
            // each side occurs in both polarities
            let mut side = |of: &Ctl, positive| linear(of, positive, unwatched);
            let forth = Ltl::implies(side(left, !positive), side(right, positive));
            let back = Ltl::implies(side(right, !positive), side(left, positive));
            Ltl::And(vec![forth, back])
        }
        Ctl::Ax(..) | Ctl::Af(_) | Ctl::Ag(_) | Ctl::Au(..) | Ctl::Aw(..) if !positive => {
            unwatched.insert(NotMonitorable::Existence);
            Ltl::False
        }
        Ctl::Ex(..) | Ctl::Ef(_) | Ctl::Eg(_) | Ctl::Eu(..) | Ctl::Ew(..) if positive => {
            unwatched.insert(NotMonitorable::Existence);
            Ltl::True
        }
        Ctl::Ax(steps, of) | Ctl::Ex(steps, of) => {
            let of = same(of);
            if *steps > MAX_STEPS {
                unwatched.insert(NotMonitorable::TooLarge);
            }
            (0..(*steps).min(MAX_STEPS)).fold(of, |of, _| Ltl::next(of))
        }
        Ctl::Af(of) | Ctl::Ef(of) => Ltl::finally(same(of)),
        Ctl::Ag(of) | Ctl::Eg(of) => Ltl::globally(same(of)),
        Ctl::Au(left, right) | Ctl::Eu(left, right) => Ltl::until(same(left), same(right)),
        Ctl::Aw(left, right) | Ctl::Ew(left, right) => Ltl::weak_until(same(left), same(right)),
    }
}

/// Returns an equivalent formula in which a constant is an operand of Boolean operators at most where it matters.
fn folded(formula: &Ltl) -> Ltl {
    let formula = formula.with_operands(&mut |operand, _| folded(operand));
    match &formula {
        Ltl::Not(of) if **of == Ltl::True => Ltl::False,
        Ltl::Not(of) if **of == Ltl::False => Ltl::True,
        Ltl::And(parts) => folded_parts(parts, true),
        Ltl::Or(parts) => folded_parts(parts, false),
        Ltl::Implies(left, right) if **left == Ltl::False || **right == Ltl::True => Ltl::True,
        Ltl::Implies(left, right) if **left == Ltl::True => (**right).clone(),
        Ltl::Next(of)
        | Ltl::Globally(of)
        | Ltl::Finally(of)
        | Ltl::Until(_, of)
        | Ltl::Release(_, of)
            if [Ltl::True, Ltl::False].contains(of) =>
        {
            (**of).clone()
        }
        Ltl::True
        | Ltl::False
        | Ltl::Atom(_)
        | Ltl::Not(_)
        | Ltl::Implies(..)
        | Ltl::Iff(..)
        | Ltl::Next(_)
        | Ltl::Finally(_)
        | Ltl::Globally(_)
        | Ltl::Until(..)
        | Ltl::Release(..)
        | Ltl::WeakUntil(..)
        | Ltl::Yesterday(_)
        | Ltl::WeakYesterday(_)
        | Ltl::Once(_)
        | Ltl::Historically(_)
        | Ltl::Since(..)
        | Ltl::Triggered(..) => formula,
    }
}

/// A conjunction if `is_all`, and otherwise a disjunction.
fn folded_parts(parts: &[Ltl], is_all: bool) -> Ltl {
    let (unit, zero) = if is_all {
        (Ltl::True, Ltl::False)
    } else {
        (Ltl::False, Ltl::True)
    };
    if parts.contains(&zero) {
        return zero;
    }
    let parts: Vec<Ltl> = parts.iter().filter(|it| **it != unit).cloned().collect();
    match parts.as_slice() {
        [] => unit,
        [only] => only.clone(),
        _ if is_all => Ltl::And(parts),
        _ => Ltl::Or(parts),
    }
}

struct SafetyBuilder {
    nodes: Vec<SafetyNode>,
    conditions: Conditions,
    unwatched: BTreeSet<NotMonitorable>,
}

impl SafetyBuilder {
    /// Translates a formula, or its negation if not `positive`.
    fn node(&mut self, formula: &Ltl, positive: bool) -> usize {
        if [Ltl::True, Ltl::False].contains(formula) {
            return self.constant((*formula == Ltl::True) == positive);
        }
        if let Some(condition) = self.conditions.add(formula) {
            return self.push(SafetyNode::Condition(condition, positive));
        }
        match formula {
            Ltl::Not(of) => self.node(of, !positive),
            Ltl::And(parts) => self.parts(parts, positive, positive),
            Ltl::Or(parts) => self.parts(parts, positive, !positive),
            Ltl::Implies(left, right) => {
                let parts = [self.node(left, !positive), self.node(right, positive)];
                self.combined(parts.to_vec(), !positive)
            }
            Ltl::Iff(left, right) => {
                // (¬l ∨ r) ∧ (l ∨ ¬r), or for the negation (l ∨ r) ∧ (¬l ∨ ¬r)
                let forth = [self.node(left, false), self.node(right, positive)];
                let forth = self.combined(forth.to_vec(), false);
                let back = [self.node(left, true), self.node(right, !positive)];
                let back = self.combined(back.to_vec(), false);
                self.combined(vec![forth, back], true)
            }
            Ltl::Next(of) => {
                let of = self.node(of, positive);
                match self.truth(of) {
                    Some(_) => of,
                    None => self.push(SafetyNode::Next(of)),
                }
            }
            Ltl::Globally(of) if positive => self.always(of, true),
            // ¬F p is G ¬p
            Ltl::Finally(of) if !positive => self.always(of, false),
            Ltl::Globally(_) | Ltl::Finally(_) => self.weakened(NotMonitorable::Liveness),
            Ltl::Until(left, right) if !positive => self.release(left, right, false),
            Ltl::Release(left, right) if positive => self.release(left, right, true),
            // p U q implies p W q, which is q R (p ∨ q); ¬(p R q) is ¬p U ¬q
            Ltl::Until(left, right) | Ltl::Release(left, right) => {
                self.unwatched.insert(NotMonitorable::Liveness);
                self.weak_until(left, right, positive)
            }
            Ltl::WeakUntil(left, right) if positive => self.weak_until(left, right, true),
            // ¬(p W q) is ¬q U (¬p ∧ ¬q)
            Ltl::WeakUntil(left, right) => {
                self.unwatched.insert(NotMonitorable::Liveness);
                let neither = Ltl::Or(vec![(**left).clone(), (**right).clone()]);
                self.weak_until(right, &neither, false)
            }
            Ltl::Yesterday(_)
            | Ltl::WeakYesterday(_)
            | Ltl::Once(_)
            | Ltl::Historically(_)
            | Ltl::Since(..)
            | Ltl::Triggered(..)
            | Ltl::True
            | Ltl::False
            | Ltl::Atom(_) => self.weakened(NotMonitorable::PastOfFuture),
        }
    }

    /// The operands of a conjunction if `is_all`, and otherwise of a disjunction.
    fn parts(&mut self, parts: &[Ltl], positive: bool, is_all: bool) -> usize {
        let parts = parts.iter().map(|it| self.node(it, positive)).collect();
        self.combined(parts, is_all)
    }

    fn always(&mut self, of: &Ltl, positive: bool) -> usize {
        let (never, of) = (self.constant(false), self.node(of, positive));
        self.released(never, of)
    }

    fn release(&mut self, left: &Ltl, right: &Ltl, positive: bool) -> usize {
        let (left, right) = (self.node(left, positive), self.node(right, positive));
        self.released(left, right)
    }

    fn weak_until(&mut self, left: &Ltl, right: &Ltl, positive: bool) -> usize {
        let (left, right) = (self.node(left, positive), self.node(right, positive));
        let either = self.combined(vec![left, right], false);
        self.released(right, either)
    }

    fn released(&mut self, left: usize, right: usize) -> usize {
        match (self.truth(left), self.truth(right)) {
            (_, Some(_)) | (Some(true), None) => right,
            (Some(false) | None, None) => self.push(SafetyNode::Release(left, right)),
        }
    }

    /// A conjunction if `is_all`, and otherwise a disjunction, without constants.
    fn combined(&mut self, mut parts: Vec<usize>, is_all: bool) -> usize {
        if parts.iter().any(|part| self.truth(*part) == Some(!is_all)) {
            return self.constant(!is_all);
        }
        parts.retain(|part| self.truth(*part).is_none());
        match (parts.as_slice(), is_all) {
            ([only], _) => *only,
            (_, true) => self.push(SafetyNode::All(parts)),
            (_, false) => self.push(SafetyNode::Any(parts)),
        }
    }

    /// Returns the value of a constant.
    fn truth(&self, node: usize) -> Option<bool> {
        match self.nodes.get(node)? {
            SafetyNode::All(parts) if parts.is_empty() => Some(true),
            SafetyNode::Any(parts) if parts.is_empty() => Some(false),
            SafetyNode::Condition(..)
            | SafetyNode::All(_)
            | SafetyNode::Any(_)
            | SafetyNode::Next(_)
            | SafetyNode::Release(..) => None,
        }
    }

    fn constant(&mut self, value: bool) -> usize {
        let parts = Vec::new();
        self.push(if value {
            SafetyNode::All(parts)
        } else {
            SafetyNode::Any(parts)
        })
    }

    /// Replaces a part that cannot be watched by true, which weakens the formula.
    fn weakened(&mut self, reason: NotMonitorable) -> usize {
        self.unwatched.insert(reason);
        self.constant(true)
    }

    fn push(&mut self, node: SafetyNode) -> usize {
        let known = self.nodes.iter().position(|it| *it == node);
        known.unwrap_or_else(|| {
            self.nodes.push(node);
            self.nodes.len() - 1
        })
    }
}
