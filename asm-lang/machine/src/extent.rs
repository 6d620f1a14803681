//! How many values there may be: domains and shapes listed, collections bounded.

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
                Ok(self.state.extents[domain.0 as usize].clone())
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

/// Values may nest this deep.
const MAX_NESTING: usize = 500;

/// Whether a value nests no deeper and holds no more elements than anything else in a machine; what
/// it shares counts as often as it stands.
pub(crate) fn is_bounded(value: &Value) -> bool {
    let mut room = MAX_ELEMENTS;
    is_within(value, MAX_NESTING, &mut room)
}

/// Whether a value nests no deeper than `depth`, and holds no more than there is room for.
fn is_within(value: &Value, depth: usize, room: &mut u64) -> bool {
    fn all<'a>(items: impl IntoIterator<Item = &'a Value>, depth: usize, room: &mut u64) -> bool {
        depth > 0
            && items.into_iter().all(|item| {
                *room = room.saturating_sub(1);
                *room > 0 && is_within(item, depth - 1, room)
            })
    }
    match value {
        Value::Undef
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Real(_)
        | Value::Char(_)
        | Value::Atom(_)
        | Value::Rule(_)
        | Value::Text(_)
        | Value::Complex(_) => true,
        Value::Tuple(items) | Value::Seq(items) => all(items.iter(), depth, room),
        Value::Set(items) => all(items.iter(), depth, room),
        Value::Bag(items) => all(items.keys(), depth, room),
        Value::Map(pairs) => all(pairs.keys(), depth, room) && all(pairs.values(), depth, room),
    }
}
