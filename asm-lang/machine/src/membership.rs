//! Whether values are elements of the domains that functions are declared over.

use crate::fault::FaultKind;
use crate::machine::Machine;
use crate::run::{Run, Stopped};
use asmotion_ir::{DomainId, Elements, FunctionId, Initial, Origin, Program, Shape, Slot};
use asmotion_value::{Atom, Value};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A value that is none of its function's.
#[derive(Clone, Debug, PartialEq)]
pub struct Misfit {
    /// The function.
    pub function: FunctionId,
    /// The whole value.
    pub value: Value,
    /// The part of it that is at fault: the value itself, or an item of it.
    pub part: Value,
    /// The domain whose element that part is not.
    pub domain: DomainId,
}

/// An initial value that is none of its function's.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialMisfit {
    /// The arguments of the location.
    pub arguments: Vec<Value>,
    /// What does not fit.
    pub misfit: Misfit,
    /// Where the value is defined.
    pub origin: Origin,
}

impl Machine {
    /// The initial values that are none of their functions', one for each function. Such a state is
    /// run all the same: the reference does not look at it, and specifications rely on that.
    pub fn initial_misfits(&self) -> Vec<InitialMisfit> {
        let mut found: BTreeMap<FunctionId, InitialMisfit> = BTreeMap::new();
        for slot in 0..self.state.len() as Slot {
            let function = self.state.function(&self.program, slot);
            if let Some(function) = function.filter(|function| !found.contains_key(function)) {
                let misfit = self.initial_misfit(slot, function);
                found.extend(misfit.map(|misfit| (function, misfit)));
            }
        }
        found.into_values().collect()
    }

    fn initial_misfit(&self, slot: Slot, function: FunctionId) -> Option<InitialMisfit> {
        let (program, state) = (&*self.program, &self.state);
        let body = program.functions[function.0 as usize].initial?;
        // what depends on inputs is known when they are
        let is_open = |initial| !self.is_complete && program.initial_inputs.contains(&initial);
        if is_open(Initial::Function(function)) || !state.is_met(slot) {
            return None;
        }
        let is_element = |domain: DomainId, value: &Value| {
            is_open(Initial::Domain(domain))
                || is_listed(program, &state.initial_extents, domain, value)
        };
        let value = state.get_initial(slot);
        let misfit = Misfit::of_value(program, function, value, &is_element)?;
        let (_, arguments) = state.location(program, slot)?;
        Some(InitialMisfit {
            arguments,
            misfit,
            origin: program.bodies[body.0 as usize].code.origin,
        })
    }
}

impl Run<'_> {
    /// What of a value is no element of its function's codomain.
    pub fn misfit(&self, function: FunctionId, value: &Value) -> Option<Misfit> {
        Misfit::of_value(self.program, function, value, &|domain, value| {
            self.is_element(domain, value)
        })
    }

    /// What of the arguments of a location, on the stack, is no element of their function's domain.
    pub fn misplaced(&self, function: FunctionId, arguments: usize) -> Option<Misfit> {
        let declared = &self.program.functions[function.0 as usize];
        if !declared.narrow || self.program.compatible {
            return None;
        }
        let mut pairs = declared.parameters.iter().zip(&self.stack[arguments..]);
        pairs.find_map(|(shape, value)| {
            Misfit::of(self.program, function, shape, value, &|domain, value| {
                self.program.domains[domain.0 as usize].grows || self.is_element(domain, value)
            })
        })
    }

    /// Stops a rule that writes a location whose arguments are no elements of the function's domain.
    /// What was inside when it was met is so for ever; what was outside is looked at again, for the
    /// initial state may not have been made then.
    pub fn check_place(&mut self, slot: Slot, origin: Origin) -> Result<(), Stopped> {
        if !self.state.is_outside(slot) {
            return Ok(());
        }
        let Some(function) = self.state.function(self.program, slot) else {
            return Ok(());
        };
        let from = self.stack.len();
        self.state.arguments(self.program, slot, self.stack);
        let misfit = self.misplaced(function, from);
        self.stack.truncate(from);
        match misfit {
            None => Ok(()),
            Some(misfit) => Err(self.stop(FaultKind::OutsideArgument { slot, misfit }, origin)),
        }
    }

    /// Whether a value is an element of a domain now.
    pub fn is_element(&self, domain: DomainId, value: &Value) -> bool {
        is_listed(self.program, &self.state.extents, domain, value)
            || self.is_joining(domain, value)
    }

    /// Whether a value is an element that joins the domain with the updates of this step.
    fn is_joining(&self, domain: DomainId, value: &Value) -> bool {
        let Value::Atom(atom) = value else {
            return false;
        };
        let declared = self.program.symbols.atoms.len();
        !self.program.compatible
            && atom.0 as usize >= declared
            && self
                .state
                .domain_of(self.program, *atom)
                .is_some_and(|of| self.code.supers[of.0 as usize].contains(&domain))
    }
}

impl Misfit {
    /// What of a value is no element of its function's codomain. `undef` fits everywhere; what the
    /// reference does not look at, `--compat asmeta` does not either.
    fn of_value(
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

    fn of(
        program: &Program,
        function: FunctionId,
        shape: &Shape,
        value: &Value,
        is_element: &dyn Fn(DomainId, &Value) -> bool,
    ) -> Option<Self> {
        // a domain that is not defined is one of which nothing is said
        let is_element = |domain: DomainId, value: &Value| {
            let elements = &program.domains[domain.0 as usize].elements;
            *elements == Elements::Undefined || is_element(domain, value)
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
    shape: &Shape,
    value: &'v Value,
    is_element: &dyn Fn(DomainId, &Value) -> bool,
) -> Option<(DomainId, &'v Value)> {
    let part = |shape: &Shape, item: &'v Value| outsider(shape, item, is_element);
    match (shape, value) {
        (_, Value::Undef) => None,
        (Shape::Domain(domain), value) => (!is_element(*domain, value)).then_some((*domain, value)),
        (Shape::Tuple(shapes), Value::Tuple(items)) => {
            let mut pairs = shapes.iter().zip(items.iter());
            pairs.find_map(|(shape, item)| part(shape, item))
        }
        (Shape::Seq(shape), Value::Seq(items)) => items.iter().find_map(|item| part(shape, item)),
        (Shape::Set(shape), Value::Set(items)) => items.iter().find_map(|item| part(shape, item)),
        (Shape::Bag(shape), Value::Bag(items)) => items.keys().find_map(|item| part(shape, item)),
        (Shape::Map(keys, values), Value::Map(pairs)) => pairs
            .iter()
            .find_map(|(key, value)| part(keys, key).or_else(|| part(values, value))),
        // other kinds of values are kept apart by their types
        _ => None,
    }
}

/// Whether a value is an element of a domain that has these elements, where they are listed.
#[inline]
fn is_listed(
    program: &Program,
    extents: &[Arc<Vec<Value>>],
    domain: DomainId,
    value: &Value,
) -> bool {
    match (&program.domains[domain.0 as usize].elements, value) {
        (Elements::Ints { low, high }, value) => {
            matches!(value, Value::Int(number) if (low..=high).contains(&number))
        }
        (Elements::Atoms { first, count }, Value::Atom(Atom(atom)))
            if atom.wrapping_sub(first.0) < *count =>
        {
            true
        }
        (Elements::Open, _) => true,
        (Elements::Atoms { .. } | Elements::Computed(_) | Elements::Undefined, value) => {
            extents[domain.0 as usize].binary_search(value).is_ok()
        }
    }
}
