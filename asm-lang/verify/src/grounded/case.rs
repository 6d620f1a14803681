//! Division of a rule into cases: conjunctions of conditions, each with the updates that it leads to.

use super::layout::WordLayout;
use asmotion_ground::{FAULT, GroundRule, GroundTarget, GroundTerm, UNDEF, Valuation, evaluate};
use asmotion_lang::ir::{Connective, Counter, Quantifier};
use std::collections::BTreeMap;

/// Number of bits of the variables of a term up to which its values are tabulated.
const SMALL: u32 = 11;

/// Limit for the cases of a rule.
const MAX_CASES: usize = 512;

/// The values of a term that a condition requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Requirement {
    /// It is true.
    True,
    /// It is false.
    False,
    /// It is neither, as a guard: undef or a fault.
    NoTruth,
}

impl Requirement {
    /// Returns `true` if a term's number meets the requirement.
    pub fn is_met(self, number: i64) -> bool {
        match self {
            Self::True => number == 1,
            Self::False => number == 0,
            Self::NoTruth => number == UNDEF || number == FAULT,
        }
    }
}

/// A requirement of a term with so few variables that its values can be listed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Literal {
    /// The variables, in ascending order.
    pub variables: Vec<u32>,
    pub term: GroundTerm,
    pub requirement: Requirement,
}

/// A conjunction of conditions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Conjunction {
    /// For each variable with a condition of its own, `true` for each code that is possible.
    pub codes: BTreeMap<u32, Vec<bool>>,
    /// Conditions on several variables.
    pub literals: Vec<Literal>,
}

/// The effect of a rule in states in which a conjunction holds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Case {
    pub when: Conjunction,
    /// The updates: variable and value. The values of one variable may be different, which is a clash.
    pub updates: Vec<(u32, GroundTerm)>,
    /// Executed coverage counters.
    pub counters: Vec<u32>,
    /// `true` if a machine executes the case.
    pub needs_machine: bool,
}

/// The rule cannot be divided into few cases.
#[derive(Debug)]
pub(crate) struct NoCases;

/// No inputs, and no choices.
pub(crate) struct Closed;

impl Valuation for Closed {
    fn input(&mut self, _: u32) -> i64 {
        FAULT
    }

    fn choose(&mut self, _: usize) -> usize {
        0
    }
}

/// Divides rules into cases.
pub(crate) struct Division<'a> {
    pub layout: &'a WordLayout,
}

impl Division<'_> {
    /// Returns the cases of a rule without choices that arise where guards are true, of which each is evaluated only if those
    /// before it are true. The cases exclude each other.
    pub fn cases(&self, guards: &[GroundTerm], rule: &GroundRule) -> Result<Vec<Case>, NoCases> {
        match guards.split_first() {
            None => self.rule(rule),
            Some((guard, rest)) => {
                if let Some(variable) = self.splitting(guard) {
                    return self.split(variable, |number| {
                        let fixed = |term: &GroundTerm| term.with_variable(variable, number);
                        let guards: Vec<GroundTerm> = guards.iter().map(fixed).collect();
                        self.cases(&guards, &rule.with_variable(variable, number))
                    });
                }
                let mut all = join(&self.conditions(guard, true)?, &self.cases(rest, rule)?)?;
                all.extend(self.faults(guard)?);
                Ok(all)
            }
        }
    }

    /// Returns the conjunctions in which a term is true, which exclude each other.
    pub fn truths(&self, term: &GroundTerm, wanted: bool) -> Result<Vec<Conjunction>, NoCases> {
        let conditions = self.conditions(term, wanted)?;
        Ok(conditions.into_iter().map(|case| case.when).collect())
    }

    fn rule(&self, rule: &GroundRule) -> Result<Vec<Case>, NoCases> {
        match rule {
            GroundRule::Skip => Ok(vec![Case::default()]),
            GroundRule::Machine => Ok(vec![Case {
                needs_machine: true,
                ..Case::default()
            }]),
            GroundRule::Update(target, value, _) => {
                let of_target = match target {
                    GroundTarget::Variable(_) => None,
                    GroundTarget::Table(indices, _) => {
                        let mut reads = indices.iter().flat_map(|index| self.reads(&index.term));
                        Some(reads.next().ok_or(NoCases)?)
                    }
                };
                if let Some(variable) = of_target.or_else(|| self.splitting(value)) {
                    return self.split(variable, |number| {
                        self.rule(&rule.with_variable(variable, number))
                    });
                }
                let GroundTarget::Variable(variable) = target else {
                    return Err(NoCases);
                };
                Ok(vec![Case {
                    updates: vec![(*variable, value.clone())],
                    ..Case::default()
                }])
            }
            GroundRule::Par(rules) => {
                let mut all = vec![Case::default()];
                for rule in rules {
                    all = join(&all, &self.rule(rule)?)?;
                }
                Ok(all)
            }
            GroundRule::If(guard, then, otherwise) => {
                if let Some(variable) = self.splitting(guard) {
                    return self.split(variable, |number| {
                        self.rule(&rule.with_variable(variable, number))
                    });
                }
                let mut all = join(&self.conditions(guard, true)?, &self.rule(then)?)?;
                let otherwise = join(&self.conditions(guard, false)?, &self.rule(otherwise)?)?;
                all.extend(otherwise);
                all.extend(self.faults(guard)?);
                Ok(all)
            }
            GroundRule::Counted(Counter::Count(counter), inner) => {
                let mut all = self.rule(inner)?;
                all.iter_mut().for_each(|case| case.counters.push(*counter));
                Ok(all)
            }
            GroundRule::Counted(Counter::Rounds { round, none }, inner) => {
                let mut all = self.rule(inner)?;
                for case in &mut all {
                    let rounds = case.counters.iter().filter(|it| *it == round).count();
                    case.counters.push(none + rounds.min(2) as u32);
                }
                Ok(all)
            }
            GroundRule::After(..) | GroundRule::Seq(_) | GroundRule::Choose(..) => Err(NoCases),
        }
    }

    /// Joins the cases of a rule for each number of a variable.
    fn split(
        &self,
        variable: u32,
        mut of_number: impl FnMut(i64) -> Result<Vec<Case>, NoCases>,
    ) -> Result<Vec<Case>, NoCases> {
        let field = self.layout.field(variable).ok_or(NoCases)?;
        if field.codes() > 64 {
            return Err(NoCases);
        }
        let mut all = Vec::new();
        for code in 0..field.codes() {
            let mut codes = vec![false; field.codes() as usize];
            if let Some(possible) = codes.get_mut(code as usize) {
                *possible = true;
            }
            let condition = Case {
                when: Conjunction {
                    codes: BTreeMap::from([(variable, codes)]),
                    literals: Vec::new(),
                },
                ..Case::default()
            };
            all.extend(join(&[condition], &of_number(field.number(code))?)?);
            if all.len() > MAX_CASES {
                return Err(NoCases);
            }
        }
        Ok(all)
    }

    /// Returns the conditions under which a term is true, or false, as cases without updates.
    fn conditions(&self, term: &GroundTerm, wanted: bool) -> Result<Vec<Case>, NoCases> {
        let both = |parts: &[(&GroundTerm, bool)]| {
            let mut all = vec![Case::default()];
            for (part, wanted) in parts {
                all = join(&all, &self.conditions(part, *wanted)?)?;
            }
            Ok(all)
        };
        match (term, wanted) {
            (GroundTerm::Constant(number), _) => {
                if *number == i64::from(wanted) {
                    Ok(vec![Case::default()])
                } else {
                    Ok(Vec::new())
                }
            }
            (GroundTerm::Not(operand), _) => self.conditions(operand, !wanted),
            (GroundTerm::Logic(Connective::And, left, right), true) => {
                both(&[(left, true), (right, true)])
            }
            (GroundTerm::Logic(Connective::Or, left, right), false) => {
                both(&[(left, false), (right, false)])
            }
            (GroundTerm::Logic(Connective::Implies, left, right), false) => {
                both(&[(left, true), (right, false)])
            }
            (GroundTerm::Quantified(Quantifier::Forall, instances), true) => {
                let parts: Vec<(&GroundTerm, bool)> =
                    instances.iter().map(|it| (it, true)).collect();
                both(&parts)
            }
            (GroundTerm::Quantified(Quantifier::Exists, instances), false) => {
                let parts: Vec<(&GroundTerm, bool)> =
                    instances.iter().map(|it| (it, false)).collect();
                both(&parts)
            }
            _ if self.is_small(term) => Ok(self.literal(
                term,
                if wanted {
                    Requirement::True
                } else {
                    Requirement::False
                },
            )),
            _ if self.splitting(term).is_some() => {
                let variable = self.splitting(term).ok_or(NoCases)?;
                self.split(variable, |number| {
                    self.conditions(&term.with_variable(variable, number), wanted)
                })
            }
            (GroundTerm::Logic(Connective::And, left, right), false) => {
                self.one_of(&[(left, false), (right, false)])
            }
            (GroundTerm::Logic(Connective::Or, left, right), true) => {
                self.one_of(&[(left, true), (right, true)])
            }
            (GroundTerm::Logic(Connective::Implies, left, right), true) => {
                self.one_of(&[(left, false), (right, true)])
            }
            (GroundTerm::Quantified(Quantifier::Forall, instances), false) => {
                let parts: Vec<(&GroundTerm, bool)> =
                    instances.iter().map(|it| (it, false)).collect();
                self.one_of(&parts)
            }
            (GroundTerm::Quantified(Quantifier::Exists, instances), true) => {
                let parts: Vec<(&GroundTerm, bool)> =
                    instances.iter().map(|it| (it, true)).collect();
                self.one_of(&parts)
            }
            _ => Err(NoCases),
        }
    }

    /// The first part that has its truth value decides; those before it have the other one.
    fn one_of(&self, parts: &[(&GroundTerm, bool)]) -> Result<Vec<Case>, NoCases> {
        let mut all = Vec::new();
        let mut before = vec![Case::default()];
        for (part, wanted) in parts {
            // with an undef part, another could still decide
            if !self.is_total(part) {
                return Err(NoCases);
            }
            all.extend(join(&before, &self.conditions(part, *wanted)?)?);
            before = join(&before, &self.conditions(part, !*wanted)?)?;
        }
        Ok(all)
    }

    /// Returns the cases in which the evaluation of a term fails, or its value is no truth value.
    fn faults(&self, term: &GroundTerm) -> Result<Vec<Case>, NoCases> {
        if self.is_total(term) {
            return Ok(Vec::new());
        }
        if !self.is_small(term) {
            return Err(NoCases);
        }
        let mut all = self.literal(term, Requirement::NoTruth);
        all.iter_mut().for_each(|case| case.needs_machine = true);
        Ok(all)
    }

    /// Returns the case in which a small term meets a requirement; none if it never does.
    fn literal(&self, term: &GroundTerm, requirement: Requirement) -> Vec<Case> {
        let variables = self.reads(term);
        let mut when = Conjunction::default();
        match *variables {
            [] => {
                let number = evaluate(term, &[], &mut Closed);
                return if requirement.is_met(number) {
                    vec![Case::default()]
                } else {
                    Vec::new()
                };
            }
            [variable] => {
                let codes = self.values(term, &variables);
                let codes: Vec<bool> = codes.iter().map(|it| requirement.is_met(*it)).collect();
                if !codes.contains(&true) {
                    return Vec::new();
                }
                if codes.contains(&false) {
                    when.codes.insert(variable, codes);
                }
            }
            _ => {
                let values = self.values(term, &variables);
                if !values.iter().any(|it| requirement.is_met(*it)) {
                    return Vec::new();
                }
                if !values.iter().all(|it| requirement.is_met(*it)) {
                    when.literals.push(Literal {
                        variables,
                        term: term.clone(),
                        requirement,
                    });
                }
            }
        }
        vec![Case {
            when,
            ..Case::default()
        }]
    }

    /// Returns the values of a small term, for all combinations of the codes of its variables; the last variable's code changes
    /// first.
    pub fn values(&self, term: &GroundTerm, variables: &[u32]) -> Vec<i64> {
        let mut numbers = vec![UNDEF; self.layout.fields.len()];
        let mut values = Vec::new();
        self.enumerate(variables, &mut numbers, &mut |numbers| {
            values.push(evaluate(term, numbers, &mut Closed));
        });
        values
    }

    fn enumerate(&self, variables: &[u32], numbers: &mut Vec<i64>, visit: &mut dyn FnMut(&[i64])) {
        let Some((variable, rest)) = variables.split_first() else {
            return visit(numbers);
        };
        let Some(field) = self.layout.field(*variable) else {
            return;
        };
        for code in 0..field.codes() {
            if let Some(number) = numbers.get_mut(*variable as usize) {
                *number = field.number(code);
            }
            self.enumerate(rest, numbers, visit);
        }
    }

    /// Returns `true` if the evaluation of a term always gives a truth value.
    pub fn is_total(&self, term: &GroundTerm) -> bool {
        if self.is_small(term) {
            let values = self.values(term, &self.reads(term));
            return values.iter().all(|value| matches!(value, 0 | 1));
        }
        let is_defined = |term: &GroundTerm| {
            term.is_silent() && {
                let mut reads = self.reads(term).into_iter();
                reads.all(|it| self.layout.field(it).is_some_and(|it| !it.may_be_undef))
            }
        };
        match term {
            GroundTerm::Not(_) | GroundTerm::Logic(..) | GroundTerm::Quantified(..) => {
                term.parts().into_iter().all(|part| self.is_total(part))
            }
            GroundTerm::Equal(left, right) => left.is_silent() && right.is_silent(),
            GroundTerm::Compare(_, left, right) => is_defined(left) && is_defined(right),
            GroundTerm::Variable(_)
            | GroundTerm::Constant(_)
            | GroundTerm::Input(_)
            | GroundTerm::Arithmetic(..)
            | GroundTerm::If(..)
            | GroundTerm::Table { .. }
            | GroundTerm::After(..) => false,
        }
    }

    /// Returns `true` if the values of a term can be listed.
    pub fn is_small(&self, term: &GroundTerm) -> bool {
        let reads = self.reads(term);
        let bits = reads
            .iter()
            .map(|it| self.layout.field(*it).map_or(64, |it| it.bits()));
        let accesses = asmotion_ground::accesses_of_term(term);
        bits.sum::<u32>() <= SMALL && accesses.inputs.is_empty()
    }

    pub fn reads(&self, term: &GroundTerm) -> Vec<u32> {
        asmotion_ground::accesses_of_term(term)
            .reads
            .into_iter()
            .collect()
    }

    /// Returns a variable whose number makes a term simpler that is not small: one that selects from a table.
    fn splitting(&self, term: &GroundTerm) -> Option<u32> {
        if self.is_small(term) {
            return None;
        }
        if let GroundTerm::Table { indices, .. } = term {
            let mut reads = indices.iter().flat_map(|index| self.reads(&index.term));
            if let Some(first) = reads.next() {
                return Some(first);
            }
        }
        term.parts()
            .into_iter()
            .find_map(|part| self.selector(part))
    }

    /// Returns a variable that selects from a table in a term.
    fn selector(&self, term: &GroundTerm) -> Option<u32> {
        if let GroundTerm::Table { indices, .. } = term {
            let mut reads = indices.iter().flat_map(|index| self.reads(&index.term));
            if let Some(first) = reads.next() {
                return Some(first);
            }
        }
        term.parts()
            .into_iter()
            .find_map(|part| self.selector(part))
    }
}

/// Returns the combinations of cases that can occur together.
fn join(lefts: &[Case], rights: &[Case]) -> Result<Vec<Case>, NoCases> {
    let mut all = Vec::new();
    for left in lefts {
        for right in rights {
            if let Some(when) = left.when.and(&right.when) {
                let joined = |a: &[u32], b: &[u32]| a.iter().chain(b).copied().collect();
                all.push(Case {
                    when,
                    updates: left.updates.iter().chain(&right.updates).cloned().collect(),
                    counters: joined(&left.counters, &right.counters),
                    needs_machine: left.needs_machine || right.needs_machine,
                });
            }
        }
        if all.len() > MAX_CASES {
            return Err(NoCases);
        }
    }
    Ok(all)
}

impl Conjunction {
    /// Returns both conjunctions together; `None` if they contradict each other in a single variable.
    fn and(&self, other: &Self) -> Option<Self> {
        let mut all = self.clone();
        for (variable, codes) in &other.codes {
            match all.codes.get_mut(variable) {
                None => {
                    all.codes.insert(*variable, codes.clone());
                }
                Some(known) => {
                    for (known, also) in known.iter_mut().zip(codes) {
                        *known &= also;
                    }
                    if !known.contains(&true) {
                        return None;
                    }
                }
            }
        }
        for literal in &other.literals {
            if !all.literals.contains(literal) {
                all.literals.push(literal.clone());
            }
        }
        Some(all)
    }
}
