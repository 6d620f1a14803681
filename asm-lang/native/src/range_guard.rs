//! Guards of ranges, of which the machine has an index for some.

use crate::bound_range::{BoundRange, total};
use crate::emit::{Emitter, UpdateMode};
use crate::limits::MIN_INDEXED;
use crate::static_analysis::counts;
use asmotion_ir::{Binder, IndexedGuard, Program, Term};
use cranelift_codegen::ir::Block;

/// The guard of a `forall` or `choose`.
pub(crate) enum RangeGuard<'t> {
    Always,
    Term(&'t Term),
    /// An index answers part of the guard. In native code, too, only elements that satisfy the equation count as bindings.
    Indexed(IndexedGuard<'t>),
}

impl RangeGuard<'_> {
    pub fn is_always(&self) -> bool {
        matches!(self, Self::Always)
    }

    pub fn is_indexed(&self) -> bool {
        matches!(self, Self::Indexed(_))
    }

    /// Returns `true` if an equation is the whole guard.
    pub fn is_answered(&self) -> bool {
        matches!(self, Self::Indexed(IndexedGuard { rest: None, .. }))
    }

    /// Returns `true` if evaluating the guard counts bindings.
    pub fn counts(&self, program: &Program) -> bool {
        match self {
            Self::Always => false,
            Self::Term(guard) => counts(program, guard),
            Self::Indexed(guard) => guard.rest.as_ref().is_some_and(|it| counts(program, it)),
        }
    }
}

impl Emitter<'_> {
    /// Returns the guard of a range. There is no index within a sequence, where the state is not that before the step.
    pub fn range_guard<'t>(
        &self,
        binders: &'t [Binder],
        guard: Option<&'t Term>,
    ) -> RangeGuard<'t> {
        let indexed = match self.mode {
            UpdateMode::Step => self.program.indexed_guard(binders, guard),
            UpdateMode::Layer | UpdateMode::Sequence => None,
        };
        match (indexed, guard) {
            (Some(indexed), _) => RangeGuard::Indexed(indexed),
            (None, Some(guard)) => RangeGuard::Term(guard),
            (None, None) => RangeGuard::Always,
        }
    }

    /// Returns `true` if closures execute a rule with this range better: by an index, which native code does not use. Executed
    /// once, native code visits the elements faster than an index is built.
    pub fn is_left_to_index(&self, guard: &RangeGuard<'_>, spans: &[BoundRange]) -> bool {
        match guard {
            RangeGuard::Always | RangeGuard::Term(_) => false,
            RangeGuard::Indexed(guard) => {
                let is_repeated = !self.loops.is_empty() && total(spans) >= MIN_INDEXED;
                !guard.is_static || is_repeated
            }
        }
    }

    /// Continues only if the guard holds; otherwise jumps. `counts` is `false` if the caller counts the elements it takes.
    pub fn range_guarded(
        &mut self,
        guard: &RangeGuard<'_>,
        counts: bool,
        spans: &[BoundRange],
        otherwise: Block,
    ) {
        match guard {
            RangeGuard::Always => {}
            RangeGuard::Term(guard) => self.guarded(Some(guard), otherwise),
            RangeGuard::Indexed(guard) => {
                self.guarded(Some(guard.equation), otherwise);
                if counts {
                    self.count_satisfying(spans);
                }
                self.guarded(guard.rest.as_ref(), otherwise);
            }
        }
    }
}
