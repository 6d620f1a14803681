//! Ranges that an index answers: `$x in D with f($x) = t`.
//!
//! The elements that satisfy such a guard are those that an index of *f* lists under the value of *t*, so a machine need not
//! visit the others. Closures and native code decide by this module which ranges have an index, because the elements
//! visited count against the limit for bindings, and both must count the same.

use crate::code::{Binder, BinderRange, Connective, Term, TermNode};
use crate::id::{FunctionId, Local};
use crate::program::{AxisRange, DomainElements, FunctionKind, Program, Storage};

/// A guard that an index answers, wholly or in part.
#[derive(Debug)]
pub struct IndexedGuard<'t> {
    /// The function of the index, which has one argument.
    pub function: FunctionId,
    /// `f($x) = t`
    pub equation: &'t Term,
    /// `t`, whose value does not depend on the variable.
    pub key: &'t Term,
    /// The rest of the guard: `equation and rest`.
    pub rest: Option<Term>,
    /// `true` if the range and the locations are the same in all states.
    pub is_static: bool,
}

impl Program {
    /// Returns the guard of a rule's only variable as one for an index, if it has this form.
    pub fn indexed_guard<'t>(
        &self,
        binders: &'t [Binder],
        guard: Option<&'t Term>,
    ) -> Option<IndexedGuard<'t>> {
        let [binder] = binders else {
            return None;
        };
        if self.compatible {
            // in this mode, the order of first accesses is observable
            return None;
        }
        let (equation, rest) = first_conjunct(guard?);
        let TermNode::Equal(left, right) = &*equation.node else {
            return None;
        };
        let sides = [(left, right), (right, left)];
        let (function, key) = sides.into_iter().find_map(|(one, key)| {
            let function = applied(one, binder.local)?;
            is_simple(key, binder.local).then_some((function, key))
        })?;
        let declared = self.functions.get(function.0 as usize)?;
        match declared.kind {
            FunctionKind::Controlled | FunctionKind::Out => {}
            FunctionKind::Monitored
            | FunctionKind::Shared
            | FunctionKind::Local
            | FunctionKind::Fixed => return None,
        }
        let has_range = match &binder.range {
            BinderRange::Ints(..) | BinderRange::Atoms(..) | BinderRange::Domain(_) => true,
            BinderRange::Bools | BinderRange::Elements(_) => false,
        };
        has_range.then(|| IndexedGuard {
            function,
            equation,
            key,
            rest,
            is_static: self.is_static(&binder.range, &declared.storage),
        })
    }

    /// Returns `true` if the elements of a range are the same in all states, and all are arguments of eager locations.
    fn is_static(&self, range: &BinderRange, storage: &Storage) -> bool {
        let Storage::Dense {
            axes, lazy: false, ..
        } = storage
        else {
            return false;
        };
        let [axis] = axes.as_slice() else {
            return false;
        };
        let atoms = |from: u32, elements: u32| match axis.over {
            AxisRange::Atoms { first, count } => {
                first <= from && from.saturating_add(elements) <= first.saturating_add(count)
            }
            AxisRange::Bool | AxisRange::Ints { .. } => false,
        };
        match range {
            BinderRange::Ints(from, to) => match axis.over {
                AxisRange::Ints { low, count } => {
                    low <= *from && *to < low.saturating_add(i64::from(count))
                }
                AxisRange::Bool | AxisRange::Atoms { .. } => false,
            },
            BinderRange::Atoms(first, count) => atoms(*first, *count),
            BinderRange::Domain(domain) => {
                let domain = &self.domains[domain.0 as usize];
                match domain.elements {
                    DomainElements::Atoms { first, count } => {
                        atoms(first.0, count) && !domain.is_extended
                    }
                    DomainElements::Ints { .. }
                    | DomainElements::Computed(_)
                    | DomainElements::Undefined
                    | DomainElements::Open => false,
                }
            }
            BinderRange::Bools | BinderRange::Elements(_) => false,
        }
    }
}

/// Splits a conjunction into its first operand and the others.
pub fn first_conjunct(guard: &Term) -> (&Term, Option<Term>) {
    let TermNode::Logic(Connective::And, left, right) = &*guard.node else {
        return (guard, None);
    };
    let (first, rest) = first_conjunct(left);
    let rest = match rest {
        // undef as the value of a guard is a fault at the place of the whole guard
        None => Term {
            origin: guard.origin,
            ..right.clone()
        },
        Some(rest) => Term {
            node: Box::new(TermNode::Logic(Connective::And, rest, right.clone())),
            ..*guard
        },
    };
    (first, Some(rest))
}

/// Returns the function of `f($x)`.
fn applied(term: &Term, variable: Local) -> Option<FunctionId> {
    let TermNode::Location(function, arguments) = &*unwatched(term).node else {
        return None;
    };
    let [argument] = arguments.as_slice() else {
        return None;
    };
    let TermNode::Local(local) = &*unwatched(argument).node else {
        return None;
    };
    (*local == variable).then_some(*function)
}

/// Returns `true` if evaluating a term once has the same effect as evaluating it for each value of a variable, provided that
/// there is a value: it does not depend on the variable, binds none, and calls nothing.
fn is_simple(term: &Term, variable: Local) -> bool {
    match &*term.node {
        TermNode::Constant(_) | TermNode::Agent | TermNode::Slot(..) => true,
        TermNode::Local(local) => *local != variable,
        TermNode::Location(_, terms) | TermNode::Tuple(terms) => {
            terms.iter().all(|term| is_simple(term, variable))
        }
        TermNode::Watched(term) | TermNode::Component(term, _) => is_simple(term, variable),
        TermNode::Arithmetic(_, left, right) => {
            is_simple(left, variable) && is_simple(right, variable)
        }
        TermNode::Call(..)
        | TermNode::Cached(..)
        | TermNode::Builtin(..)
        | TermNode::Logic(..)
        | TermNode::Not(_)
        | TermNode::Equal(..)
        | TermNode::Compare(..)
        | TermNode::If(..)
        | TermNode::Switch(..)
        | TermNode::Let(..)
        | TermNode::Quantified(..)
        | TermNode::Listed(..)
        | TermNode::Interval(..)
        | TermNode::Collect(..)
        | TermNode::Map(_)
        | TermNode::CollectMap(..)
        | TermNode::Extent(_)
        | TermNode::Unbound
        | TermNode::Program(_)
        | TermNode::Pre(_)
        | TermNode::Name(_)
        | TermNode::Named(..) => false,
    }
}

fn unwatched(term: &Term) -> &Term {
    if let TermNode::Watched(inner) = &*term.node {
        unwatched(inner)
    } else {
        term
    }
}
