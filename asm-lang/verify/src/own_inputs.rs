//! Properties whose verdicts depend on the inputs that a state is considered with.
//!
//! A node is a state with the inputs that the properties mention. If it has more inputs than one property mentions, some formulas have
//! another value there than in the state alone: `ex(p)` asks for a choice that leads to `p` in the state, and for one with each value of
//! the input at the nodes; `ax(p) or ax(q)` asks the opposite. A verdict must not depend on what *other* properties mention. Such
//! properties are therefore verified once more, without the others.

use crate::formula::Formula;
use crate::logic::{FairnessFormula, visit_conditions};
use crate::operator::Operator;
use crate::preparation::{Prepared, Property};
use crate::property::PropertyKind;
use crate::reads::InputFunctions;
use asmotion_lang::Machine;
use asmotion_lang::hir::FunctionId;
use std::collections::BTreeSet;

impl Prepared {
    /// Returns the inputs that any property mentions.
    #[cfg(feature = "symbolic")]
    pub fn all_inputs(&self) -> InputFunctions {
        let of_properties = self.properties.iter().flat_map(|it| &it.inputs);
        let others = self.common_inputs.iter().chain(&self.end_inputs);
        of_properties.chain(others).copied().collect()
    }

    /// Returns the indices of the properties that have to be verified alone, if these inputs distinguish nodes. `has_ends` is
    /// `true` if runs end for some inputs.
    pub fn verified_alone(
        &self,
        told_apart: &InputFunctions,
        machines: &[Machine],
        has_ends: bool,
        has_due_fairness: bool,
    ) -> Vec<usize> {
        let indices = 0..self.properties.len();
        let is_alone = |index: &usize| {
            self.properties.get(*index).is_some_and(|property| {
                self.of_nodes(property).is_none()
                    && (has_ends || has_due_fairness || self.depends_on_inputs(property))
                    && self.has_other_inputs(*index, property, told_apart, machines)
            })
        };
        indices.filter(is_alone).collect()
    }

    /// Returns `true` if inputs that a property does not mention distinguish nodes. Of a function with arguments, it may mention
    /// other locations than the rest.
    fn has_other_inputs(
        &self,
        index: usize,
        property: &Property,
        told_apart: &InputFunctions,
        machines: &[Machine],
    ) -> bool {
        let is_own = |it: &(usize, FunctionId)| {
            property.inputs.contains(it) || self.common_inputs.contains(it)
        };
        let has_parameters = |(machine, function): &(usize, FunctionId)| {
            let program = machines.get(*machine).map(Machine::program);
            let function = program.and_then(|it| it.functions.get(function.0 as usize));
            function.is_some_and(|it| !it.parameters.is_empty())
        };
        let is_of_another = |it: &(usize, FunctionId)| {
            let mut others = self.properties.iter().enumerate();
            others.any(|(other, property)| other != index && property.inputs.contains(it))
        };
        let mut inputs = told_apart.iter();
        inputs.any(|it| !is_own(it) || has_parameters(it) && is_of_another(it))
    }

    /// Returns `true` if the value of a formula in a state can differ from that at the nodes of the state.
    fn depends_on_inputs(&self, property: &Property) -> bool {
        if !property.may_see_inputs() {
            return false;
        }
        // from every state that can be reached, the same states can be reached again after the next step
        let is_recurrence = match &property.formula {
            Formula::Apply(Operator::Ag, operands) => match operands.as_slice() {
                [Formula::Apply(Operator::Ef, reached)] => {
                    reached.iter().all(Formula::is_condition)
                }
                _ => false,
            },
            Formula::Constant(_)
            | Formula::Condition(_)
            | Formula::Apply(..)
            | Formula::Repeat(..) => false,
        };
        !is_recurrence || self.has_fairness
    }

    /// Returns `true` if no property mentions an input itself.
    pub fn mentions_no_inputs(&self) -> bool {
        self.properties.iter().all(|it| it.inputs.is_empty())
    }

    /// Groups properties that are verified alone: those that mention no inputs themselves have the same nodes.
    pub fn groups(&self, alone: &[usize]) -> Vec<Vec<usize>> {
        let has_inputs = |index: &usize| {
            let property = self.properties.get(*index);
            property.is_some_and(|it| !it.inputs.is_empty())
        };
        let (single, together): (Vec<usize>, Vec<usize>) =
            alone.iter().copied().partition(has_inputs);
        let groups = std::iter::once(together).filter(|it| !it.is_empty());
        groups
            .chain(single.into_iter().map(|index| vec![index]))
            .collect()
    }

    /// Returns some properties with what their verdicts depend on.
    pub fn alone(&self, indices: &[usize]) -> Option<Self> {
        let properties = indices.iter().map(|index| self.properties.get(*index));
        let properties = properties.collect::<Option<Vec<&Property>>>()?;
        let mut used: BTreeSet<usize> = self.conditions.assumed.iter().copied().collect();
        for property in &properties {
            used.extend(&property.antecedents);
            used.extend(&property.mentions);
            visit_conditions(&property.formula, &mut |index| {
                used.insert(index);
            });
        }
        for constraint in &self.fairness {
            for formula in constraint.formulas() {
                visit_conditions(formula, &mut |index| {
                    used.insert(index);
                });
            }
        }
        let numbers = Renumbered(used.into_iter().collect());
        let fairness = self.fairness.iter().map(|constraint| match constraint {
            FairnessFormula::Justice(often) => FairnessFormula::Justice(numbers.formula(often)),
            FairnessFormula::Compassion(cause, effect) => {
                FairnessFormula::Compassion(numbers.formula(cause), numbers.formula(effect))
            }
        });
        let assumed = self.conditions.assumed.iter();
        let mut alone = Self {
            properties: properties.iter().map(|it| numbers.property(it)).collect(),
            fairness: fairness.collect(),
            has_fairness: self.has_fairness,
            has_several_starts: self.has_several_starts,
            assumptions: self.assumptions.clone(),
            common_inputs: self.common_inputs.clone(),
            ..Self::default()
        };
        alone.conditions.assumed = assumed.map(|it| numbers.condition(*it)).collect();
        for known in &numbers.0 {
            let term = self.conditions.terms.get(*known)?;
            alone.conditions.terms.push(*term);
            alone.texts.push(self.texts.get(*known)?.clone());
        }
        Some(alone)
    }
}

impl Property {
    /// Returns `true` if the value of the formula in a state may differ from that at the nodes of the state.
    pub fn may_see_inputs(&self) -> bool {
        self.kind == PropertyKind::Ctl && !is_about_runs(&self.formula, true)
    }
}

/// Returns `true` if a formula says something about each run on its own, in the way that `ag(p implies ax(q))` does: it is then true in
/// a state if it is true at all nodes of the state. `is_positive` is `false` below an odd number of negations.
fn is_about_runs(formula: &Formula, is_positive: bool) -> bool {
    let Formula::Apply(operator, operands) = formula else {
        return match formula {
            Formula::Repeat(operator, _, operand) => {
                (*operator == Operator::Ax) == is_positive && is_about_runs(operand, is_positive)
            }
            Formula::Constant(_) | Formula::Condition(_) | Formula::Apply(..) => true,
        };
    };
    let are_conditions = || operands.iter().all(Formula::is_condition);
    let are = |is_positive: bool| operands.iter().all(|it| is_about_runs(it, is_positive));
    let one_is_temporal = || operands.iter().filter(|it| !it.is_condition()).count() <= 1;
    match operator {
        Operator::Not => are(!is_positive),
        Operator::And => are(is_positive) && (is_positive || one_is_temporal()),
        Operator::Or => are(is_positive) && (!is_positive || one_is_temporal()),
        Operator::Implies => match operands.as_slice() {
            [cause, effect] => {
                is_about_runs(cause, !is_positive)
                    && is_about_runs(effect, is_positive)
                    && (!is_positive || one_is_temporal())
            }
            _ => false,
        },
        Operator::Iff => are_conditions(),
        Operator::Ax | Operator::Ag => is_positive && are(true),
        Operator::Ex | Operator::Ef => !is_positive && are(false),
        Operator::Af | Operator::Au => is_positive && are_conditions(),
        Operator::Eg | Operator::Eu => !is_positive && are_conditions(),
        Operator::Next
        | Operator::Globally
        | Operator::Finally
        | Operator::Until
        | Operator::Release
        | Operator::Yesterday
        | Operator::WeakYesterday
        | Operator::Historically
        | Operator::Once
        | Operator::Since
        | Operator::Triggered => false,
    }
}

/// New indices of conditions: the conditions that remain, in ascending order.
struct Renumbered(Vec<usize>);

impl Renumbered {
    fn condition(&self, index: usize) -> usize {
        self.0.partition_point(|known| *known < index)
    }

    fn property(&self, property: &Property) -> Property {
        let conditions = |of: &[usize]| of.iter().map(|it| self.condition(*it)).collect();
        Property {
            name: property.name.clone(),
            text: property.text.clone(),
            inputs: property.inputs.clone(),
            formula: self.formula(&property.formula),
            antecedents: conditions(&property.antecedents),
            mentions: conditions(&property.mentions),
            ..*property
        }
    }

    fn formula(&self, formula: &Formula) -> Formula {
        match formula {
            Formula::Constant(truth) => Formula::Constant(*truth),
            Formula::Condition(index) => Formula::Condition(self.condition(*index)),
            Formula::Apply(operator, operands) => {
                let operands = operands.iter().map(|it| self.formula(it));
                Formula::Apply(*operator, operands.collect())
            }
            Formula::Repeat(operator, count, operand) => {
                Formula::Repeat(*operator, *count, Box::new(self.formula(operand)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(operator: Operator, operands: &[Formula]) -> Formula {
        Formula::Apply(operator, operands.to_vec())
    }

    #[test]
    fn formulas_about_each_run_are_told_from_those_about_choices() {
        let (p, q) = (Formula::Condition(0), Formula::Condition(1));
        let next = |it: &Formula| apply(Operator::Ax, std::slice::from_ref(it));
        let some = |it: &Formula| apply(Operator::Ex, std::slice::from_ref(it));
        let not = |it: &Formula| apply(Operator::Not, std::slice::from_ref(it));
        let always = |it: &Formula| apply(Operator::Ag, std::slice::from_ref(it));
        let answered = always(&apply(Operator::Implies, &[p.clone(), next(&q)]));
        assert!(is_about_runs(&answered, true));
        assert!(is_about_runs(&not(&some(&p)), true));
        assert!(!is_about_runs(&some(&p), true));
        assert!(!is_about_runs(&not(&next(&p)), true));
        let either = apply(Operator::Or, &[next(&p), next(&q)]);
        assert!(!is_about_runs(&always(&either), true));
        let until = apply(Operator::Eu, &[p.clone(), q.clone()]);
        assert!(is_about_runs(&not(&until), true));
        let persistent = apply(Operator::Af, &[always(&p)]);
        assert!(!is_about_runs(&persistent, true));
        assert!(!is_about_runs(&apply(Operator::Iff, &[p, next(&q)]), true));
    }
}
