//! The elements of domains.

use asmotion_lang::ir::{DomainElements, ValueShape};
use asmotion_lang::{Machine, Value};

/// Limit for the elements of a domain.
const MAX_ELEMENTS: usize = 4096;

/// Returns the elements of a shape in ascending order; `None` if there are infinitely or too many.
pub(crate) fn elements(machine: &Machine, shape: &ValueShape) -> Option<Vec<Value>> {
    match shape {
        ValueShape::Bool => Some(vec![Value::Bool(false), Value::Bool(true)]),
        ValueShape::Domain(domain) => {
            let declared = machine.program().domains.get(domain.0 as usize)?;
            match declared.elements {
                DomainElements::Ints { low, high } => {
                    let count = usize::try_from(high.checked_sub(low)?.checked_add(1)?).ok()?;
                    (count <= MAX_ELEMENTS).then(|| (low..=high).map(Value::Int).collect())
                }
                DomainElements::Atoms { .. } | DomainElements::Computed(_) => {
                    let extent = machine.state().extent(*domain);
                    (extent.len() <= MAX_ELEMENTS).then(|| extent.to_vec())
                }
                DomainElements::Undefined | DomainElements::Open => None,
            }
        }
        ValueShape::Tuple(items) => {
            let mut all: Vec<Vec<Value>> = vec![Vec::new()];
            for item in items {
                let items = elements(machine, item)?;
                if all.len().saturating_mul(items.len()) > MAX_ELEMENTS {
                    return None;
                }
                let longer = all.iter().flat_map(|start| {
                    items.iter().map(|item| {
                        let mut tuple = start.clone();
                        tuple.push(item.clone());
                        tuple
                    })
                });
                all = longer.collect();
            }
            Some(all.into_iter().map(Value::tuple).collect())
        }
        ValueShape::Set(item) => {
            let items = elements(machine, item)?;
            (items.len() <= 8).then(|| {
                let members = |set: usize| {
                    let items = items.iter().enumerate();
                    items.filter(move |(index, _)| set >> index & 1 == 1)
                };
                let sets = 0..1_usize << items.len();
                let mut sets: Vec<Value> = sets
                    .map(|set| Value::set(members(set).map(|(_, item)| item.clone())))
                    .collect();
                sets.sort();
                sets
            })
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
        | ValueShape::Any => None,
    }
}
