//! Ranges of rules whose guard an index answers; see [`asmotion_ir::IndexedGuard`].
//!
//! The elements that satisfy the equation count as bindings, and no others: with an index no others are visited. The count is
//! the same where the elements are visited one by one, and in native code, so that a fault does not depend on it.

use super::Compiler;
use super::range::Ranges;
use crate::fault::FaultKind;
use crate::run::code::{TermCode, TruthCode};
use crate::run::{KleeneTruth, StepContext};
use crate::state::{IndexKey, IndexState, RangeIndex};
use asmotion_ir::{Binder, FunctionId, Term, TermNode};
use asmotion_value::Value;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The index of a range, and the guard in parts.
pub(super) struct IndexedRanges {
    function: FunctionId,
    at: IndexKey,
    equation: TruthCode,
    key: TermCode,
    rest: Option<TruthCode>,
    /// `true` if all elements are arguments of locations that always exist.
    is_static: bool,
    /// `true` in code that records what it reads: it visits each element.
    is_watched: bool,
}

/// The elements that a range has in a state.
pub(super) enum Elements {
    /// Those that the index lists under this value.
    Index(Arc<RangeIndex>, Value),
    /// Unknown: the equation is evaluated for each element of the range.
    Each,
    /// Unknown, and each element of the range counts.
    Counted,
}

impl Compiler<'_> {
    pub(super) fn indexed(
        &self,
        binders: &[Binder],
        guard: Option<&Term>,
    ) -> Option<IndexedRanges> {
        let indexed = self.program.indexed_guard(binders, guard)?;
        let [binder] = binders else {
            return None;
        };
        let parts = indexed.equation.node.terms();
        let is_watched = parts
            .iter()
            .any(|part| matches!(&*part.node, TermNode::Watched(_)));
        Some(IndexedRanges {
            function: indexed.function,
            at: IndexKey::of(indexed.function, &binder.range)?,
            equation: self.truth(indexed.equation),
            key: self.term(indexed.key),
            rest: indexed.rest.as_ref().map(|rest| self.truth(rest)),
            is_static: indexed.is_static,
            is_watched,
        })
    }
}

impl Elements {
    /// Returns all elements, in ascending order, if the index lists them.
    pub fn listed(&self) -> Option<&[Value]> {
        match self {
            Self::Index(index, key) => Some(index.group(key)),
            Self::Each | Self::Counted => None,
        }
    }
}

impl IndexedRanges {
    /// Returns `true` if an equation is the whole guard, and elements that do not satisfy it do not count.
    pub fn is_answered(&self, elements: &Elements) -> bool {
        self.rest.is_none()
            && match elements {
                Elements::Index(..) | Elements::Each => true,
                Elements::Counted => false,
            }
    }
}

impl Ranges {
    /// Calls `visit` for each of these elements that satisfies the guard. `counts` is `false` if the caller counts the elements
    /// that it takes.
    pub(super) fn each_of(
        &self,
        elements: &Elements,
        counts: bool,
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>) -> ControlFlow<()>,
    ) {
        let Some(indexed) = &self.indexed else {
            return self.each_in_full(run, visit);
        };
        let Some((local, range, origin)) = self.binders.first() else {
            return;
        };
        let mut satisfying = |run: &mut StepContext<'_>| {
            if counts {
                run.count_binding(*origin)?;
            }
            let holds = match &indexed.rest {
                Some(rest) => rest(run),
                None => KleeneTruth::True,
            };
            if run.fault.is_some() {
                return ControlFlow::Break(());
            }
            match holds {
                KleeneTruth::True => visit(run),
                KleeneTruth::False => ControlFlow::Continue(()),
                KleeneTruth::Undef => {
                    run.fail(FaultKind::UndefinedGuard, self.guard_origin);
                    ControlFlow::Break(())
                }
            }
        };
        match elements {
            Elements::Counted => self.each_in_full(run, visit),
            Elements::Index(index, key) => {
                // a break carries no information, as in `each`
                let _ = index.group(key).iter().try_for_each(|element| {
                    run.set_local(*local, element.clone());
                    satisfying(run)
                });
            }
            Elements::Each => {
                let _ = range.each(run, *origin, &mut |run, element| {
                    run.set_local(*local, element);
                    let holds = (indexed.equation)(run);
                    if run.fault.is_some() {
                        return ControlFlow::Break(());
                    }
                    match holds {
                        KleeneTruth::True => satisfying(run),
                        // an equation is never undef
                        KleeneTruth::False | KleeneTruth::Undef => ControlFlow::Continue(()),
                    }
                });
            }
        }
    }

    /// Returns the elements that satisfy the equation, as far as they are known; `None` if the guard has none, or within a
    /// sequence, where the state is not that of the index.
    pub(super) fn elements(&self, run: &mut StepContext<'_>) -> Option<Elements> {
        let indexed = self.indexed.as_ref()?;
        run.updates
            .is_outermost()
            .then(|| self.elements_outside(indexed, run))
    }

    fn elements_outside(&self, indexed: &IndexedRanges, run: &mut StepContext<'_>) -> Elements {
        if indexed.is_watched {
            return Elements::Each;
        }
        let index = match run.state.memo.indices.at(indexed.at, run.round) {
            IndexState::First => return Elements::Each,
            IndexState::Refused => return Elements::Counted,
            IndexState::Built(index) => index,
            IndexState::Missing(buffer) => match self.built(indexed, run, buffer) {
                Some(index) => index,
                None if indexed.is_static => return Elements::Each,
                None => return Elements::Counted,
            },
        };
        if index.is_empty() {
            return Elements::Index(index, Value::Undef);
        }
        let key = (indexed.key)(run);
        if run.fault.is_some() {
            // no group has this value
            return Elements::Index(Arc::default(), key);
        }
        Elements::Index(index, key)
    }

    /// Builds the index; `None` if a location was not accessed before, because an index does not access it.
    fn built(
        &self,
        indexed: &IndexedRanges,
        run: &mut StepContext<'_>,
        mut buffer: Arc<RangeIndex>,
    ) -> Option<Arc<RangeIndex>> {
        let (_, range, origin) = self.binders.first()?;
        let mut pairs = Vec::new();
        let listed = range.each(run, *origin, &mut |run, element| {
            let slot = run.state.slot(
                run.program,
                indexed.function,
                std::slice::from_ref(&element),
            );
            let Some(slot) = slot else {
                return ControlFlow::Break(());
            };
            pairs.push((element, run.state.get(slot).clone()));
            ControlFlow::Continue(())
        });
        if listed.is_break() || run.fault.is_some() {
            run.state.memo.indices.set(indexed.at, None);
            return None;
        }
        if Arc::get_mut(&mut buffer).is_none() {
            buffer = Arc::default();
        }
        if let Some(index) = Arc::get_mut(&mut buffer) {
            index.build(&mut pairs);
        }
        run.state.memo.indices.set(indexed.at, Some(buffer.clone()));
        Some(buffer)
    }
}
