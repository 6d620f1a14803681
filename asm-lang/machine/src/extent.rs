//! The elements of domains and shapes, listed.

use crate::fault::FaultKind;
use crate::limits::MAX_ELEMENTS;
use crate::run::Run;
use asmotion_ir::{DomainId, Elements, Shape};
use asmotion_value::Value;
use std::collections::BTreeSet;
use std::sync::Arc;

impl Run<'_> {
    /// The elements of a domain, ascending.
    pub fn elements(&self, domain: DomainId) -> Result<Arc<Vec<Value>>, FaultKind> {
        match self.program.domains[domain.0 as usize].elements {
            Elements::Ints { low, high } => {
                let count = high.abs_diff(low).saturating_add(1);
                if count > MAX_ELEMENTS {
                    return Err(FaultKind::TooLarge(count));
                }
                Ok(Arc::new((low..=high).map(Value::Int).collect()))
            }
            Elements::Open => Err(FaultKind::Infinite),
            Elements::Atoms { .. } | Elements::Computed(_) | Elements::Undefined => {
                Ok(self.state.store.extents[domain.0 as usize].clone())
            }
        }
    }

    /// All values of a shape, ascending.
    pub fn extent(&self, shape: &Shape) -> Result<Vec<Value>, FaultKind> {
        match shape {
            Shape::Bool => Ok(vec![Value::Bool(false), Value::Bool(true)]),
            Shape::Domain(domain) => Ok(self.elements(*domain)?.to_vec()),
            Shape::Tuple(items) => {
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
            Shape::Set(item) => {
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
            Shape::Int
            | Shape::Natural
            | Shape::Real
            | Shape::Char
            | Shape::Text
            | Shape::Complex
            | Shape::Rule
            | Shape::Seq(_)
            | Shape::Bag(_)
            | Shape::Map(..)
            | Shape::Any => Err(FaultKind::Infinite),
        }
    }
}
