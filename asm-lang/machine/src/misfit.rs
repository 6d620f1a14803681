//! Values that are no elements of the domains that functions are declared over.

use asmotion_ir::{DomainElements, DomainId, FunctionId, Program, ValueShape};
use asmotion_value::{Atom, Value};
use std::sync::Arc;

/// A value that is none of its function's.
#[derive(Clone, Debug, PartialEq)]
pub struct DomainMisfit {
    /// The function.
    pub function: FunctionId,
    /// The whole value.
    pub value: Value,
    /// The part of it that is at fault: the value itself, or an item of it.
    pub part: Value,
    /// The domain whose element that part is not.
    pub domain: DomainId,
}

impl DomainMisfit {
    /// What of a value is no element of its function's codomain. `undef` fits everywhere; what the
    /// reference does not look at, `--compat asmeta` does not either.
    pub(crate) fn of_value(
        program: &Program,
        function: FunctionId,
        value: &Value,
        is_element: &dyn Fn(DomainId, &Value) -> bool,
    ) -> Option<Self> {
        let declared = &program.functions[function.0 as usize];
        if !declared.restricted || program.compatible {
            return None;
        }
        Self::of(program, function, &declared.codomain, value, is_element)
    }

    pub(crate) fn of(
        program: &Program,
        function: FunctionId,
        shape: &ValueShape,
        value: &Value,
        is_element: &dyn Fn(DomainId, &Value) -> bool,
    ) -> Option<Self> {
        // a domain that is not defined is one of which nothing is said
        let is_element = |domain: DomainId, value: &Value| {
            let elements = &program.domains[domain.0 as usize].elements;
            *elements == DomainElements::Undefined || is_element(domain, value)
        };
        let (domain, part) = outsider(shape, value, &is_element)?;
        Some(Self {
            function,
            value: value.clone(),
            part: part.clone(),
            domain,
        })
    }
}

/// The first part of a value that is no element of the domain it should be of.
fn outsider<'v>(
    shape: &ValueShape,
    value: &'v Value,
    is_element: &dyn Fn(DomainId, &Value) -> bool,
) -> Option<(DomainId, &'v Value)> {
    let part = |shape: &ValueShape, item: &'v Value| outsider(shape, item, is_element);
    match (shape, value) {
        (_, Value::Undef) => None,
        (ValueShape::Domain(domain), value) => {
            (!is_element(*domain, value)).then_some((*domain, value))
        }
        (ValueShape::Tuple(shapes), Value::Tuple(items)) => {
            let mut pairs = shapes.iter().zip(items.iter());
            pairs.find_map(|(shape, item)| part(shape, item))
        }
        (ValueShape::Seq(shape), Value::Seq(items)) => {
            items.iter().find_map(|item| part(shape, item))
        }
        (ValueShape::Set(shape), Value::Set(items)) => {
            items.iter().find_map(|item| part(shape, item))
        }
        (ValueShape::Bag(shape), Value::Bag(items)) => {
            items.keys().find_map(|item| part(shape, item))
        }
        (ValueShape::Map(keys, values), Value::Map(pairs)) => pairs
            .iter()
            .find_map(|(key, value)| part(keys, key).or_else(|| part(values, value))),
        // other kinds of values are kept apart by their types
        _ => None,
    }
}

/// Whether a value is an element of a domain that has these elements, where they are listed.
#[inline]
pub(crate) fn is_listed(
    program: &Program,
    extents: &[Arc<Vec<Value>>],
    domain: DomainId,
    value: &Value,
) -> bool {
    match (&program.domains[domain.0 as usize].elements, value) {
        (DomainElements::Ints { low, high }, value) => {
            matches!(value, Value::Int(number) if (low..=high).contains(&number))
        }
        (DomainElements::Atoms { first, count }, Value::Atom(Atom(atom)))
            if atom.wrapping_sub(first.0) < *count =>
        {
            true
        }
        (DomainElements::Open, _) => true,
        (
            DomainElements::Atoms { .. } | DomainElements::Computed(_) | DomainElements::Undefined,
            value,
        ) => extents[domain.0 as usize].binary_search(value).is_ok(),
    }
}
