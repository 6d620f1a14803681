//! The variables and inputs that terms and rules access.

use crate::program::{FAULT, GroundCandidate, GroundRule, GroundTarget, GroundTerm, TableIndex};
use std::collections::BTreeSet;

/// Variables and inputs that a term or rule may access.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Accesses {
    /// Indices of the state variables that it may read.
    pub reads: BTreeSet<u32>,
    /// Indices of the state variables that it may update.
    pub writes: BTreeSet<u32>,
    /// Indices of the inputs that it may read.
    pub inputs: BTreeSet<u32>,
    /// `true` if a part of it needs a machine whatever the state, so that nothing is known about its accesses.
    pub needs_machine: bool,
}

/// Returns what a term may access.
pub fn accesses_of_term(term: &GroundTerm) -> Accesses {
    let mut accesses = Accesses::default();
    accesses.term(term);
    accesses
}

/// Returns what a rule may access.
pub fn accesses_of_rule(rule: &GroundRule) -> Accesses {
    let mut accesses = Accesses::default();
    accesses.rule(rule);
    accesses
}

impl GroundTerm {
    /// Returns the direct subterms, in order of evaluation.
    pub fn parts(&self) -> Vec<&GroundTerm> {
        match self {
            Self::Constant(_) | Self::Variable(_) | Self::Input(_) => Vec::new(),
            Self::Not(operand) => vec![operand],
            Self::Logic(_, left, right)
            | Self::Equal(left, right)
            | Self::Compare(_, left, right)
            | Self::Arithmetic(_, left, right) => vec![left, right],
            Self::Quantified(_, instances) => instances.iter().collect(),
            Self::If(guard, then, otherwise) => vec![guard, then, otherwise],
            Self::Table {
                indices,
                elements,
                undefined,
            } => {
                let indices = indices.iter().map(|index| &index.term);
                indices.chain(elements).chain([&**undefined]).collect()
            }
            Self::After(first, last) => first.iter().chain([&**last]).collect(),
        }
    }
}

impl Accesses {
    fn term(&mut self, term: &GroundTerm) {
        match term {
            GroundTerm::Constant(FAULT) => self.needs_machine = true,
            GroundTerm::Variable(index) => {
                self.reads.insert(*index);
            }
            GroundTerm::Input(index) => {
                self.inputs.insert(*index);
            }
            GroundTerm::Constant(_)
            | GroundTerm::Not(_)
            | GroundTerm::Logic(..)
            | GroundTerm::Quantified(..)
            | GroundTerm::Equal(..)
            | GroundTerm::Compare(..)
            | GroundTerm::Arithmetic(..)
            | GroundTerm::If(..)
            | GroundTerm::Table { .. }
            | GroundTerm::After(..) => {}
        }
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            for part in term.parts() {
                self.term(part);
            }
        });
    }

    fn rule(&mut self, rule: &GroundRule) {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || match rule {
            GroundRule::Skip => {}
            GroundRule::Machine => self.needs_machine = true,
            GroundRule::Update(target, value, _) => {
                self.term(value);
                self.target(target);
            }
            GroundRule::Par(rules) | GroundRule::Seq(rules) => {
                rules.iter().for_each(|rule| self.rule(rule));
            }
            GroundRule::If(guard, then, otherwise) => {
                self.term(guard);
                self.rule(then);
                self.rule(otherwise);
            }
            GroundRule::Choose(candidates, otherwise, _) => {
                for GroundCandidate { guard, rule, .. } in candidates {
                    self.term(guard);
                    self.rule(rule);
                }
                self.rule(otherwise);
            }
            GroundRule::After(terms, rule) => {
                terms.iter().for_each(|term| self.term(term));
                self.rule(rule);
            }
            GroundRule::Counted(_, rule) => self.rule(rule),
        });
    }

    fn target(&mut self, target: &GroundTarget) {
        match target {
            GroundTarget::Variable(index) => {
                self.writes.insert(*index);
            }
            GroundTarget::Table(indices, variables) => {
                for TableIndex { term, .. } in indices {
                    self.term(term);
                }
                self.writes.extend(variables);
            }
        }
    }
}
