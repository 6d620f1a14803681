//! Names of atoms and rules for output.

use asmotion_ir::{DomainId, Program};
use asmotion_value::{Atom, RuleId, ValueNames, element_name};
use std::fmt;

/// The names of the atoms and rules of a machine in its current state.
#[derive(Clone, Copy)]
pub struct Naming<'a> {
    /// Provides the names of declared elements and rules.
    pub program: &'a Program,
    /// The elements created from the reserve: domain, and number within it.
    pub reserve: &'a [(DomainId, u32)],
}

impl ValueNames for Naming<'_> {
    fn atom(&self, atom: Atom, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let index = atom.0 as usize;
        let symbols = &self.program.symbols;
        if let Some(name) = symbols.atoms.get(index) {
            return to.write_str(name);
        }
        match self.reserve.get(index - symbols.atoms.len()) {
            Some((domain, number)) => {
                to.write_str(&element_name(&symbols.domains[domain.0 as usize], number))
            }
            None => write!(to, "atom!{index}"),
        }
    }

    fn rule(&self, rule: RuleId, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.program.symbols.rules.get(rule.0 as usize) {
            Some(name) => write!(to, "<<{name}>>"),
            None => write!(to, "<<rule {}>>", rule.0),
        }
    }
}
