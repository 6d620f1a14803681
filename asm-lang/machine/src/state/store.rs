//! The store: the values of locations and the elements of domains.

use asmotion_ir::{DomainElements, DomainId, Program};
use asmotion_value::{Atom, Value};
use std::sync::Arc;

/// The parts of a state that steps change. Two states with equal stores and equal
/// [`Locations`](super::Locations) continue in the same way; no other part of a
/// [`MachineState`](super::MachineState) affects a step.
#[derive(Clone)]
pub(crate) struct Store {
    /// Value of each slot.
    pub slots: Vec<Value>,
    /// Elements of each domain, in ascending order.
    pub extents: Vec<Arc<Vec<Value>>>,
    /// Elements created from the reserve, in order of creation, each with its domain and its number
    /// within that domain. The first one is the atom that follows the declared ones.
    pub reserve: Vec<(DomainId, u32)>,
}

impl Store {
    pub fn new(program: &Program) -> Self {
        let extents = program
            .domains
            .iter()
            .map(|domain| Arc::new(listed(&domain.elements)));
        Self {
            slots: vec![Value::Undef; program.slots as usize],
            extents: extents.collect(),
            reserve: Vec::new(),
        }
    }

    /// Creates a new element of a domain.
    pub fn fresh(&mut self, program: &Program, domain: DomainId) -> Atom {
        let last = self
            .reserve
            .iter()
            .rev()
            .find(|(known, _)| *known == domain);
        let number = last.map_or(1, |(_, number)| number + 1);
        self.reserve.push((domain, number));
        Atom((program.atom_domains.len() + self.reserve.len() - 1) as u32)
    }

    /// Returns the domain in which an atom was declared or for which it was created.
    pub fn domain_of(&self, program: &Program, atom: Atom) -> Option<DomainId> {
        let index = atom.0 as usize;
        match program.atom_domains.get(index) {
            Some(&domain) => Some(domain),
            None => self
                .reserve
                .get(index - program.atom_domains.len())
                .map(|(domain, _)| *domain),
        }
    }
}

/// Returns the elements of a domain that are known from the program alone.
fn listed(elements: &DomainElements) -> Vec<Value> {
    match elements {
        // intervals are enumerated without listing them; see `extent`
        DomainElements::Ints { .. } => Vec::new(),
        DomainElements::Atoms { first, count } => (first.0..first.0 + count)
            .map(|atom| Value::Atom(Atom(atom)))
            .collect(),
        DomainElements::Computed(_) | DomainElements::Undefined | DomainElements::Open => {
            Vec::new()
        }
    }
}
