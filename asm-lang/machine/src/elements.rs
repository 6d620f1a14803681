//! The elements of shapes of values.

use crate::machine::Machine;
use asmotion_ir::{DomainElements, ValueShape};
use asmotion_value::Value;

impl Machine {
    /// Returns the elements of a shape in ascending order, as they are in the current state; `None` if there are more than `limit`.
    pub fn elements(&self, shape: &ValueShape, limit: usize) -> Option<Vec<Value>> {
        match shape {
            ValueShape::Bool => Some(vec![Value::Bool(false), Value::Bool(true)]),
            ValueShape::Domain(domain) => {
                let declared = self.program().domains.get(domain.0 as usize)?;
                match declared.elements {
                    DomainElements::Ints { low, high } => {
                        let count = high.checked_sub(low)?.checked_add(1)?;
                        let fits = usize::try_from(count).is_ok_and(|count| count <= limit);
                        fits.then(|| (low..=high).map(Value::Int).collect())
                    }
                    DomainElements::Atoms { .. } | DomainElements::Computed(_) => {
                        let extent = self.state().extent(*domain);
                        (extent.len() <= limit).then(|| extent.to_vec())
                    }
                    DomainElements::Undefined | DomainElements::Open => None,
                }
            }
            ValueShape::Tuple(items) => {
                let mut all: Vec<Vec<Value>> = vec![Vec::new()];
                for item in items {
                    let items = self.elements(item, limit)?;
                    if all.len().saturating_mul(items.len()) > limit {
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
                let items = self.elements(item, limit)?;
                let count = 1_usize.checked_shl(u32::try_from(items.len()).ok()?)?;
                if count > limit {
                    return None;
                }
                let members = |set: usize| {
                    let items = items.iter().enumerate();
                    let members = items.filter(move |(index, _)| set >> index & 1 == 1);
                    members.map(|(_, item)| item.clone())
                };
                let mut sets: Vec<Value> = (0..count).map(|set| Value::set(members(set))).collect();
                sets.sort();
                Some(sets)
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
}
