//! Specifications that are ready to be run.

use crate::bind_error::BindError;
use crate::binding::Binding;
use crate::fingerprint::fingerprint;
use crate::partners::MessagePartners;
use crate::terms::BindingTerms;
use crate::watch::Watch;
use crate::watcher::Watcher;
use asmotion_datum::Schema;
use asmotion_lang::machine::Machine;
use asmotion_lang::{Specification, Style};
use std::sync::{Arc, Mutex, PoisonError};

/// A specification with its bindings and watched properties, ready to be run by any number of coordinators.
///
/// Its coordinators share texts, model, program and compiled code. Each has a machine and monitors of its own, which begin as
/// copies of those here.
pub struct PreparedSpecification {
    /// The specification, with the terms of the bindings and the safe rule.
    pub(crate) specification: Specification,
    pub(crate) binding: Arc<Binding>,
    pub(crate) terms: BindingTerms,
    /// Fingerprint of the specification and the bindings, stored in frozen states.
    pub(crate) fingerprint: String,
    /// The watcher before the first step.
    pub(crate) watcher: Watcher,
    /// The machine in its initial state, without partners.
    initial: Machine,
    /// The message types of the ports of its coordinators, each once.
    schemas: Mutex<Vec<Arc<Schema>>>,
}

impl PreparedSpecification {
    /// Adds the bindings and the watched properties to a specification, and computes its initial state.
    ///
    /// # Errors
    /// A binding, a property or the safe rule does not fit the specification, or the initial state cannot be built.
    pub fn new(
        mut specification: Specification,
        binding: Arc<Binding>,
        watch: &Watch,
    ) -> Result<Self, BindError> {
        let terms = BindingTerms::add(&binding, &mut specification)?;
        let watcher = Watcher::new(&mut specification, watch)?;
        let initial = specification.machine().map_err(|fault| {
            let finding = specification.explain(&fault);
            let sources = &specification.sources;
            BindError::Initial(asmotion_lang::render(&finding, sources, Style::Plain))
        })?;
        Ok(Self {
            fingerprint: fingerprint(&specification, &binding, watch),
            specification,
            binding,
            terms,
            watcher,
            initial,
            schemas: Mutex::default(),
        })
    }

    /// Returns whether it was prepared with these bindings and this watch.
    pub fn has(&self, binding: &Arc<Binding>, watch: &Watch) -> bool {
        // those of instances are often shared
        let has_binding = Arc::ptr_eq(&self.binding, binding) || self.binding == *binding;
        has_binding && self.watcher.watch == *watch
    }

    /// Returns the message type that all coordinators with such a port share.
    pub(crate) fn schema(&self, schema: &Schema) -> Arc<Schema> {
        let mut known = self.schemas.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known.iter().find(|it| ***it == *schema) {
            return Arc::clone(found);
        }
        let shared = Arc::new(schema.clone());
        known.push(Arc::clone(&shared));
        shared
    }

    /// Returns a machine in the initial state.
    pub(crate) fn machine(&self, partners: &MessagePartners) -> Machine {
        let mut machine = self.initial.clone();
        machine.set_partners(partners.agents());
        machine
    }
}
