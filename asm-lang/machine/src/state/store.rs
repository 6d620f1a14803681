//! What a state is: the values of its locations, the elements of its domains.

use asmotion_ir::{DomainElements, DomainId, Program};
use asmotion_value::{Atom, Value};
use std::sync::Arc;

/// What a state is. Two states with the same store, read by the same [`Locations`](super::Locations),
/// go on in the same way; nothing else of a [`State`](super::MachineState) matters to what a step does.
#[derive(Clone)]
pub(crate) struct Store {
    /// What each slot holds.
    pub slots: Vec<Value>,
    /// The elements of each domain, ascending.
    pub extents: Vec<Arc<Vec<Value>>>,
    /// The elements taken from the reserve, in the order they were taken, and the number of each within
    /// its domain. The first one is the atom after the declared ones.
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

    /// A new element for a domain.
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

    /// The domain an atom was declared in or taken for.
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

/// The elements of a domain that are known from the program alone.
fn listed(elements: &DomainElements) -> Vec<Value> {
    match elements {
        // intervals are ranged over without listing them; see `extent`
        DomainElements::Ints { .. } => Vec::new(),
        DomainElements::Atoms { first, count } => (first.0..first.0 + count)
            .map(|atom| Value::Atom(Atom(atom)))
            .collect(),
        DomainElements::Computed(_) | DomainElements::Undefined | DomainElements::Open => {
            Vec::new()
        }
    }
}
