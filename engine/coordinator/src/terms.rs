//! The terms of a binding: conditions of timers, and values of the specification in messages and requests.

use crate::bind_error::BindError;
use crate::binding::{Binding, terms};
use asmotion_lang::Specification;
use asmotion_lang::ir::AddedTerm;
use std::collections::BTreeMap;

/// The terms of a binding, added to its specification.
pub(crate) struct BindingTerms(BTreeMap<String, AddedTerm>);

impl BindingTerms {
    /// Adds the terms of a binding to a specification.
    ///
    /// # Errors
    /// A term does not fit the specification.
    pub fn add(binding: &Binding, specification: &mut Specification) -> Result<Self, BindError> {
        let mut added = BTreeMap::new();
        for term in terms(binding) {
            if added.contains_key(term) {
                continue;
            }
            let name = format!("<binding {}>", added.len() + 1);
            let found = specification.add_term(&name, term);
            let found = found.map_err(|report| invalid(term, &report))?;
            added.insert(term.to_owned(), found);
        }
        Ok(Self(added))
    }

    /// A term that has been added.
    ///
    /// # Errors
    /// The binding does not contain the term.
    pub fn get(&self, term: &str) -> Result<AddedTerm, BindError> {
        let known = self.0.get(term).copied();
        known.ok_or_else(|| BindError::InvalidTerm {
            term: term.to_owned(),
            reason: "it is not part of the binding".to_owned(),
        })
    }
}

fn invalid(term: &str, report: &asmotion_lang::diagnostics::Report) -> BindError {
    let first = report.diagnostics.first();
    BindError::InvalidTerm {
        term: term.to_owned(),
        reason: first.map(|it| it.message.clone()).unwrap_or_default(),
    }
}
