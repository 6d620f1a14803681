//! Formulas: temporal operators over conditions, from the terms of a specification.

use asmotion_diagnostics::Span;
use asmotion_lang::hir::{
    AddedTerm, Binder, Body, Function, Model, Quantifier, Term, TermKind, Type, VarId, Variable,
};
use asmotion_lang::{Machine, Value};
use std::collections::BTreeMap;

/// An operator of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Operator {
    Not,
    And,
    Or,
    Implies,
    Iff,
    /// CTL: `E` and `A` quantify over paths.
    Ex,
    Ax,
    Ef,
    Af,
    Eg,
    Ag,
    Eu,
    Au,
    /// LTL, future.
    Next,
    Globally,
    Finally,
    Until,
    Release,
    /// LTL, past.
    Yesterday,
    WeakYesterday,
    Historically,
    Once,
    Since,
    Triggered,
}

/// The logic of an operator or formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Logic {
    Ctl,
    Ltl,
}

impl Operator {
    /// Returns the logic of a temporal operator; `None` for a Boolean one.
    pub fn logic(self) -> Option<Logic> {
        match self {
            Self::Not | Self::And | Self::Or | Self::Implies | Self::Iff => None,
            Self::Ex
            | Self::Ax
            | Self::Ef
            | Self::Af
            | Self::Eg
            | Self::Ag
            | Self::Eu
            | Self::Au => Some(Logic::Ctl),
            Self::Next
            | Self::Globally
            | Self::Finally
            | Self::Until
            | Self::Release
            | Self::Yesterday
            | Self::WeakYesterday
            | Self::Historically
            | Self::Once
            | Self::Since
            | Self::Triggered => Some(Logic::Ltl),
        }
    }
}

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
}

/// The translation of terms to formulas. The conditions are added to the model.
pub(crate) struct Formulas<'a> {
    pub model: &'a mut Model,
    /// A machine in the initial state, for the elements of domains.
    pub machine: &'a Machine,
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
        };
        translation.term(root, &Bound::default())
    }

    /// Returns the logic of the first temporal operator in a term; `None` without any.
    pub fn logic(&self, term: &Term) -> Option<Logic> {
        let mut found = None;
        asmotion_lang::ir::visit_terms(term, &mut |part| {
            let function = part.kind.function();
            let function = function.and_then(|it| self.model.functions.get(it.0 as usize));
            let logic = function.and_then(|function| match meaning(function)? {
                Meant::Operator(operator) => operator.logic(),
                Meant::Repeat(_) | Meant::Pattern(_) => Some(Logic::Ctl),
                Meant::Difference => None,
            });
            found = found.or(logic);
        });
        found
    }

    /// Adds the antecedents of the implications in a term as conditions, unless they have variables or temporal operators. Returns
    /// their indices.
    pub fn antecedents(&mut self, term: &Term) -> Vec<usize> {
        let mut found = Vec::new();
        asmotion_lang::ir::visit_terms(term, &mut |part| {
            if let TermKind::Apply(function, operands) = &*part.kind
                && let Some(function) = self.model.functions.get(function.0 as usize)
                && let Some(Meant::Operator(Operator::Implies)) = meaning(function)
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
}

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
            return self.applied(function.0, operands, term, bound);
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
        function: u32,
        operands: &[Term],
        term: &Term,
        bound: &Bound,
    ) -> Result<Formula, NoFormula> {
        let function = self.formulas.model.functions.get(function as usize);
        match function.and_then(meaning) {
            Some(Meant::Operator(operator)) => self.apply(operator, operands, term, bound),
            Some(Meant::Repeat(operator)) => self.repeat(operator, operands, bound),
            Some(Meant::Difference) => self.apply(Operator::Iff, operands, term, bound).map(not),
            Some(Meant::Pattern(name)) => {
                let operands = self.operands(operands, bound)?;
                pattern(name, operands).ok_or_else(|| nested(term))
            }
            None => Err(nested(term)),
        }
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
        bound: &Bound,
    ) -> Result<Formula, NoFormula> {
        let [operand, count] = operands else {
            return Ok(Formula::Constant(true));
        };
        self.check(operator, operand)?;
        let bound_value = |variable| {
            let mut values = bound.values.iter();
            values
                .find(|(known, _)| *known == variable)
                .map(|(_, value)| value)
        };
        let value = if let TermKind::Variable(variable) = &*count.kind {
            bound_value(*variable)
        } else if let TermKind::Value(value) = &*count.kind {
            Some(value)
        } else {
            None
        };
        let number = if let Some(Value::Int(number)) = value {
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
        let mut is_temporal = false;
        asmotion_lang::ir::visit_terms(term, &mut |part| {
            let function = part.kind.function();
            let function = function.and_then(|it| self.formulas.model.functions.get(it.0 as usize));
            is_temporal |= function.is_some_and(is_temporal_function);
            if let TermKind::Variable(variable) = &*part.kind {
                is_temporal |= bound.formulas.contains_key(variable);
            }
        });
        is_temporal
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

/// The meaning of a function in a formula.
enum Meant {
    Operator(Operator),
    /// `exN`, `axN`
    Repeat(Operator),
    /// `!=` or `xor`
    Difference,
    /// A function that is defined by other operators.
    Pattern(&'static str),
}

/// The functions of the libraries for temporal logic that are defined by others.
const PATTERNS: &[&str] = &[
    "ew",
    "aw",
    "absenceG",
    "absenceBefore",
    "absenceAfter",
    "absenceBetween",
    "absenceAfterUntil",
    "ap",
    "pb",
];

fn meaning(function: &Function) -> Option<Meant> {
    if !function.library {
        return None;
    }
    let operator = match &*function.name {
        "not" => Operator::Not,
        "and" => Operator::And,
        "or" => Operator::Or,
        "implies" => Operator::Implies,
        "iff" | "=" | "eq" => Operator::Iff,
        "xor" | "!=" | "neq" => return Some(Meant::Difference),
        "exN" => return Some(Meant::Repeat(Operator::Ex)),
        "axN" => return Some(Meant::Repeat(Operator::Ax)),
        name => match temporal(name) {
            Some(operator) => operator,
            None => {
                let known = PATTERNS.iter().find(|known| **known == name);
                return known.map(|name| Meant::Pattern(name));
            }
        },
    };
    Some(Meant::Operator(operator))
}

/// Returns the temporal operator of a name in the libraries.
fn temporal(name: &str) -> Option<Operator> {
    Some(match name {
        "ex" => Operator::Ex,
        "ax" => Operator::Ax,
        "ef" => Operator::Ef,
        "af" => Operator::Af,
        "eg" => Operator::Eg,
        "ag" => Operator::Ag,
        "eu" => Operator::Eu,
        "au" => Operator::Au,
        "x" => Operator::Next,
        "g" => Operator::Globally,
        "f" => Operator::Finally,
        "u" => Operator::Until,
        "v" => Operator::Release,
        "y" => Operator::Yesterday,
        "z" => Operator::WeakYesterday,
        "h" => Operator::Historically,
        "o" => Operator::Once,
        "s" => Operator::Since,
        "t" => Operator::Triggered,
        _ => return None,
    })
}

fn is_temporal_function(function: &Function) -> bool {
    match meaning(function) {
        Some(Meant::Operator(operator)) => operator.logic().is_some(),
        Some(Meant::Repeat(_) | Meant::Pattern(_)) => true,
        Some(Meant::Difference) | None => false,
    }
}

fn not(formula: Formula) -> Formula {
    Formula::Apply(Operator::Not, vec![formula])
}

fn and(left: Formula, right: Formula) -> Formula {
    Formula::Apply(Operator::And, vec![left, right])
}

fn or(left: Formula, right: Formula) -> Formula {
    Formula::Apply(Operator::Or, vec![left, right])
}

fn implies(left: Formula, right: Formula) -> Formula {
    Formula::Apply(Operator::Implies, vec![left, right])
}

fn ag(formula: Formula) -> Formula {
    Formula::Apply(Operator::Ag, vec![formula])
}

/// On every path, `p` until `q`, or `p` for ever.
fn aw(p: Formula, q: Formula) -> Formula {
    let neither = not(or(p, q.clone()));
    not(Formula::Apply(Operator::Eu, vec![not(q), neither]))
}

/// Returns a pattern of the library as a formula of the basic operators; the definitions are those of `CTLLibrary`, after
/// Dwyer, Avrunin and Corbett, "Patterns in property specifications for finite-state verification" (ICSE 1999).
fn pattern(name: &str, operands: Vec<Formula>) -> Option<Formula> {
    let mut operands = operands.into_iter();
    let p = operands.next()?;
    let rest: Vec<Formula> = operands.collect();
    Some(match (name, rest.as_slice()) {
        ("absenceG", []) => ag(not(p)),
        ("ew", [q]) => {
            let globally = Formula::Apply(Operator::Eg, vec![p.clone()]);
            or(Formula::Apply(Operator::Eu, vec![p, q.clone()]), globally)
        }
        ("aw", [q]) => aw(p, q.clone()),
        ("absenceBefore", [r]) => aw(or(not(p), ag(not(r.clone()))), r.clone()),
        ("absenceAfter", [q]) => ag(implies(q.clone(), ag(not(p)))),
        ("absenceBetween", [q, r]) => {
            let absent = aw(or(not(p), ag(not(r.clone()))), r.clone());
            ag(implies(and(q.clone(), not(r.clone())), absent))
        }
        ("absenceAfterUntil", [q, r]) => {
            let absent = aw(not(p), r.clone());
            ag(implies(and(q.clone(), not(r.clone())), absent))
        }
        ("ap", [s]) => aw(not(p), s.clone()),
        ("pb", [s, r]) => {
            let early = or(not(p), ag(not(r.clone())));
            aw(early, or(s.clone(), r.clone()))
        }
        _ => return None,
    })
}
