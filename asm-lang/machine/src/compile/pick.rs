//! Candidates of a `choose` with variables that are picked from outside.

use super::indexed::Elements;
use super::range::{RangeCode, Ranges};
use crate::fault::FaultKind;
use crate::run::{KleeneTruth, StepContext};
use asmotion_ir::{Origin, ValueShape};
use asmotion_value::{Atom, Value};
use std::ops::ControlFlow;

/// The candidates that agree with the picked values.
pub(super) struct Candidates<'a> {
    ranges: &'a Ranges,
    /// The picked values, indexed by variable; `None` if no value was picked.
    picked: Option<Vec<Option<Value>>>,
    /// The elements that satisfy an equation in the guard, if there is an index.
    elements: Option<Elements>,
    /// `true` if the equation is the whole guard. Only the candidate that is taken counts as a binding.
    pub is_answered: bool,
}

impl<'a> Candidates<'a> {
    pub fn of(ranges: &'a Ranges, run: &mut StepContext<'_>) -> Self {
        let picked = |(_, _, range): &(_, _, Origin)| run.chooser.picked(*range);
        let is_picked = ranges.binders.iter().any(|binder| picked(binder).is_some());
        if !is_picked {
            let elements = ranges.elements(run);
            let is_answered = ranges
                .indexed
                .as_ref()
                .zip(elements.as_ref())
                .is_some_and(|(indexed, elements)| indexed.is_answered(elements));
            return Self {
                ranges,
                picked: None,
                elements,
                is_answered,
            };
        }
        let picked: Vec<Option<Value>> = ranges.binders.iter().map(picked).collect();
        for ((_, _, range), value) in ranges.binders.iter().zip(&picked) {
            let value = value.clone().map(|value| (*range, value));
            run.record.picked.extend(value);
        }
        Self {
            ranges,
            picked: Some(picked),
            elements: None,
            is_answered: false,
        }
    }

    /// Returns all candidates if an index lists them.
    pub fn listed(&self) -> Option<&[Value]> {
        let elements = self.elements.as_ref().filter(|_| self.is_answered);
        elements.and_then(Elements::listed)
    }

    /// Returns the picked values, if there are any.
    pub fn into_picked(self) -> Option<Vec<Value>> {
        Some(self.picked?.into_iter().flatten().collect())
    }

    /// Returns the number of candidates.
    pub fn count(&self, run: &mut StepContext<'_>) -> usize {
        if let Some(listed) = self.listed() {
            return listed.len();
        }
        let mut count = 0;
        self.each(run, &mut |_| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Binds the variables to the candidate with this index, and calls `visit`, unless there are fewer.
    pub fn take(
        &self,
        index: usize,
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>),
    ) {
        let mut taken = |run: &mut StepContext<'_>| {
            if let (true, Some((_, _, origin))) = (self.is_answered, self.ranges.binders.first()) {
                run.count_binding(*origin)?;
            }
            visit(run);
            ControlFlow::Break(())
        };
        if let (Some(listed), Some((local, ..))) = (self.listed(), self.ranges.binders.first()) {
            if let Some(element) = listed.get(index) {
                run.set_local(*local, element.clone());
                let _: ControlFlow<()> = taken(run);
            }
            return;
        }
        let mut before = 0;
        self.each(run, &mut |run| {
            if before < index {
                before += 1;
                return ControlFlow::Continue(());
            }
            taken(run)
        });
    }

    /// Calls `visit` for each candidate, in ascending order, until it breaks.
    fn each(
        &self,
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>) -> ControlFlow<()>,
    ) {
        match (&self.picked, &self.elements) {
            (None, Some(elements)) => {
                let counts = !self.is_answered;
                self.ranges.each_of(elements, counts, run, visit);
            }
            (None, None) => self.ranges.each_in_full(run, visit),
            (Some(picked), _) => {
                // a break means that `visit` broke or a fault was recorded; both are checked by the
                // caller
                let _ = self.ranges.nest_picked(0, picked, run, visit);
            }
        }
    }
}

impl Ranges {
    fn nest_picked(
        &self,
        depth: usize,
        picked: &[Option<Value>],
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some((local, range, origin)) = self.binders.get(depth) else {
            return self.guarded(run, visit);
        };
        let values = match picked.get(depth).cloned().flatten() {
            Some(value) => range.only_element(run, value, *origin),
            None => range.listed(run, *origin),
        };
        if run.fault.is_some() {
            return ControlFlow::Break(());
        }
        values.into_iter().try_for_each(|value| {
            run.set_local(*local, value);
            self.nest_picked(depth + 1, picked, run, visit)
        })
    }

    fn guarded(
        &self,
        run: &mut StepContext<'_>,
        visit: &mut dyn FnMut(&mut StepContext<'_>) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let truth = self
            .guard
            .as_ref()
            .map_or(KleeneTruth::True, |guard| guard(run));
        if run.fault.is_some() {
            return ControlFlow::Break(());
        }
        match truth {
            KleeneTruth::True => visit(run),
            KleeneTruth::False => ControlFlow::Continue(()),
            KleeneTruth::Undef => {
                run.fail(FaultKind::UndefinedGuard, self.guard_origin);
                ControlFlow::Break(())
            }
        }
    }
}

impl RangeCode {
    /// Returns the value if it lies in the range, which avoids listing the range.
    fn only_element(&self, run: &mut StepContext<'_>, value: Value, origin: Origin) -> Vec<Value> {
        let lies_in = match self {
            Self::Ints(low, high) => {
                matches!(&value, Value::Int(number) if (low..=high).contains(&number))
            }
            Self::Atoms(first, count) => {
                matches!(&value, Value::Atom(Atom(atom)) if atom.wrapping_sub(*first) < *count)
            }
            Self::Bools => matches!(value, Value::Bool(_)),
            Self::Domain(domain) => run.is_element(*domain, &value),
            Self::Extent(shape) => has_shape(run, shape, &value),
            Self::Elements(_) => self.listed(run, origin).contains(&value),
        };
        if lies_in { vec![value] } else { Vec::new() }
    }

    fn listed(&self, run: &mut StepContext<'_>, origin: Origin) -> Vec<Value> {
        let mut values = Vec::new();
        // only a fault breaks the loop, and the caller checks for it
        let _ = self.each(run, origin, &mut |_, value| {
            values.push(value);
            ControlFlow::Continue(())
        });
        values
    }
}

/// Returns `true` if a value has this shape.
fn has_shape(run: &StepContext<'_>, shape: &ValueShape, value: &Value) -> bool {
    match (shape, value) {
        (ValueShape::Any, _)
        | (ValueShape::Bool, Value::Bool(_))
        | (ValueShape::Int, Value::Int(_))
        | (ValueShape::Real, Value::Real(_))
        | (ValueShape::Char, Value::Char(_))
        | (ValueShape::Text, Value::Text(_))
        | (ValueShape::Complex, Value::Complex(_))
        | (ValueShape::Rule, Value::Rule(_)) => true,
        (ValueShape::Natural, Value::Int(number)) => *number >= 0,
        (ValueShape::Domain(domain), value) => run.is_element(*domain, value),
        (ValueShape::Tuple(shapes), Value::Tuple(items)) => {
            let mut pairs = shapes.iter().zip(items.iter());
            shapes.len() == items.len() && pairs.all(|(shape, item)| has_shape(run, shape, item))
        }
        (ValueShape::Seq(shape), Value::Seq(items)) => {
            items.iter().all(|item| has_shape(run, shape, item))
        }
        (ValueShape::Set(shape), Value::Set(items)) => {
            items.iter().all(|item| has_shape(run, shape, item))
        }
        (ValueShape::Bag(shape), Value::Bag(items)) => {
            items.keys().all(|item| has_shape(run, shape, item))
        }
        (ValueShape::Map(keys, values), Value::Map(pairs)) => pairs
            .iter()
            .all(|(key, value)| has_shape(run, keys, key) && has_shape(run, values, value)),
        _ => false,
    }
}
