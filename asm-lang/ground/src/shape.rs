//! Comparison of terms and rules up to the names of variables and the order of parts where it has no meaning.

use crate::program::{GroundCandidate, GroundRule, GroundTarget, GroundTerm, TableIndex};
use asmotion_ir::{Connective, Counter};
use std::collections::HashMap;

/// New indices of variables and inputs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Renaming {
    /// New index of each state variable.
    pub variables: Vec<u32>,
    /// New index of each input.
    pub inputs: Vec<u32>,
}

/// The shape of a term or rule: equal for those that differ only in the order of parts where it has no meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shape(i64);

/// Numbers shapes. Each is known by its kind and the numbers of its parts, so that equal numbers mean equal shapes.
#[derive(Debug, Default)]
pub struct Shapes(HashMap<Vec<i64>, i64>);

impl Shapes {
    fn number(&mut self, parts: Vec<i64>) -> i64 {
        let next = self.0.len() as i64;
        *self.0.entry(parts).or_insert(next)
    }

    /// Returns the shape of a term after a renaming.
    pub fn term(&mut self, term: &GroundTerm, renaming: &Renaming) -> Shape {
        Shape(self.of_term(term, renaming))
    }

    /// Returns the shape of a rule after a renaming.
    pub fn rule(&mut self, rule: &GroundRule, renaming: &Renaming) -> Shape {
        Shape(self.of_rule(rule, renaming))
    }

    fn of_term(&mut self, term: &GroundTerm, renaming: &Renaming) -> i64 {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.of_term_here(term, renaming))
    }

    fn of_term_here(&mut self, term: &GroundTerm, renaming: &Renaming) -> i64 {
        let mut all = match term {
            GroundTerm::Constant(number) => vec![0, *number],
            GroundTerm::Variable(index) => vec![1, renamed(&renaming.variables, *index)],
            GroundTerm::Input(index) => vec![2, renamed(&renaming.inputs, *index)],
            GroundTerm::Not(_) => vec![3],
            GroundTerm::Logic(connective, ..) => vec![4, *connective as i64],
            GroundTerm::Quantified(quantifier, _) => vec![5, *quantifier as i64],
            GroundTerm::Equal(..) => vec![6],
            GroundTerm::Compare(comparison, ..) => vec![7, *comparison as i64],
            GroundTerm::Arithmetic(operation, ..) => vec![8, *operation as i64],
            GroundTerm::If(..) => vec![9],
            GroundTerm::Table { indices, .. } => {
                let mut all = vec![10, indices.len() as i64];
                all.extend(indices.iter().flat_map(index_numbers));
                all
            }
            GroundTerm::After(..) => vec![11],
        };
        let parts = match term {
            GroundTerm::Logic(connective, ..) => operands(*connective, term),
            GroundTerm::Constant(_)
            | GroundTerm::Variable(_)
            | GroundTerm::Input(_)
            | GroundTerm::Not(_)
            | GroundTerm::Quantified(..)
            | GroundTerm::Equal(..)
            | GroundTerm::Compare(..)
            | GroundTerm::Arithmetic(..)
            | GroundTerm::If(..)
            | GroundTerm::Table { .. }
            | GroundTerm::After(..) => term.parts(),
        };
        let start = all.len();
        for part in parts {
            let part = self.of_term(part, renaming);
            all.push(part);
        }
        if is_unordered(term)
            && let Some(parts) = all.get_mut(start..)
        {
            parts.sort_unstable();
        }
        self.number(all)
    }

    fn of_rule(&mut self, rule: &GroundRule, renaming: &Renaming) -> i64 {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.of_rule_here(rule, renaming))
    }

    fn of_rule_here(&mut self, rule: &GroundRule, renaming: &Renaming) -> i64 {
        let all = match rule {
            GroundRule::Skip => vec![20],
            GroundRule::Machine => vec![21],
            GroundRule::Update(target, value, origin) => {
                let mut all = vec![22, origin.0.into(), self.of_term(value, renaming)];
                match target {
                    GroundTarget::Variable(index) => {
                        all.push(renamed(&renaming.variables, *index));
                    }
                    GroundTarget::Table(indices, variables) => {
                        for index in indices {
                            all.extend(index_numbers(index));
                            all.push(self.of_term(&index.term, renaming));
                        }
                        let of = |index: &u32| renamed(&renaming.variables, *index);
                        all.extend(variables.iter().map(of));
                    }
                }
                all
            }
            // all are executed, so that their order has no meaning
            GroundRule::Par(rules) => self.rules(23, rules, renaming, true),
            GroundRule::Seq(rules) => self.rules(24, rules, renaming, false),
            GroundRule::If(guard, then, otherwise) => vec![
                25,
                self.of_term(guard, renaming),
                self.of_rule(then, renaming),
                self.of_rule(otherwise, renaming),
            ],
            GroundRule::Choose(candidates, otherwise, origin) => {
                let mut parts: Vec<(i64, i64)> = Vec::new();
                for GroundCandidate { guard, rule, .. } in candidates {
                    parts.push((self.of_term(guard, renaming), self.of_rule(rule, renaming)));
                }
                // all guards are evaluated, and each candidate is taken in some step
                parts.sort_unstable();
                let mut all = vec![26, origin.0.into(), self.of_rule(otherwise, renaming)];
                all.extend(parts.iter().flat_map(|(guard, rule)| [*guard, *rule]));
                all
            }
            GroundRule::After(terms, rule) => {
                let mut parts = Vec::new();
                for term in terms {
                    parts.push(self.of_term(term, renaming));
                }
                parts.sort_unstable();
                parts.splice(0..0, [27, self.of_rule(rule, renaming)]);
                parts
            }
            GroundRule::Counted(counter, rule) => {
                let mut all = match counter {
                    Counter::Count(counter) => vec![28, (*counter).into()],
                    Counter::Rounds { round, none } => vec![29, (*round).into(), (*none).into()],
                };
                all.push(self.of_rule(rule, renaming));
                all
            }
        };
        self.number(all)
    }

    fn rules(
        &mut self,
        kind: i64,
        rules: &[GroundRule],
        renaming: &Renaming,
        is_unordered: bool,
    ) -> Vec<i64> {
        let mut parts = Vec::new();
        for rule in rules {
            parts.push(self.of_rule(rule, renaming));
        }
        if is_unordered {
            parts.sort_unstable();
        }
        parts.insert(0, kind);
        parts
    }
}

fn renamed(indices: &[u32], index: u32) -> i64 {
    indices.get(index as usize).map_or(-1, |it| (*it).into())
}

fn index_numbers(index: &TableIndex) -> [i64; 3] {
    [index.low, index.count.into(), index.stride.into()]
}

/// Returns the operands of nested applications of `and` or `or` of which none can fail; otherwise the two operands.
fn operands(connective: Connective, term: &GroundTerm) -> Vec<&GroundTerm> {
    let is_associative = matches!(connective, Connective::And | Connective::Or);
    if !is_associative || !term.is_silent() {
        return term.parts();
    }
    let mut found = Vec::new();
    let mut waiting = vec![term];
    while let Some(term) = waiting.pop() {
        if let GroundTerm::Logic(inner, left, right) = term
            && *inner == connective
        {
            waiting.extend([&**right, &**left]);
        } else {
            found.push(term);
        }
    }
    found
}

/// Returns `true` if the order of the parts has no meaning: each is evaluated, or it does not matter whether it is.
fn is_unordered(term: &GroundTerm) -> bool {
    match term {
        GroundTerm::Equal(..) => true,
        GroundTerm::Logic(connective, ..) => match connective {
            Connective::And | Connective::Or | Connective::Xor | Connective::Iff => {
                term.is_silent()
            }
            Connective::Implies => false,
        },
        GroundTerm::Quantified(..) => term.is_silent(),
        GroundTerm::Constant(_)
        | GroundTerm::Variable(_)
        | GroundTerm::Input(_)
        | GroundTerm::Not(_)
        | GroundTerm::Compare(..)
        | GroundTerm::Arithmetic(..)
        | GroundTerm::If(..)
        | GroundTerm::Table { .. }
        | GroundTerm::After(..) => false,
    }
}
