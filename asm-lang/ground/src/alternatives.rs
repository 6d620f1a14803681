//! The choices of a step as a list.

use crate::program::{GroundCandidate, GroundProgram, GroundRule, GroundTerm};
use asmotion_ir::Origin;
use asmotion_value::Value;

/// A decision of an alternative.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundChoice {
    /// Place of the `choose`.
    pub origin: Origin,
    /// Values of the chosen variables.
    pub chosen: Vec<Value>,
}

/// One way to execute a step: a combination of choices.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundAlternative {
    /// The choices, in the order in which they are made.
    pub choices: Vec<GroundChoice>,
    /// The alternative exists where all guards are true, each evaluated only if those before it are true. Undef is a fault.
    pub guards: Vec<GroundTerm>,
    /// Effect of the alternative; contains no `choose`.
    pub rule: GroundRule,
}

impl GroundProgram {
    /// Returns the alternatives of a step, in the order of a machine's choices. `None` if there are more than `limit`, if a sequence
    /// contains a choice, or if an input is read outside the rules of the alternatives: a step then evaluates inputs that the
    /// guards of its alternative do not mention.
    ///
    /// In a state, the steps are the alternatives whose guards are true, once for each combination of the inputs that guards and
    /// rule read. Guards that are not evaluated in the order of a machine can only differ in faults: a state in which some guard
    /// of some alternative is a fault needs a machine.
    pub fn alternatives(&self, limit: usize) -> Option<Vec<GroundAlternative>> {
        split(&self.rule, limit)
    }
}

/// Returns the alternatives of a rule.
fn split(rule: &GroundRule, limit: usize) -> Option<Vec<GroundAlternative>> {
    if !chooses(rule) {
        return Some(vec![GroundAlternative {
            choices: Vec::new(),
            guards: Vec::new(),
            rule: rule.clone(),
        }]);
    }
    let all = match rule {
        GroundRule::Par(rules) => {
            let mut all = vec![GroundAlternative {
                choices: Vec::new(),
                guards: Vec::new(),
                rule: GroundRule::Skip,
            }];
            for rule in rules {
                let parts = split(rule, limit)?;
                if all.len().saturating_mul(parts.len()) > limit {
                    return None;
                }
                let joined = all
                    .iter()
                    .flat_map(|left| parts.iter().map(move |right| both(left, right)));
                all = joined.collect();
            }
            all
        }
        GroundRule::If(guard, then, otherwise) => {
            let otherwise_guard = crate::fold::not(guard.clone());
            let mut all = under(guard, split(then, limit)?);
            all.extend(under(&otherwise_guard, split(otherwise, limit)?));
            all
        }
        GroundRule::Choose(candidates, otherwise, origin) => {
            let mut all = Vec::new();
            let mut none = Vec::new();
            for GroundCandidate {
                chosen,
                guard,
                rule,
            } in candidates
            {
                if reads_input(guard) {
                    return None;
                }
                let mut inner = under(guard, split(rule, limit)?);
                for alternative in &mut inner {
                    let choice = GroundChoice {
                        origin: *origin,
                        chosen: chosen.clone(),
                    };
                    alternative.choices.insert(0, choice);
                }
                all.extend(inner);
                none.push(crate::fold::not(guard.clone()));
            }
            // `ifnone`, unless some guard is always true
            if !none.contains(&GroundTerm::Constant(0)) {
                let mut inner = split(otherwise, limit)?;
                for guard in none.iter().rev() {
                    inner = under(guard, inner);
                }
                all.extend(inner);
            }
            all
        }
        GroundRule::After(terms, rule) => {
            let mut all = split(rule, limit)?;
            for alternative in &mut all {
                let inner = std::mem::replace(&mut alternative.rule, GroundRule::Skip);
                alternative.rule = GroundRule::After(terms.clone(), Box::new(inner));
            }
            // the inputs are read before those of guards
            if terms.iter().any(reads_input) {
                return None;
            }
            all
        }
        GroundRule::Counted(counter, rule) => {
            let mut all = split(rule, limit)?;
            for alternative in &mut all {
                let inner = std::mem::replace(&mut alternative.rule, GroundRule::Skip);
                alternative.rule = GroundRule::Counted(*counter, Box::new(inner));
            }
            all
        }
        GroundRule::Seq(_) => return None,
        GroundRule::Skip | GroundRule::Update(..) | GroundRule::Machine => return None,
    };
    (all.len() <= limit).then_some(all)
}

/// Executes two alternatives in parallel.
fn both(left: &GroundAlternative, right: &GroundAlternative) -> GroundAlternative {
    let mut choices = left.choices.clone();
    choices.extend(right.choices.iter().cloned());
    let mut guards = left.guards.clone();
    guards.extend(right.guards.iter().cloned());
    GroundAlternative {
        choices,
        guards,
        rule: crate::fold::par(vec![left.rule.clone(), right.rule.clone()]),
    }
}

/// Adds a guard before those of the alternatives.
fn under(guard: &GroundTerm, mut alternatives: Vec<GroundAlternative>) -> Vec<GroundAlternative> {
    if *guard != GroundTerm::Constant(1) {
        for alternative in &mut alternatives {
            alternative.guards.insert(0, guard.clone());
        }
    }
    alternatives
}

fn reads_input(term: &GroundTerm) -> bool {
    matches!(term, GroundTerm::Input(_)) || term.parts().into_iter().any(reads_input)
}

/// Returns `true` if a rule contains a choice.
pub(crate) fn chooses(rule: &GroundRule) -> bool {
    match rule {
        GroundRule::Choose(..) => true,
        GroundRule::Par(rules) | GroundRule::Seq(rules) => rules.iter().any(chooses),
        GroundRule::If(_, then, otherwise) => chooses(then) || chooses(otherwise),
        GroundRule::After(_, rule) | GroundRule::Counted(_, rule) => chooses(rule),
        GroundRule::Skip | GroundRule::Update(..) | GroundRule::Machine => false,
    }
}
