//! Exits of control states: whether a rule can give a function another value than the present one.
//!
//! The answer is exact in one direction: without an exit, no step leaves the state. An exit may still be unreachable,
//! because only conditions that compare the function with literals are evaluated.

use crate::id::FunctionId;
use crate::model::{Model, RuleKind, RuleTerm, Term, TermKind, UpdateTarget};
use asmotion_value::{RuleId, Value};
use std::collections::BTreeSet;

impl Model {
    /// Returns whether a rule may update a function without arguments to another value than `state` while it has this
    /// value.
    pub fn has_exit(&self, function: FunctionId, state: &Value) -> bool {
        let mut search = ExitSearch {
            model: self,
            function,
            state,
            visited: BTreeSet::new(),
        };
        let rules = (0..).map(RuleId).zip(&self.rules);
        let own = rules.filter(|(_, rule)| !rule.library);
        // a rule that no other calls can still be the program of an agent or the value of a term
        let called: BTreeSet<RuleId> = own
            .clone()
            .flat_map(|(_, rule)| rule.body.iter())
            .flat_map(|body| calls(&body.root))
            .collect();
        let mut roots = own.filter(|(id, _)| !called.contains(id));
        roots.any(|(id, _)| search.in_rule(id))
            || self.main.is_some_and(|main| search.in_rule(main))
    }
}

/// The rules that a rule calls directly.
fn calls(rule: &RuleTerm) -> Vec<RuleId> {
    let mut called = Vec::new();
    let mut rest = vec![rule];
    while let Some(rule) = rest.pop() {
        if let RuleKind::Call(id, _) | RuleKind::Assign(_, id, _) = &*rule.kind {
            called.push(*id);
        }
        rest.extend(parts(rule));
    }
    called
}

/// The rules that a rule is composed of.
fn parts(rule: &RuleTerm) -> Vec<&RuleTerm> {
    match &*rule.kind {
        RuleKind::Skip
        | RuleKind::Update(..)
        | RuleKind::Assign(..)
        | RuleKind::Call(..)
        | RuleKind::Run(..)
        | RuleKind::Invalid => Vec::new(),
        RuleKind::Par(rules) | RuleKind::Seq(rules) => rules.iter().collect(),
        RuleKind::If(_, then, otherwise) => std::iter::once(then).chain(otherwise).collect(),
        RuleKind::Switch(_, cases, otherwise) => {
            let cases = cases.iter().map(|(_, rule)| rule);
            cases.chain(otherwise).collect()
        }
        RuleKind::Choose(_, _, body, otherwise) => std::iter::once(body).chain(otherwise).collect(),
        RuleKind::Forall(_, _, body)
        | RuleKind::Let(_, body)
        | RuleKind::Extend(_, _, body)
        | RuleKind::While(_, body)
        | RuleKind::WhileRec(_, body)
        | RuleKind::Iterate(body) => vec![body],
        RuleKind::Local(local) => local.initial.iter().chain([&local.body]).collect(),
    }
}

/// A search for an update that leaves a state.
struct ExitSearch<'m> {
    model: &'m Model,
    function: FunctionId,
    state: &'m Value,
    visited: BTreeSet<RuleId>,
}

impl ExitSearch<'_> {
    fn in_rule(&mut self, rule: RuleId) -> bool {
        if !self.visited.insert(rule) {
            return false;
        }
        let rule = self.model.rule(rule);
        // a rule of a library has no access to the function but through its arguments
        match &rule.body {
            Some(body) if !rule.library => self.leaves(&body.root),
            Some(_) | None => false,
        }
    }

    /// Returns whether the rule may leave the state.
    fn leaves(&mut self, rule: &RuleTerm) -> bool {
        match &*rule.kind {
            RuleKind::Update(target, value) => self.changes(target, Some(value)),
            RuleKind::Assign(target, rule, _) => self.changes(target, None) || self.in_rule(*rule),
            RuleKind::Call(rule, _) => self.in_rule(*rule),
            // the rule is known only at run time
            RuleKind::Run(..) => true,
            RuleKind::If(condition, then, otherwise) => match self.truth(condition) {
                Some(true) => self.leaves(then),
                Some(false) => otherwise.as_ref().is_some_and(|rule| self.leaves(rule)),
                None => {
                    self.leaves(then) || otherwise.as_ref().is_some_and(|rule| self.leaves(rule))
                }
            },
            RuleKind::Switch(subject, cases, otherwise) if self.is_function(subject) => {
                let selected = cases
                    .iter()
                    .find(|(case, _)| self.literal(case) == Some(true));
                match (selected, otherwise) {
                    (Some((_, rule)), _) => self.leaves(rule),
                    (None, otherwise) => {
                        let open = cases
                            .iter()
                            .filter(|(case, _)| self.literal(case).is_none());
                        let open: Vec<&RuleTerm> = open.map(|(_, rule)| rule).collect();
                        open.into_iter()
                            .chain(otherwise)
                            .any(|rule| self.leaves(rule))
                    }
                }
            }
            RuleKind::While(condition, body) | RuleKind::WhileRec(condition, body) => {
                self.truth(condition) != Some(false) && self.leaves(body)
            }
            RuleKind::Skip
            | RuleKind::Par(_)
            | RuleKind::Seq(_)
            | RuleKind::Switch(..)
            | RuleKind::Choose(..)
            | RuleKind::Forall(..)
            | RuleKind::Let(..)
            | RuleKind::Extend(..)
            | RuleKind::Iterate(_)
            | RuleKind::Local(_)
            | RuleKind::Invalid => parts(rule).into_iter().any(|part| self.leaves(part)),
        }
    }

    /// Returns whether an update may give the function another value. A variable may stand for it.
    fn changes(&self, target: &UpdateTarget, value: Option<&Term>) -> bool {
        let is_it = match target {
            UpdateTarget::Location(function, _) => *function == self.function,
            UpdateTarget::Variable(_) => true,
        };
        is_it && value.is_none_or(|value| self.literal(value) != Some(true))
    }

    /// The value of a condition in the state; `None` if it depends on anything else.
    fn truth(&self, condition: &Term) -> Option<bool> {
        if let TermKind::Value(Value::Bool(truth)) = &*condition.kind {
            return Some(*truth);
        }
        let TermKind::Apply(function, arguments) = &*condition.kind else {
            return None;
        };
        let function = self.model.function(*function);
        let name = Some(&*function.name).filter(|_| function.library)?;
        match (name, arguments.as_slice()) {
            ("eq", [left, right]) => self.is_equal(left, right),
            ("neq", [left, right]) => self.is_equal(left, right).map(|equal| !equal),
            ("not", [inner]) => self.truth(inner).map(|truth| !truth),
            ("and", [left, right]) => both(self.truth(left), self.truth(right)),
            ("or", [left, right]) => {
                let not = |truth: Option<bool>| truth.map(|truth| !truth);
                not(both(not(self.truth(left)), not(self.truth(right))))
            }
            _ => None,
        }
    }

    fn is_equal(&self, left: &Term, right: &Term) -> Option<bool> {
        if self.is_function(left) {
            self.literal(right)
        } else if self.is_function(right) {
            self.literal(left)
        } else {
            None
        }
    }

    fn is_function(&self, term: &Term) -> bool {
        matches!(&*term.kind, TermKind::Apply(function, arguments)
            if *function == self.function && arguments.is_empty())
    }

    /// Returns whether a term is the literal of the state; `None` if it is no literal.
    fn literal(&self, term: &Term) -> Option<bool> {
        if let TermKind::Value(value) = &*term.kind {
            Some(value == self.state)
        } else {
            None
        }
    }
}

/// The conjunction of two truth values, each of which may be unknown.
fn both(left: Option<bool>, right: Option<bool>) -> Option<bool> {
    match (left, right) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), Some(true)) => Some(true),
        (None, _) | (_, None) => None,
    }
}
