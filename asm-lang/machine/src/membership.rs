//! Membership of values in domains, in the current state of a step.

use crate::fault::FaultKind;
use crate::machine::Machine;
use crate::misfit::{DomainMisfit, is_listed};
use crate::run::{RuleStopped, StepContext};
use asmotion_ir::{DomainElements, DomainId, FunctionId, Origin, Slot, ValueShape};
use asmotion_value::Value;

impl Machine {
    /// Returns whether a value and its parts are elements of the domains of a shape in the current state. `undef` is one of every
    /// domain, and a domain without a definition contains every value. Where the specification is run as the reference runs it,
    /// nothing is tested.
    pub fn contains(&self, shape: &ValueShape, value: &Value) -> bool {
        let (program, extents) = (self.program(), &self.state().store.extents);
        let is_element = |domain: DomainId, value: &Value| {
            program.domains[domain.0 as usize].elements == DomainElements::Undefined
                || is_listed(program, extents, domain, value)
        };
        program.compatible || shape.outsider(value, &is_element).is_none()
    }
}

impl StepContext<'_> {
    /// Returns the part of a value that is outside its function's codomain, if any.
    pub fn misfit(&self, function: FunctionId, value: &Value) -> Option<DomainMisfit> {
        DomainMisfit::of_value(self.program, function, value, &|domain, value| {
            self.is_element(domain, value)
        })
    }

    /// Returns the first part of a value that is outside its domain in the codomain of a function.
    pub fn misfit_of_parts(&self, function: FunctionId, value: &Value) -> Option<DomainMisfit> {
        let codomain = &self.program.functions[function.0 as usize].codomain;
        DomainMisfit::of(self.program, function, codomain, value, &|domain, value| {
            self.is_element(domain, value)
        })
    }

    /// Returns the part of a location's arguments, which are on the stack, that is outside the
    /// function's domain, if any.
    pub fn misplaced(&self, function: FunctionId, arguments: usize) -> Option<DomainMisfit> {
        let declared = &self.program.functions[function.0 as usize];
        if !declared.narrow || self.program.compatible {
            return None;
        }
        let mut pairs = declared.parameters.iter().zip(&self.stack[arguments..]);
        pairs.find_map(|(shape, value)| {
            DomainMisfit::of(self.program, function, shape, value, &|domain, value| {
                self.program.domains[domain.0 as usize].grows || self.is_element(domain, value)
            })
        })
    }

    /// Stops a rule that updates a location with an argument outside the function's domain.
    /// Arguments inside the domain on first access need no further check. Those outside are checked
    /// again, because the location may have been accessed before the initial state was complete.
    ///
    /// # Errors
    /// [`RuleStopped`], with [`FaultKind::OutsideArgument`] in the context.
    pub fn check_place(&mut self, slot: Slot, origin: Origin) -> Result<(), RuleStopped> {
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

    /// Returns `true` if a value is an element of a domain in the current state or joins it in this
    /// step.
    pub fn is_element(&self, domain: DomainId, value: &Value) -> bool {
        is_listed(self.program, &self.state.store.extents, domain, value)
            || self.is_joining(domain, value)
    }

    /// Returns `true` if a value is an element that an update of this step adds to the domain.
    fn is_joining(&self, domain: DomainId, value: &Value) -> bool {
        let Value::Atom(atom) = value else {
            return false;
        };
        let declared = self.program.atom_domains.len();
        !self.program.compatible
            && atom.0 as usize >= declared
            && self
                .state
                .store
                .domain_of(self.program, *atom)
                .is_some_and(|of| self.code.supers[of.0 as usize].contains(&domain))
    }
}
