//! Scopes: the names visible in a file.

use crate::id::{DomainId, FunctionId};
use asmotion_diagnostics::similar;
use asmotion_value::{Atom, RuleId};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The names visible in one file: its own and those it imports.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scope {
    pub domains: BTreeMap<Arc<str>, DomainId>,
    pub functions: BTreeMap<Arc<str>, Vec<FunctionId>>,
    pub rules: BTreeMap<Arc<str>, Vec<RuleId>>,
    pub literals: BTreeMap<Arc<str>, Vec<Atom>>,
}

impl Scope {
    /// Adds the names of another file that pass the filter. Literals follow their domain, which the
    /// filter `literal` decides.
    pub fn import(
        &mut self,
        other: &Scope,
        filter: impl Fn(&str) -> bool,
        literal: impl Fn(Atom) -> bool,
    ) {
        for (name, &domain) in &other.domains {
            if filter(name) {
                self.domains.entry(name.clone()).or_insert(domain);
            }
        }
        merge(&mut self.functions, &other.functions, |name, _| {
            filter(name)
        });
        merge(&mut self.rules, &other.rules, |name, _| filter(name));
        merge(&mut self.literals, &other.literals, |_, atom| literal(atom));
    }

    /// Adds the names of another file that this scope lacks.
    pub fn complete(&mut self, other: &Scope) {
        fn missing<T: Clone>(into: &mut BTreeMap<Arc<str>, T>, from: &BTreeMap<Arc<str>, T>) {
            for (name, item) in from {
                into.entry(name.clone()).or_insert_with(|| item.clone());
            }
        }
        missing(&mut self.domains, &other.domains);
        missing(&mut self.functions, &other.functions);
        missing(&mut self.rules, &other.rules);
        missing(&mut self.literals, &other.literals);
    }

    /// Returns the most similar name of a function.
    pub fn similar_function(&self, name: &str) -> Option<Arc<str>> {
        similar(name, self.functions.keys()).cloned()
    }

    /// Returns the most similar name of a domain or literal.
    pub fn similar_constant(&self, name: &str) -> Option<Arc<str>> {
        similar(name, self.domains.keys().chain(self.literals.keys())).cloned()
    }

    /// Returns the literal that differs from the name at most in the case of its letters: `IDLE` for `idle`.
    pub fn literal_ignoring_case(&self, name: &str) -> Option<(Arc<str>, Atom)> {
        let mut literals = self.literals.iter();
        let (literal, atoms) = literals.find(|(it, _)| it.eq_ignore_ascii_case(name))?;
        Some((literal.clone(), *atoms.first()?))
    }

    /// Returns the most similar name of a domain.
    pub fn similar_domain(&self, name: &str) -> Option<Arc<str>> {
        similar(name, self.domains.keys()).cloned()
    }

    /// Returns the most similar name of a rule.
    pub fn similar_rule(&self, name: &str) -> Option<Arc<str>> {
        similar(name, self.rules.keys()).cloned()
    }
}

fn merge<T: Copy + PartialEq>(
    into: &mut BTreeMap<Arc<str>, Vec<T>>,
    from: &BTreeMap<Arc<str>, Vec<T>>,
    filter: impl Fn(&str, T) -> bool,
) {
    for (name, items) in from {
        for &item in items {
            if filter(name, item) {
                let known = into.entry(name.clone()).or_default();
                if !known.contains(&item) {
                    known.push(item);
                }
            }
        }
    }
}
