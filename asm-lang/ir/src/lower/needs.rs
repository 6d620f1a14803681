//! Determines which arguments a rule always uses, and which can be evaluated without an observable
//! effect. Any other argument is passed by name: evaluating it could fail or ask the environment
//! although no rule uses its value.

use super::facts::{Facts, subterms, visit, walk};
use asmotion_hir::{
    Binder, Body, FunctionKind, Meaning, Model, RuleKind, RuleTerm, Term, TermKind, UpdateTarget,
    VarId,
};
use asmotion_value::RuleId;
use std::collections::{BTreeMap, BTreeSet};

/// Library functions that are defined for all arguments.
const TOTAL: &[&str] = &[
    "eq", "neq", "lt", "le", "gt", "ge", "and", "or", "xor", "not", "implies", "iff", "isDef",
    "isUndef", "contains", "size", "length", "isEmpty", "notEmpty",
];

impl Facts {
    /// Returns `true` if the evaluation of a term neither fails nor asks the environment.
    pub fn is_silent(&self, model: &Model, term: &Term) -> bool {
        let mut silent = true;
        visit(term, &mut |term| {
            silent &= match &*term.kind {
                TermKind::Apply(function, _) | TermKind::Spread(function, _) => {
                    let declared = model.function(*function);
                    match &declared.meaning {
                        Meaning::State => {
                            let is_input = matches!(
                                declared.kind,
                                FunctionKind::Monitored | FunctionKind::Shared
                            );
                            // other initial values may be computed on first access
                            let is_known =
                                declared.initial.is_none() || declared.parameters.is_empty();
                            !is_input && is_known
                        }
                        Meaning::Builtin(builtin) => TOTAL.contains(&builtin.name),
                        Meaning::Constant(_) | Meaning::Machine | Meaning::Missing => true,
                        Meaning::Defined(_) => false,
                    }
                }
                TermKind::Value(_)
                | TermKind::Variable(_)
                | TermKind::Tuple(_)
                | TermKind::If(..)
                | TermKind::Switch(..)
                | TermKind::Let(..)
                | TermKind::Listed(..)
                | TermKind::Map(_)
                | TermKind::Rule(_) => true,
                TermKind::Quantified(..)
                | TermKind::Interval(..)
                | TermKind::Comprehension(..)
                | TermKind::MapComprehension(..)
                | TermKind::Extent(_)
                | TermKind::Element(..)
                | TermKind::Unbound
                | TermKind::Invalid => false,
            };
        });
        silent
    }

    /// Records the parameters that a rule uses in every execution.
    pub(super) fn needs_of(&mut self, model: &Model, id: RuleId, body: &Body<RuleTerm>) {
        let needed = self.needed_by_rule(model, &body.root);
        let parameters = needed
            .into_iter()
            .filter(|variable| (variable.0 as usize) < body.parameters);
        self.needed
            .extend(parameters.map(|variable| (id, variable)));
    }

    fn needed_by_rule(&self, model: &Model, rule: &RuleTerm) -> BTreeSet<VarId> {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            self.needed_by_rule_here(model, rule)
        })
    }

    fn needed_by_rule_here(&self, model: &Model, rule: &RuleTerm) -> BTreeSet<VarId> {
        let mut needed = BTreeSet::new();
        let all = |rules: &[RuleTerm]| {
            rules
                .iter()
                .flat_map(|rule| self.needed_by_rule(model, rule))
                .collect::<Vec<_>>()
        };
        match &*rule.kind {
            RuleKind::Update(target, value) => {
                if let UpdateTarget::Location(_, arguments) = target {
                    arguments
                        .iter()
                        .for_each(|term| needed_by(model, term, &mut needed));
                }
                needed_by(model, value, &mut needed);
            }
            RuleKind::Assign(target, _, arguments) => {
                if let UpdateTarget::Location(_, places) = target {
                    places
                        .iter()
                        .for_each(|term| needed_by(model, term, &mut needed));
                }
                arguments
                    .iter()
                    .for_each(|term| needed_by(model, term, &mut needed));
            }
            RuleKind::Call(callee, arguments) => {
                let turbo = model.rule(*callee).turbo;
                for (index, argument) in (0..).zip(arguments) {
                    if turbo || self.needs(*callee, VarId(index)) {
                        needed_by(model, argument, &mut needed);
                    }
                }
            }
            RuleKind::Run(term, arguments) => {
                needed_by(model, term, &mut needed);
                arguments
                    .iter()
                    .for_each(|term| needed_by(model, term, &mut needed));
            }
            RuleKind::Par(rules) | RuleKind::Seq(rules) => needed.extend(all(rules)),
            RuleKind::If(guard, then, otherwise) => {
                needed_by(model, guard, &mut needed);
                let then = self.needed_by_rule(model, then);
                if let Some(otherwise) = otherwise {
                    let otherwise = self.needed_by_rule(model, otherwise);
                    needed.extend(then.intersection(&otherwise));
                }
            }
            RuleKind::Switch(subject, ..) => needed_by(model, subject, &mut needed),
            RuleKind::Choose(binders, ..) | RuleKind::Forall(binders, ..) => {
                needed_by_ranges(model, binders, &mut needed);
            }
            RuleKind::Let(bindings, body) => {
                bindings
                    .iter()
                    .for_each(|(_, term)| needed_by(model, term, &mut needed));
                needed.extend(self.needed_by_rule(model, body));
            }
            RuleKind::Extend(_, _, body) | RuleKind::Iterate(body) => {
                needed.extend(self.needed_by_rule(model, body));
            }
            RuleKind::While(guard, _) | RuleKind::WhileRec(guard, _) => {
                needed_by(model, guard, &mut needed);
            }
            RuleKind::Local(local) => {
                needed.extend(all(&local.initial));
                needed.extend(self.needed_by_rule(model, &local.body));
            }
            RuleKind::Skip | RuleKind::Invalid => {}
        }
        needed
    }
}

/// Adds the variables that every evaluation of a term uses.
fn needed_by(model: &Model, term: &Term, needed: &mut BTreeSet<VarId>) {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || match &*term.kind {
        TermKind::Variable(variable) => drop(needed.insert(*variable)),
        TermKind::Apply(..)
        | TermKind::Spread(..)
        | TermKind::Tuple(_)
        | TermKind::Listed(..)
        | TermKind::Interval(..)
        | TermKind::Map(_)
        | TermKind::Let(..) => {
            // a connective may skip its second operand
            let mut first = true;
            let lazy = is_connective(model, term);
            subterms(term, &mut |term| {
                if first || !lazy {
                    needed_by(model, term, needed);
                }
                first = false;
            });
        }
        TermKind::If(guard, ..) | TermKind::Switch(guard, ..) => needed_by(model, guard, needed),
        TermKind::Quantified(_, binders, _)
        | TermKind::Comprehension(_, binders, ..)
        | TermKind::MapComprehension(binders, ..) => needed_by_ranges(model, binders, needed),
        TermKind::Value(_)
        | TermKind::Rule(_)
        | TermKind::Extent(_)
        | TermKind::Element(..)
        | TermKind::Unbound
        | TermKind::Invalid => {}
    });
}

/// Adds the variables used by the first range; the others are skipped if it is empty.
fn needed_by_ranges(model: &Model, binders: &[Binder], needed: &mut BTreeSet<VarId>) {
    if let Some(binder) = binders.first() {
        needed_by(model, &binder.range, needed);
    }
}

/// Returns `true` if a term can have a value without evaluating its second operand.
fn is_connective(model: &Model, term: &Term) -> bool {
    let TermKind::Apply(function, _) = &*term.kind else {
        return false;
    };
    matches!(
        model.function(*function).meaning,
        Meaning::Builtin(builtin) if ["and", "or", "implies"].contains(&builtin.name)
    )
}

/// Returns the rules on a cycle of calls, or on a path between two cycles: those that remain after
/// repeatedly removing rules without a caller, and then rules without a callee. An
/// over-approximation of recursion that takes linear time.
pub(super) fn recursive(model: &Model) -> BTreeSet<RuleId> {
    let mut calls: Vec<(RuleId, RuleId)> = Vec::new();
    for (index, rule) in (0..).zip(&model.rules) {
        if let Some(body) = &rule.body {
            walk(&body.root, &mut |rule| {
                if let RuleKind::Call(callee, _) | RuleKind::Assign(_, callee, _) = &*rule.kind {
                    calls.push((RuleId(index), *callee));
                }
            });
        }
    }
    let forth = on_cycles(calls);
    let back = on_cycles(
        forth
            .into_iter()
            .map(|(caller, callee)| (callee, caller))
            .collect(),
    );
    back.into_iter()
        .flat_map(|(callee, caller)| [callee, caller])
        .collect()
}

/// Returns the edges that remain after repeatedly removing the nodes without an incoming edge.
fn on_cycles(mut edges: Vec<(RuleId, RuleId)>) -> Vec<(RuleId, RuleId)> {
    edges.sort_unstable();
    let mut arriving: BTreeMap<RuleId, usize> = BTreeMap::new();
    for (from, to) in &edges {
        arriving.entry(*from).or_default();
        *arriving.entry(*to).or_default() += 1;
    }
    let is_start = |(node, count): (&RuleId, &usize)| (*count == 0).then_some(*node);
    let mut open: Vec<RuleId> = arriving.iter().filter_map(is_start).collect();
    let mut taken = BTreeSet::new();
    while let Some(node) = open.pop() {
        taken.insert(node);
        let first = edges.partition_point(|(from, _)| *from < node);
        for (_, to) in edges[first..].iter().take_while(|(from, _)| *from == node) {
            if let Some(count) = arriving.get_mut(to) {
                *count -= 1;
                if *count == 0 {
                    open.push(*to);
                }
            }
        }
    }
    edges.retain(|(from, _)| !taken.contains(from));
    edges
}
