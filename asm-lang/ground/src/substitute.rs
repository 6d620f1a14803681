//! Replacement of a variable by a number, with everything decided that follows.

use crate::fold;
use crate::program::{FAULT, GroundCandidate, GroundRule, GroundTarget, GroundTerm, TableIndex};

impl GroundTerm {
    /// Returns the term where a state variable has this number.
    #[must_use]
    pub fn with_variable(&self, variable: u32, number: i64) -> Self {
        let of = |term: &Self| term.with_variable(variable, number);
        match self {
            Self::Variable(index) if *index == variable => Self::Constant(number),
            Self::Constant(_) | Self::Variable(_) | Self::Input(_) => self.clone(),
            Self::Not(operand) => fold::not(of(operand)),
            Self::Logic(connective, left, right) => fold::logic(*connective, of(left), of(right)),
            Self::Quantified(quantifier, instances) => {
                fold::quantified(*quantifier, instances.iter().map(of).collect())
            }
            Self::Equal(left, right) => fold::equal(of(left), of(right)),
            Self::Compare(comparison, left, right) => {
                fold::compare(*comparison, of(left), of(right))
            }
            Self::Arithmetic(operation, left, right) => {
                fold::arithmetic(*operation, of(left), of(right))
            }
            Self::If(guard, then, otherwise) => fold::branch(of(guard), of(then), of(otherwise)),
            Self::Table {
                indices,
                elements,
                undefined,
            } => {
                let indices: Vec<TableIndex> = indices
                    .iter()
                    .map(|it| index(it, variable, number))
                    .collect();
                if indices
                    .iter()
                    .any(|it| it.term == Self::Constant(crate::program::UNDEF))
                {
                    // another argument can still be a fault
                    return if indices.iter().all(|it| it.term.is_silent()) {
                        of(undefined)
                    } else {
                        Self::Constant(FAULT)
                    };
                }
                let elements = elements.iter().map(of).collect();
                fold::table(indices, elements, of(undefined))
            }
            Self::After(first, last) => fold::after(first.iter().map(of).collect(), of(last)),
        }
    }
}

fn index(index: &TableIndex, variable: u32, number: i64) -> TableIndex {
    TableIndex {
        term: index.term.with_variable(variable, number),
        ..index.clone()
    }
}

impl GroundRule {
    /// Returns the rule where a state variable has this number. Rules with intermediate states are left to a machine.
    #[must_use]
    pub fn with_variable(&self, variable: u32, number: i64) -> Self {
        let of = |rule: &Self| rule.with_variable(variable, number);
        let of_term = |term: &GroundTerm| term.with_variable(variable, number);
        match self {
            Self::Skip => Self::Skip,
            Self::Machine | Self::Seq(_) => Self::Machine,
            Self::Update(target, value, origin) => {
                let value = of_term(value);
                let target = match target {
                    GroundTarget::Variable(_) => target.clone(),
                    GroundTarget::Table(indices, variables) => {
                        let indices = indices.iter().map(|it| index(it, variable, number));
                        match fold::resolved(indices.collect(), variables.clone()) {
                            Some((indices, variables)) => match (indices.is_empty(), &*variables) {
                                (true, [only]) => GroundTarget::Variable(*only),
                                _ => GroundTarget::Table(indices, variables),
                            },
                            None => return Self::Machine,
                        }
                    }
                };
                if value == GroundTerm::Constant(FAULT) {
                    return Self::Machine;
                }
                Self::Update(target, value, *origin)
            }
            Self::Par(rules) => fold::par(rules.iter().map(of).collect()),
            Self::If(guard, then, otherwise) => {
                fold::rule_branch(of_term(guard), of(then), of(otherwise))
            }
            Self::Choose(candidates, otherwise, origin) => {
                let candidates = candidates.iter().map(|it| GroundCandidate {
                    chosen: it.chosen.clone(),
                    guard: of_term(&it.guard),
                    rule: of(&it.rule),
                });
                fold::choose(candidates.collect(), of(otherwise), *origin)
            }
            Self::After(terms, rule) => {
                fold::rule_after(terms.iter().map(of_term).collect(), of(rule))
            }
            Self::Counted(counter, rule) => Self::Counted(*counter, Box::new(of(rule))),
        }
    }
}
