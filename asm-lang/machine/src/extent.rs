//! Enumeration of domains and shapes.

use crate::fault::FaultKind;
use crate::limits::MAX_ELEMENTS;
use crate::machine::Machine;
use crate::run::StepContext;
use asmotion_ir::{DomainElements, DomainId, Program, ValueShape};
use asmotion_value::Value;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Lists the elements of a domain in ascending order.
type ListDomain<'a> = &'a dyn Fn(DomainId) -> Result<Arc<Vec<Value>>, FaultKind>;

impl StepContext<'_> {
    /// Returns the elements of a domain in the current state, in ascending order.
    ///
    /// # Errors
    /// [`FaultKind::Infinite`] for an open domain such as Integer, [`FaultKind::TooLarge`] for an interval with too
    /// many elements.
    pub fn elements(&self, domain: DomainId) -> Result<Arc<Vec<Value>>, FaultKind> {
        let extents = &self.state.store.extents;
        elements(self.program, extents, domain, MAX_ELEMENTS)
    }

    /// Returns all values of a shape, in ascending order.
    ///
    /// # Errors
    /// [`FaultKind::Infinite`] or [`FaultKind::TooLarge`], as for [`elements`](Self::elements).
    pub fn extent(&self, shape: &ValueShape) -> Result<Vec<Value>, FaultKind> {
        values(shape, MAX_ELEMENTS, &|domain| self.elements(domain))
    }

    /// Calls `visit` for each value of a shape, in ascending order, until it breaks. Sets are built one at a time, because all
    /// of them take much memory.
    ///
    /// # Errors
    /// As for [`extent`](Self::extent).
    pub(crate) fn each_value(
        &mut self,
        shape: &ValueShape,
        visit: &mut dyn FnMut(&mut StepContext<'_>, Value) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, FaultKind> {
        if let ValueShape::Set(item) = shape {
            let items = self.extent(item)?;
            within(count_subsets(items.len()), MAX_ELEMENTS)?;
            return Ok(each_subset(&items, &mut Vec::new(), &mut |set| {
                visit(self, set)
            }));
        }
        let mut all = self.extent(shape)?.into_iter();
        Ok(all.try_for_each(|value| visit(self, value)))
    }
}

impl Machine {
    /// Returns the elements of a shape in ascending order, as they are in the current state; `None` if there are more than `limit`.
    pub fn elements(&self, shape: &ValueShape, limit: usize) -> Option<Vec<Value>> {
        let limit = limit as u64;
        let (program, extents) = (self.program(), &self.state().store.extents);
        let listed = |domain: DomainId| {
            let declared = program.domains.get(domain.0 as usize);
            // without a definition, any value may be an element
            if declared.is_none_or(|it| it.elements == DomainElements::Undefined) {
                return Err(FaultKind::Infinite);
            }
            let all = elements(program, extents, domain, limit)?;
            within(all.len() as u64, limit)?;
            Ok(all)
        };
        values(shape, limit, &listed).ok()
    }
}

fn elements(
    program: &Program,
    extents: &[Arc<Vec<Value>>],
    domain: DomainId,
    limit: u64,
) -> Result<Arc<Vec<Value>>, FaultKind> {
    match program.domains[domain.0 as usize].elements {
        DomainElements::Ints { low, high } => {
            within(high.abs_diff(low).saturating_add(1), limit)?;
            Ok(Arc::new((low..=high).map(Value::Int).collect()))
        }
        DomainElements::Open => Err(FaultKind::Infinite),
        DomainElements::Atoms { .. } | DomainElements::Computed(_) | DomainElements::Undefined => {
            Ok(extents[domain.0 as usize].clone())
        }
    }
}

/// Returns all values of a shape, in ascending order.
fn values(shape: &ValueShape, limit: u64, domain: ListDomain<'_>) -> Result<Vec<Value>, FaultKind> {
    match shape {
        ValueShape::Bool => Ok(vec![Value::Bool(false), Value::Bool(true)]),
        ValueShape::Domain(id) => Ok(domain(*id)?.to_vec()),
        ValueShape::Tuple(items) => {
            let mut tuples: Vec<Vec<Value>> = vec![Vec::new()];
            for item in items {
                let items = values(item, limit, domain)?;
                within(
                    (tuples.len() as u64).saturating_mul(items.len() as u64),
                    limit,
                )?;
                let longer = |tuple: &Vec<Value>, value: &Value| {
                    let mut tuple = tuple.clone();
                    tuple.push(value.clone());
                    tuple
                };
                let longer = tuples
                    .iter()
                    .flat_map(|tuple| items.iter().map(move |value| longer(tuple, value)));
                tuples = longer.collect();
            }
            Ok(tuples.into_iter().map(Value::tuple).collect())
        }
        ValueShape::Set(item) => {
            let items = values(item, limit, domain)?;
            within(count_subsets(items.len()), limit)?;
            let mut sets = Vec::new();
            // the visitor never breaks
            let _ = each_subset(&items, &mut Vec::new(), &mut |set| {
                sets.push(set);
                ControlFlow::Continue(())
            });
            Ok(sets)
        }
        ValueShape::Int
        | ValueShape::Natural
        | ValueShape::Real
        | ValueShape::Char
        | ValueShape::Text
        | ValueShape::Complex
        | ValueShape::Rule
        | ValueShape::Seq(_)
        | ValueShape::Bag(_)
        | ValueShape::Map(..)
        | ValueShape::Any => Err(FaultKind::Infinite),
    }
}

/// Returns an error if there are more elements than the limit.
fn within(count: u64, limit: u64) -> Result<(), FaultKind> {
    if count > limit {
        return Err(FaultKind::TooLarge(count));
    }
    Ok(())
}

/// Returns the number of subsets of a set with this many elements, at most `u64::MAX`.
fn count_subsets(elements: usize) -> u64 {
    let subsets = u32::try_from(elements).ok();
    let subsets = subsets.and_then(|elements| 1_u64.checked_shl(elements));
    subsets.unwrap_or(u64::MAX)
}

/// Calls `visit` for the set of the chosen values and for each of its unions with values of `items`, until it breaks. The sets
/// are in ascending order if the chosen values, followed by `items`, are.
fn each_subset(
    items: &[Value],
    chosen: &mut Vec<Value>,
    visit: &mut dyn FnMut(Value) -> ControlFlow<()>,
) -> ControlFlow<()> {
    visit(Value::set(chosen.iter().cloned()))?;
    for (index, item) in items.iter().enumerate() {
        chosen.push(item.clone());
        each_subset(&items[index + 1..], chosen, visit)?;
        chosen.pop();
    }
    ControlFlow::Continue(())
}
