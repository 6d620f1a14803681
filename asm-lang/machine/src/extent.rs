//! Enumeration of domains and shapes.

use crate::fault::FaultKind;
use crate::limits::MAX_ELEMENTS;
use crate::run::StepContext;
use asmotion_ir::{DomainElements, DomainId, ValueShape};
use asmotion_value::Value;
use std::collections::BTreeSet;
use std::sync::Arc;

impl StepContext<'_> {
    /// Returns the elements of a domain in the current state, in ascending order.
    ///
    /// # Errors
    /// [`FaultKind::Infinite`] for an open domain such as Integer, [`FaultKind::TooLarge`] for an interval with too
    /// many elements.
    pub fn elements(&self, domain: DomainId) -> Result<Arc<Vec<Value>>, FaultKind> {
        match self.program.domains[domain.0 as usize].elements {
            DomainElements::Ints { low, high } => {
                let count = high.abs_diff(low).saturating_add(1);
                if count > MAX_ELEMENTS {
                    return Err(FaultKind::TooLarge(count));
                }
                Ok(Arc::new((low..=high).map(Value::Int).collect()))
            }
            DomainElements::Open => Err(FaultKind::Infinite),
            DomainElements::Atoms { .. }
            | DomainElements::Computed(_)
            | DomainElements::Undefined => Ok(self.state.store.extents[domain.0 as usize].clone()),
        }
    }

    /// Returns all values of a shape, in ascending order.
    ///
    /// # Errors
    /// [`FaultKind::Infinite`] or [`FaultKind::TooLarge`], as for [`elements`](Self::elements).
    pub fn extent(&self, shape: &ValueShape) -> Result<Vec<Value>, FaultKind> {
        match shape {
            ValueShape::Bool => Ok(vec![Value::Bool(false), Value::Bool(true)]),
            ValueShape::Domain(domain) => Ok(self.elements(*domain)?.to_vec()),
            ValueShape::Tuple(items) => {
                let mut tuples: Vec<Vec<Value>> = vec![Vec::new()];
                for item in items {
                    let extent = self.extent(item)?;
                    let count = tuples.len() as u64 * extent.len() as u64;
                    if count > MAX_ELEMENTS {
                        return Err(FaultKind::TooLarge(count));
                    }
                    let longer = |tuple: &Vec<Value>, value: &Value| {
                        let mut tuple = tuple.clone();
                        tuple.push(value.clone());
                        tuple
                    };
                    tuples = tuples
                        .iter()
                        .flat_map(|tuple| extent.iter().map(move |value| longer(tuple, value)))
                        .collect();
                }
                Ok(tuples.into_iter().map(Value::tuple).collect())
            }
            ValueShape::Set(item) => {
                let extent = self.extent(item)?;
                let count = 1u64.checked_shl(extent.len() as u32).unwrap_or(u64::MAX);
                if extent.len() >= 20 || count > MAX_ELEMENTS {
                    return Err(FaultKind::TooLarge(count));
                }
                let subset = |mask: u64| {
                    let chosen = extent
                        .iter()
                        .enumerate()
                        .filter(move |(index, _)| mask >> index & 1 == 1);
                    Value::set(chosen.map(|(_, value)| value.clone()))
                };
                let sets: BTreeSet<Value> = (0..count).map(subset).collect();
                Ok(sets.into_iter().collect())
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
}
