//! Cone of influence: the variables that some terms depend on, and the part of a rule that updates them.

use crate::program::{GroundCandidate, GroundRule, GroundTarget, GroundTerm};
use crate::visit::{accesses_of_rule, accesses_of_term};
use std::collections::BTreeSet;

/// Returns the variables on which these terms depend in any later state: those that they read, and those that decide how these are
/// updated.
pub fn cone(rule: &GroundRule, terms: &[GroundTerm]) -> BTreeSet<u32> {
    let mut cone = BTreeSet::new();
    for term in terms {
        cone.extend(accesses_of_term(term).reads);
    }
    loop {
        let before = cone.len();
        extend(rule, &mut cone);
        if cone.len() == before {
            return cone;
        }
    }
}

/// Adds what decides about updates of variables in the cone; returns `true` if the rule updates some.
fn extend(rule: &GroundRule, cone: &mut BTreeSet<u32>) -> bool {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || match rule {
        GroundRule::Skip | GroundRule::Machine => false,
        GroundRule::Update(target, ..) => {
            let is_in = writes(target).iter().any(|it| cone.contains(it));
            if is_in {
                let accesses = accesses_of_rule(rule);
                cone.extend(accesses.reads);
                cone.extend(accesses.writes);
            }
            is_in
        }
        GroundRule::Par(rules) => {
            let mut is_in = false;
            for rule in rules {
                is_in |= extend(rule, cone);
            }
            is_in
        }
        // a rule reads what those before it have updated
        GroundRule::Seq(_) => {
            let accesses = accesses_of_rule(rule);
            let is_in = accesses.writes.iter().any(|it| cone.contains(it));
            if is_in {
                cone.extend(accesses.reads);
                cone.extend(accesses.writes);
            }
            is_in
        }
        GroundRule::If(guard, then, otherwise) => {
            let is_then = extend(then, cone);
            let is_in = extend(otherwise, cone) || is_then;
            if is_in {
                cone.extend(accesses_of_term(guard).reads);
            }
            is_in
        }
        GroundRule::Choose(candidates, otherwise, _) => {
            let mut is_in = extend(otherwise, cone);
            for candidate in candidates {
                is_in |= extend(&candidate.rule, cone);
            }
            if is_in {
                for candidate in candidates {
                    cone.extend(accesses_of_term(&candidate.guard).reads);
                }
            }
            is_in
        }
        // the terms only decide about faults
        GroundRule::After(_, rule) | GroundRule::Counted(_, rule) => extend(rule, cone),
    })
}

fn writes(target: &GroundTarget) -> &[u32] {
    match target {
        GroundTarget::Variable(index) => std::slice::from_ref(index),
        GroundTarget::Table(_, variables) => variables,
    }
}

impl GroundRule {
    /// Returns the part of the rule that updates the variables in a set, which contains what decides about these updates. The part
    /// makes the same updates of these variables. It does not fail where other parts of the rule fail, or where updates of other
    /// variables clash.
    #[must_use]
    pub fn projected(&self, cone: &BTreeSet<u32>) -> Self {
        let of = |rule: &Self| rule.projected(cone);
        let is_in = accesses_of_rule(self)
            .writes
            .iter()
            .any(|it| cone.contains(it));
        if !is_in {
            return Self::Skip;
        }
        match self {
            Self::Skip | Self::Machine | Self::Update(..) | Self::Seq(_) => self.clone(),
            Self::Par(rules) => crate::fold::par(rules.iter().map(of).collect()),
            Self::If(guard, then, otherwise) => {
                Self::If(guard.clone(), Box::new(of(then)), Box::new(of(otherwise)))
            }
            Self::Choose(candidates, otherwise, origin) => {
                let candidates = candidates.iter().map(|it| GroundCandidate {
                    chosen: it.chosen.clone(),
                    guard: it.guard.clone(),
                    rule: of(&it.rule),
                });
                Self::Choose(candidates.collect(), Box::new(of(otherwise)), *origin)
            }
            Self::After(_, rule) => of(rule),
            Self::Counted(counter, rule) => Self::Counted(*counter, Box::new(of(rule))),
        }
    }
}
