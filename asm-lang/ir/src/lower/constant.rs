//! Constant collections: large literals whose elements are constants become values when they are lowered.
//!
//! A term is evaluated anew each time, so `function f($a in Agent) = at({…}, $a)` would build a map of *n* entries for each
//! of *n* agents. As a constant, the map is built once.

use crate::code::{Term, TermNode};
use asmotion_hir::Collection;
use asmotion_value::Value;

/// Number of elements from which on a literal becomes a constant. Smaller ones stay terms, in which the verifier finds their
/// elements.
const MIN_ELEMENTS: usize = 16;

/// Returns the value of a listed collection if it is large and constant.
pub(super) fn listed(collection: Collection, items: &[Term]) -> Option<Value> {
    if items.len() < MIN_ELEMENTS {
        return None;
    }
    let items = items.iter().map(value).collect::<Option<Vec<Value>>>()?;
    Some(match collection {
        Collection::Set => Value::set(items),
        Collection::Seq => Value::seq(items),
        Collection::Bag => Value::bag(items),
    })
}

/// Returns the value of a listed map if it is large and constant.
pub(super) fn map(pairs: &[(Term, Term)]) -> Option<Value> {
    if pairs.len() < MIN_ELEMENTS {
        return None;
    }
    let pairs = pairs
        .iter()
        .map(|(key, of)| Some((value(key)?, value(of)?)))
        .collect::<Option<Vec<(Value, Value)>>>()?;
    Some(Value::map(pairs))
}

/// Returns the value of a constant or of a tuple of constants.
fn value(term: &Term) -> Option<Value> {
    if let TermNode::Constant(value) = &*term.node {
        return Some(value.clone());
    }
    if let TermNode::Builtin(builtin, operands) = &*term.node
        && let ("minus", [operand]) = (builtin.name, operands.as_slice())
        && let Value::Int(number) = value(operand)?
    {
        return number.checked_neg().map(Value::Int);
    }
    let TermNode::Tuple(items) = &*term.node else {
        return None;
    };
    let items = items.iter().map(value).collect::<Option<Vec<Value>>>()?;
    Some(Value::tuple(items))
}
