//! Compilation of variables that range over domains and collections.

use super::Compiler;
use super::indexed::IndexedRanges;
use crate::fault::FaultKind;
use crate::limits::MAX_BINDINGS;
use crate::run::code::{TermCode, TruthCode};
use crate::run::{KleeneTruth, StepContext};
use asmotion_ir::{Binder, BinderRange, DomainId, Local, Origin, Term, TermNode, ValueShape};
use asmotion_value::{Atom, Value};
use std::ops::ControlFlow;

/// Variables with their ranges, and an optional guard.
pub(super) struct Ranges {
    pub(super) binders: Vec<(Local, RangeCode, Origin)>,
    pub(super) guard: Option<TruthCode>,
    pub(super) guard_origin: Origin,
    /// `true` if an undef guard is a fault, as in rules; otherwise the caller interprets it, as in
    /// terms.
    strict: bool,
    /// The index that answers the guard; `None` if there is none, and in terms.
    pub(super) indexed: Option<IndexedRanges>,
}

pub(super) enum RangeCode {
    Ints(i64, i64),
    Atoms(u32, u32),
    Bools,
    Domain(DomainId),
    Extent(ValueShape),
    Elements(TermCode),
}

impl Compiler<'_> {
    pub(super) fn ranges(&self, binders: &[Binder], guard: Option<&Term>, strict: bool) -> Ranges {
        let binders = binders.iter().map(|binder| {
            let range = match &binder.range {
                BinderRange::Ints(low, high) => RangeCode::Ints(*low, *high),
                BinderRange::Atoms(first, count) => RangeCode::Atoms(*first, *count),
                BinderRange::Bools => RangeCode::Bools,
                BinderRange::Domain(domain) => RangeCode::Domain(*domain),
                BinderRange::Elements(term) => {
                    if let TermNode::Extent(shape) = &*term.node {
                        RangeCode::Extent(shape.clone())
                    } else {
                        RangeCode::Elements(self.term(term))
                    }
                }
            };
            (binder.local, range, binder.origin)
        });
        Ranges {
            binders: binders.collect(),
            guard: guard.map(|guard| self.truth(guard)),
            guard_origin: guard.map_or_else(Origin::default, |guard| guard.origin),
            strict,
            indexed: None,
        }
    }

    /// Compiles the ranges of a rule, of which some have an index.
    pub(super) fn rule_ranges(&self, binders: &[Binder], guard: Option<&Term>) -> Ranges {
        Ranges {
            indexed: self.indexed(binders, guard),
            ..self.ranges(binders, guard, true)
        }
    }
}

impl Ranges {
    /// Calls `visit` for each assignment of the variables that satisfies the guard, in ascending
    /// order, until it breaks. An undef guard is not satisfied, and in rules it is a fault.
    pub(super) fn each(
        &self,
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>) -> ControlFlow<()>,
    ) {
        match self.elements(run) {
            Some(elements) => self.each_of(&elements, true, run, visit),
            None => self.each_in_full(run, visit),
        }
    }

    /// Does the same as [`Self::each`] without an index.
    pub(super) fn each_in_full(
        &self,
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>) -> ControlFlow<()>,
    ) {
        // a break carries no information: `visit` has stored its result
        let _ = self.nest(0, run, &mut |run, truth| match truth {
            KleeneTruth::True => visit(run),
            KleeneTruth::False => ControlFlow::Continue(()),
            KleeneTruth::Undef => {
                if self.strict {
                    run.fail(FaultKind::UndefinedGuard, self.guard_origin);
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            }
        });
    }

    /// Calls `visit` with the value of the guard for each assignment of the variables.
    pub(super) fn each_guard(
        &self,
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>, KleeneTruth) -> ControlFlow<()>,
    ) {
        let _ = self.nest(0, run, visit);
    }

    fn nest(
        &self,
        depth: usize,
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>, KleeneTruth) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some((local, range, origin)) = self.binders.get(depth) else {
            let truth = self
                .guard
                .as_ref()
                .map_or(KleeneTruth::True, |guard| guard(run));
            if run.fault.is_some() {
                return ControlFlow::Break(());
            }
            return visit(run, truth);
        };
        let mut bind = |run: &mut StepContext<'_>, value: Value| {
            run.count_binding(*origin)?;
            run.set_local(*local, value);
            self.nest(depth + 1, run, visit)
        };
        range.each(run, *origin, &mut bind)
    }
}

impl StepContext<'_> {
    /// Counts the binding of a variable; breaks with a fault if there were too many in this step.
    #[inline]
    pub(super) fn count_binding(&mut self, origin: Origin) -> ControlFlow<()> {
        self.bindings += 1;
        if self.bindings > MAX_BINDINGS {
            self.fail(FaultKind::Endless(MAX_BINDINGS), origin);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

impl RangeCode {
    /// Calls `visit` for each value of the range, in ascending order, until it breaks.
    #[inline]
    pub(super) fn each(
        &self,
        run: &mut StepContext<'_>,
        origin: Origin,
        visit: &mut impl FnMut(&mut StepContext<'_>, Value) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match self {
            Self::Ints(low, high) => {
                (*low..=*high).try_for_each(|number| visit(run, Value::Int(number)))
            }
            Self::Atoms(first, count) => {
                (*first..*first + *count).try_for_each(|atom| visit(run, Value::Atom(Atom(atom))))
            }
            Self::Bools => [false, true]
                .into_iter()
                .try_for_each(|truth| visit(run, Value::Bool(truth))),
            Self::Domain(domain) => match run.elements(*domain) {
                Ok(elements) => elements
                    .iter()
                    .try_for_each(|element| visit(run, element.clone())),
                Err(kind) => {
                    run.fail(kind, origin);
                    ControlFlow::Break(())
                }
            },
            Self::Extent(shape) => match run.each_value(shape, visit) {
                Ok(done) => done,
                Err(kind) => {
                    run.fail(kind, origin);
                    ControlFlow::Break(())
                }
            },
            Self::Elements(term) => {
                let collection = term(run);
                if run.fault.is_some() {
                    return ControlFlow::Break(());
                }
                match &collection {
                    Value::Set(elements) => elements
                        .iter()
                        .try_for_each(|element| visit(run, element.clone())),
                    Value::Seq(elements) => elements
                        .iter()
                        .try_for_each(|element| visit(run, element.clone())),
                    Value::Bag(elements) => elements.iter().try_for_each(|(element, &count)| {
                        (0..count).try_for_each(|_| visit(run, element.clone()))
                    }),
                    Value::Undef
                    | Value::Bool(_)
                    | Value::Int(_)
                    | Value::Real(_)
                    | Value::Char(_)
                    | Value::Atom(_)
                    | Value::Rule(_)
                    | Value::Text(_)
                    | Value::Complex(_)
                    | Value::Tuple(_)
                    | Value::Map(_) => {
                        run.fail(FaultKind::NotACollection(collection), origin);
                        ControlFlow::Break(())
                    }
                }
            }
        }
    }
}
