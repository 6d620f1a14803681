//! Values outside the domains of their functions.

use asmotion_ir::{DomainElements, DomainId, FunctionId, Program, ValueShape};
use asmotion_value::{Atom, Value};
use std::sync::Arc;

/// A value or argument outside the domain that its function is declared over.
#[derive(Clone, Debug, PartialEq)]
pub struct DomainMisfit {
    /// The function that declares the domain.
    pub function: FunctionId,
    /// The value as a whole.
    pub value: Value,
    /// The offending part: the value itself or a component of it.
    pub part: Value,
    /// The domain that does not contain the part.
    pub domain: DomainId,
}

impl DomainMisfit {
    /// Returns the first part of a value that is outside its function's codomain. `undef` belongs
    /// to every domain; `--compat asmeta` omits the checks that the reference omits.
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

    /// A value that is not an element of the domain, which is the codomain of a function.
    #[cold]
    pub(crate) fn whole(function: FunctionId, value: &Value, domain: DomainId) -> Self {
        Self {
            function,
            value: value.clone(),
            part: value.clone(),
            domain,
        }
    }

    pub(crate) fn of(
        program: &Program,
        function: FunctionId,
        shape: &ValueShape,
        value: &Value,
        is_element: &dyn Fn(DomainId, &Value) -> bool,
    ) -> Option<Self> {
        // a domain without a definition imposes no restriction
        let is_element = |domain: DomainId, value: &Value| {
            let elements = &program.domains[domain.0 as usize].elements;
            *elements == DomainElements::Undefined || is_element(domain, value)
        };
        let (domain, part) = shape.outsider(value, &is_element)?;
        Some(Self {
            function,
            value: value.clone(),
            part: part.clone(),
            domain,
        })
    }
}

/// Returns `true` if a value is in the extent of a domain; basic domains and anydomains contain
/// every value.
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
