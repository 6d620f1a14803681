//! Formulas: temporal operators over conditions, from the terms of a specification.

use crate::operator::{Logic, Meant, Operator, TemporalFunctions};
use asmotion_diagnostics::Span;
use asmotion_lang::hir::{
    AddedTerm, Binder, Body, FunctionId, Meaning, Model, Quantifier, Term, TermKind, Type, TypeId,
    VarId, Variable,
};
use asmotion_lang::{Machine, Value};
use std::collections::BTreeMap;

/// A formula over conditions, which are given by their index.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Formula {
    Constant(bool),
    Condition(usize),
    Apply(Operator, Vec<Formula>),
    /// `exN`, `axN`: after a number of steps.
    Repeat(Operator, u64, Box<Formula>),
}

impl Formula {
    /// Returns `true` if it has no temporal operator.
    pub fn is_condition(&self) -> bool {
        match self {
            Self::Constant(_) | Self::Condition(_) => true,
            Self::Apply(operator, operands) => {
                operator.logic().is_none() && operands.iter().all(Self::is_condition)
            }
            Self::Repeat(..) => false,
        }
    }

    /// Returns the conditions all of whose occurrences are among these, which are given once for each occurrence: the operand of a
    /// pattern occurs several times.
    pub fn with_all_occurrences(&self, given: &[usize]) -> Vec<usize> {
        let mut all = Vec::new();
        self.add_conditions(&mut all);
        let count = |of: &[usize], it: usize| of.iter().filter(|known| **known == it).count();
        let mut found = given.to_vec();
        found.sort_unstable();
        found.dedup();
        found.retain(|it| count(given, *it) >= count(&all, *it));
        found
    }

    fn add_conditions(&self, to: &mut Vec<usize>) {
        match self {
            Self::Constant(_) => {}
            Self::Condition(index) => to.push(*index),
            Self::Apply(_, operands) => operands.iter().for_each(|it| it.add_conditions(to)),
            Self::Repeat(_, _, operand) => operand.add_conditions(to),
        }
    }
}

/// The reason for which a term is no formula.
#[derive(Clone, Debug)]
pub(crate) struct NoFormula {
    pub at: Span,
    pub problem: FormulaProblem,
}

/// The problem of a term that is no formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FormulaProblem {
    /// A temporal operator inside a term that is neither a connective nor a quantifier.
    Nested,
    /// An operator of the other logic.
    Mixed { operator: String, expected: Logic },
    /// A quantifier over temporal formulas whose range is not known before the run.
    Range,
    /// The number of `exN` or `axN` is no literal.
    Count,
    /// A temporal operator in an invariant.
    Invariant(Logic),
    /// A temporal operator in an assumption, a fairness constraint, or another condition about single states.
    Condition,
}

impl FormulaProblem {
    /// Names a function whose definition has the problem in place of the operator in it.
    fn of_function(self, name: String) -> Self {
        match self {
            Self::Mixed { expected, .. } => Self::Mixed {
                operator: name,
                expected,
            },
            Self::Nested | Self::Range | Self::Count | Self::Invariant(_) | Self::Condition => self,
        }
    }
}

/// The translation of terms to formulas. The conditions are added to the model.
pub(crate) struct Formulas<'a> {
    pub model: &'a mut Model,
    /// A machine in the initial state, for the elements of domains.
    pub machine: &'a Machine,
    pub temporal: TemporalFunctions,
    /// Index of the first condition: the number of those of other machines.
    pub first_condition: usize,
    pub conditions: Vec<AddedTerm>,
    /// Places of the conditions.
    pub places: Vec<Span>,
}

/// The variables of a term that are bound outside: to a value, or, for a parameter, to a formula.
#[derive(Clone, Default)]
struct Bound {
    values: Vec<(VarId, Value)>,
    formulas: BTreeMap<VarId, Formula>,
}

impl Bound {
    /// Returns the value of a term that is a literal or a variable with a value.
    fn value<'a>(&'a self, term: &'a Term) -> Option<&'a Value> {
        if let TermKind::Value(value) = &*term.kind {
            return Some(value);
        }
        let TermKind::Variable(variable) = &*term.kind else {
            return None;
        };
        let mut values = self.values.iter();
        values
            .find(|(known, _)| known == variable)
            .map(|(_, value)| value)
    }
}

impl Formulas<'_> {
    /// Translates a term, which is the root of a body with these variables.
    pub fn formula(
        &mut self,
        root: &Term,
        variables: &[Variable],
        logic: Logic,
    ) -> Result<Formula, NoFormula> {
        let mut translation = Translation {
            formulas: self,
            variables: variables.to_vec(),
            logic,
            definitions: 0,
        };
        translation.term(root, &Bound::default())
    }

    /// Returns the logic of the first temporal operator in a term; `None` without any.
    pub fn logic(&self, term: &Term) -> Option<Logic> {
        self.temporal.logic(term)
    }

    /// Adds the antecedents of the implications in a term as conditions, unless they have variables or temporal operators. Returns
    /// their indices.
    pub fn antecedents(&mut self, term: &Term) -> Vec<usize> {
        let mut found = Vec::new();
        asmotion_lang::ir::visit_terms(term, &mut |part| {
            if let TermKind::Apply(function, operands) = &*part.kind
                && let Some(function) = self.model.functions.get(function.0 as usize)
                && let Some(Meant::Operator(Operator::Implies)) = Meant::of(function)
                && let [antecedent, _] = operands.as_slice()
                && self.logic(antecedent).is_none()
                && !has_variable(antecedent)
            {
                found.push(antecedent.clone());
            }
        });
        let found = found
            .into_iter()
            .map(|antecedent| self.condition(antecedent, Vec::new()));
        let indices = found.map(|formula| match formula {
            Formula::Condition(index) => Some(index),
            Formula::Constant(_) | Formula::Apply(..) | Formula::Repeat(..) => None,
        });
        indices
            .collect::<Vec<Option<usize>>>()
            .into_iter()
            .flatten()
            .collect()
    }

    /// Adds a condition without temporal operators.
    pub fn condition(&mut self, root: Term, variables: Vec<Variable>) -> Formula {
        if let TermKind::Value(Value::Bool(truth)) = *root.kind {
            return Formula::Constant(truth);
        }
        self.places.push(root.span);
        let term = self.model.add_resolved(Body {
            parameters: 0,
            variables,
            root,
        });
        self.conditions.push(term);
        Formula::Condition(self.first_condition + self.conditions.len() - 1)
    }
}

/// The translation of one body.
struct Translation<'f, 'a> {
    formulas: &'f mut Formulas<'a>,
    variables: Vec<Variable>,
    logic: Logic,
    /// Number of definitions around the current term.
    definitions: usize,
}

/// Greatest number of definitions within each other: one that applies itself has no formula.
const MAX_DEFINITIONS: usize = 64;

impl Translation<'_, '_> {
    fn term(&mut self, term: &Term, bound: &Bound) -> Result<Formula, NoFormula> {
        if let TermKind::Variable(variable) = &*term.kind
            && let Some(formula) = bound.formulas.get(variable)
        {
            return Ok(formula.clone());
        }
        if !self.is_temporal(term, bound) {
            return Ok(self.condition(term, bound));
        }
        if let TermKind::Apply(function, operands) = &*term.kind {
            return self.applied(*function, operands, term, bound);
        }
        if let TermKind::Spread(function, tuple) = &*term.kind
            && let TermKind::Tuple(operands) = &*tuple.kind
        {
            return self.applied(*function, operands, term, bound);
        }
        if let TermKind::Quantified(quantifier, binders, Some(condition)) = &*term.kind {
            return self.quantified(*quantifier, binders, condition, bound);
        }
        let TermKind::If(guard, then, Some(otherwise)) = &*term.kind else {
            return Err(nested(term));
        };
        let [guard, then, otherwise] = [
            self.term(guard, bound)?,
            self.term(then, bound)?,
            self.term(otherwise, bound)?,
        ];
        let otherwise = implies(not(guard.clone()), otherwise);
        Ok(and(implies(guard, then), otherwise))
    }

    /// Translates the application of a function to terms of which some are temporal.
    fn applied(
        &mut self,
        function: FunctionId,
        operands: &[Term],
        term: &Term,
        bound: &Bound,
    ) -> Result<Formula, NoFormula> {
        let declared = self.formulas.model.functions.get(function.0 as usize);
        match declared.and_then(Meant::of) {
            Some(Meant::Operator(Operator::Iff) | Meant::Difference)
                if !operands.iter().all(|operand| self.is_boolean(operand.ty)) =>
            {
                Err(nested(term))
            }
            Some(Meant::Operator(operator)) => self.apply(operator, operands, term, bound),
            Some(Meant::Repeat(operator)) => self.repeat(operator, operands, term, bound),
            Some(Meant::Difference) => self.apply(Operator::Iff, operands, term, bound).map(not),
            None => self.defined(function, operands, term, bound),
        }
    }

    fn is_boolean(&self, ty: TypeId) -> bool {
        matches!(self.formulas.model.types.get(ty), Type::Boolean)
    }

    /// Translates the application of a function that is defined by a term with temporal operators: its definition, with the operands in
    /// place of the parameters. Problems in it are reported where it is applied.
    fn defined(
        &mut self,
        function: FunctionId,
        operands: &[Term],
        term: &Term,
        bound: &Bound,
    ) -> Result<Formula, NoFormula> {
        let declared = self.formulas.model.functions.get(function.0 as usize);
        let Some((name, Meaning::Defined(body))) = declared.map(|it| (&it.name, &it.meaning))
        else {
            return Err(nested(term));
        };
        if self.definitions == MAX_DEFINITIONS || body.parameters != operands.len() {
            return Err(nested(term));
        }
        let (name, root) = (name.to_string(), body.root.clone());
        let variables = body.variables.clone();
        let mut inside = Bound::default();
        for (parameter, operand) in (0..).map(VarId).zip(operands) {
            if self.is_boolean(operand.ty) {
                let formula = self.term(operand, bound)?;
                inside.formulas.insert(parameter, formula);
            } else {
                let value = bound.value(operand).ok_or_else(|| nested(operand))?;
                inside.values.push((parameter, value.clone()));
            }
        }
        let outside = std::mem::replace(&mut self.variables, variables);
        self.definitions += 1;
        let formula = self.term(&root, &inside);
        self.definitions -= 1;
        self.variables = outside;
        formula.map_err(|found| NoFormula {
            at: term.span,
            problem: found.problem.of_function(name),
        })
    }

    fn operands(&mut self, operands: &[Term], bound: &Bound) -> Result<Vec<Formula>, NoFormula> {
        operands.iter().map(|term| self.term(term, bound)).collect()
    }

    fn apply(
        &mut self,
        operator: Operator,
        operands: &[Term],
        term: &Term,
        bound: &Bound,
    ) -> Result<Formula, NoFormula> {
        self.check(operator, term)?;
        Ok(Formula::Apply(operator, self.operands(operands, bound)?))
    }

    /// Checks that an operator belongs to the logic.
    fn check(&self, operator: Operator, term: &Term) -> Result<(), NoFormula> {
        if operator.logic().is_none_or(|logic| logic == self.logic) {
            return Ok(());
        }
        let function = term.kind.function();
        let function = function.and_then(|it| self.formulas.model.functions.get(it.0 as usize));
        let operator = function.map(|function| function.name.to_string());
        Err(NoFormula {
            at: term.span,
            problem: FormulaProblem::Mixed {
                operator: operator.unwrap_or_default(),
                expected: self.logic,
            },
        })
    }

    fn repeat(
        &mut self,
        operator: Operator,
        operands: &[Term],
        term: &Term,
        bound: &Bound,
    ) -> Result<Formula, NoFormula> {
        let [operand, count] = operands else {
            return Ok(Formula::Constant(true));
        };
        self.check(operator, term)?;
        let number = if let Some(Value::Int(number)) = bound.value(count) {
            u64::try_from(*number).ok()
        } else {
            None
        };
        let number = number.ok_or(NoFormula {
            at: count.span,
            problem: FormulaProblem::Count,
        })?;
        let operand = self.term(operand, bound)?;
        Ok(Formula::Repeat(operator, number, Box::new(operand)))
    }

    /// Expands a quantifier over temporal formulas: one formula for each value of the variables.
    fn quantified(
        &mut self,
        quantifier: Quantifier,
        binders: &[Binder],
        condition: &Term,
        bound: &Bound,
    ) -> Result<Formula, NoFormula> {
        let (operator, unit) = match quantifier {
            Quantifier::Forall => (Operator::And, true),
            Quantifier::Exists => (Operator::Or, false),
            Quantifier::ExistsUnique => return Err(nested(condition)),
        };
        let Some((binder, rest)) = binders.split_first() else {
            return self.term(condition, bound);
        };
        let elements = self.elements(&binder.range).ok_or(NoFormula {
            at: binder.range.span,
            problem: FormulaProblem::Range,
        })?;
        let mut all = Vec::new();
        for element in elements {
            let mut bound = bound.clone();
            bound.values.push((binder.variable, element));
            all.push(self.quantified(quantifier, rest, condition, &bound)?);
        }
        Ok(match all.len() {
            0 => Formula::Constant(unit),
            _ => Formula::Apply(operator, all),
        })
    }

    /// Returns the elements of a range that is a domain.
    fn elements(&self, range: &Term) -> Option<Vec<Value>> {
        let TermKind::Extent(ty) = &*range.kind else {
            return None;
        };
        let ty = self.formulas.model.types.get(*ty);
        if matches!(ty, Type::Boolean) {
            return Some(vec![Value::Bool(false), Value::Bool(true)]);
        }
        let domain = asmotion_lang::ir::DomainId(ty.as_domain()?.0);
        let program = self.formulas.machine.program();
        let shape = asmotion_lang::ir::ValueShape::Domain(domain);
        match program.named_elements(&shape) {
            Some(named) => Some(named.into_iter().map(|(_, value)| value).collect()),
            None => {
                let extent = self.formulas.machine.state().extent(domain);
                (!extent.is_empty()).then(|| extent.to_vec())
            }
        }
    }

    /// Adds a condition, in which the bound variables have their values.
    fn condition(&mut self, term: &Term, bound: &Bound) -> Formula {
        let mut root = term.clone();
        if !bound.values.is_empty() {
            let values = bound.values.iter().map(|(variable, value)| {
                let ty = self.variables.get(variable.0 as usize).map(|it| it.ty);
                let value = Term {
                    kind: Box::new(TermKind::Value(value.clone())),
                    ty: ty.unwrap_or(term.ty),
                    span: term.span,
                };
                (*variable, value)
            });
            root = Term {
                kind: Box::new(TermKind::Let(values.collect(), root)),
                ty: term.ty,
                span: term.span,
            };
        }
        self.formulas.condition(root, self.variables.clone())
    }

    /// Returns `true` if a term contains a temporal operator.
    fn is_temporal(&self, term: &Term, bound: &Bound) -> bool {
        let mut has_formula = false;
        asmotion_lang::ir::visit_terms(term, &mut |part| {
            if let TermKind::Variable(variable) = &*part.kind {
                has_formula |= bound.formulas.contains_key(variable);
            }
        });
        has_formula || self.formulas.temporal.logic(term).is_some()
    }
}

fn has_variable(term: &Term) -> bool {
    let mut has_variable = false;
    asmotion_lang::ir::visit_terms(term, &mut |part| {
        has_variable |= matches!(&*part.kind, TermKind::Variable(_));
    });
    has_variable
}

fn nested(term: &Term) -> NoFormula {
    NoFormula {
        at: term.span,
        problem: FormulaProblem::Nested,
    }
}

fn not(formula: Formula) -> Formula {
    Formula::Apply(Operator::Not, vec![formula])
}

fn and(left: Formula, right: Formula) -> Formula {
    Formula::Apply(Operator::And, vec![left, right])
}

fn implies(left: Formula, right: Formula) -> Formula {
    Formula::Apply(Operator::Implies, vec![left, right])
}
