//! Grounding of rules.

use crate::fold;
use crate::grounding::Grounding;
use crate::known::KnownTerm;
use crate::program::{FAULT, GroundCandidate, GroundRule, GroundTarget, GroundTerm, Sort};
use crate::term::{LocalFrame, equal, loud};
use asmotion_ir::{AssignTarget, Counter, Origin, RoutineId, Rule, RuleNode, Term};
use asmotion_value::Value;

impl Grounding<'_> {
    /// Grounds the call of a routine with arguments, which are evaluated first.
    pub fn routine(&mut self, routine: RoutineId, arguments: Vec<KnownTerm>) -> GroundRule {
        let program = self.context.program;
        let Some(routine) = program.routines.get(routine.0 as usize) else {
            return GroundRule::Machine;
        };
        if routine.open || arguments.len() != routine.arguments as usize {
            return GroundRule::Machine;
        }
        let Some(first) = loud(&arguments) else {
            return GroundRule::Machine;
        };
        let mut frame = LocalFrame::new(arguments, routine.locals);
        let rule = self.nested(|grounding| grounding.rule(&routine.code, &mut frame));
        fold::rule_after(first, rule.unwrap_or(GroundRule::Machine))
    }

    fn rule(&mut self, rule: &Rule, frame: &mut LocalFrame) -> GroundRule {
        if !self.has_room() {
            return GroundRule::Machine;
        }
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.rule_here(rule, frame))
    }

    fn rule_here(&mut self, rule: &Rule, frame: &mut LocalFrame) -> GroundRule {
        match &*rule.node {
            RuleNode::Skip => GroundRule::Skip,
            RuleNode::Update(target, value) => self.update(target, value, rule.origin, frame),
            RuleNode::Call(routine, arguments) => {
                let arguments = self.terms(arguments, frame);
                self.routine(*routine, arguments)
            }
            RuleNode::Run(term, arguments) => {
                let KnownTerm::Value(rule) = self.term(term, frame) else {
                    return GroundRule::Machine;
                };
                let arguments = self.terms(arguments, frame);
                self.rule_value(&rule, arguments)
            }
            RuleNode::RunAgent(agent, arguments) => {
                let KnownTerm::Value(agent) = self.term(agent, frame) else {
                    return GroundRule::Machine;
                };
                let Some(rule) = self.program_of(&agent) else {
                    return GroundRule::Machine;
                };
                let arguments = self.terms(arguments, frame);
                let outer = std::mem::replace(&mut self.agent, KnownTerm::Value(agent));
                let rule = self.rule_value(&Value::Rule(rule), arguments);
                self.agent = outer;
                rule
            }
            RuleNode::Par(rules) => {
                let rules = rules.iter().map(|rule| self.rule(rule, frame));
                fold::par(rules.collect())
            }
            RuleNode::Seq(rules) => {
                let rules: Vec<GroundRule> =
                    rules.iter().map(|rule| self.rule(rule, frame)).collect();
                let mut rules: Vec<GroundRule> = rules
                    .into_iter()
                    .filter(|it| *it != GroundRule::Skip)
                    .collect();
                match rules.len() {
                    0 => GroundRule::Skip,
                    1 => rules.remove(0),
                    _ => GroundRule::Seq(rules),
                }
            }
            RuleNode::If(guard, then, otherwise) => {
                let guard = self.truth(guard, frame);
                match guard.constant() {
                    Some(1) => self.rule(then, frame),
                    Some(0) => self.rule(otherwise, frame),
                    Some(_) => GroundRule::Machine,
                    None => {
                        let then = self.rule(then, frame);
                        let otherwise = self.rule(otherwise, frame);
                        fold::rule_branch(guard, then, otherwise)
                    }
                }
            }
            RuleNode::Switch(subject, cases, otherwise) => {
                let subject = self.term(subject, frame);
                self.rule_switch(subject, cases, otherwise, frame)
            }
            RuleNode::Choose(binders, guard, body, ifnone) => {
                let chosen: Vec<u32> = binders.iter().map(|binder| binder.local).collect();
                let candidates = self.instances(binders, frame, |grounding, frame| {
                    let guard = grounding.guard(guard.as_ref(), frame);
                    let values = chosen.iter().map(|local| match frame.known(*local) {
                        Some(KnownTerm::Value(value)) => value.clone(),
                        Some(KnownTerm::Term(..) | KnownTerm::Tuple(_) | KnownTerm::Unknown)
                        | None => Value::Undef,
                    });
                    let chosen = values.collect();
                    let rule = match guard.constant() {
                        Some(0) => GroundRule::Skip,
                        Some(_) | None => grounding.rule(body, frame),
                    };
                    GroundCandidate {
                        chosen,
                        guard,
                        rule,
                    }
                });
                let Some(candidates) = candidates else {
                    return GroundRule::Machine;
                };
                let otherwise = self.rule(ifnone, frame);
                fold::choose(candidates, otherwise, rule.origin)
            }
            RuleNode::Forall(binders, guard, body) => {
                let rules = self.instances(binders, frame, |grounding, frame| {
                    let guard = grounding.guard(guard.as_ref(), frame);
                    match guard.constant() {
                        Some(0) => GroundRule::Skip,
                        Some(1) => grounding.rule(body, frame),
                        Some(_) => GroundRule::Machine,
                        None => {
                            let body = grounding.rule(body, frame);
                            fold::rule_branch(guard, body, GroundRule::Skip)
                        }
                    }
                });
                rules.map_or(GroundRule::Machine, fold::par)
            }
            RuleNode::Let(bindings, body) => {
                let mut first = Vec::new();
                for (local, term) in bindings {
                    let bound = self.term(term, frame);
                    let Some(evaluated) = loud(std::slice::from_ref(&bound)) else {
                        return GroundRule::Machine;
                    };
                    first.extend(evaluated);
                    frame.set(*local, bound);
                }
                let body = self.rule(body, frame);
                fold::rule_after(first, body)
            }
            RuleNode::Watched(rule) => self.rule(rule, frame),
            RuleNode::Counted(counter, inner) => {
                let inner = self.rule(inner, frame);
                counted(*counter, inner)
            }
            RuleNode::Assign(..)
            | RuleNode::Extend(..)
            | RuleNode::While { .. }
            | RuleNode::Local { .. }
            | RuleNode::Draw(..)
            | RuleNode::Act(..) => GroundRule::Machine,
        }
    }

    fn guard(&mut self, guard: Option<&Term>, frame: &mut LocalFrame) -> GroundTerm {
        match guard {
            Some(guard) => self.truth(guard, frame),
            None => GroundTerm::Constant(1),
        }
    }

    fn update(
        &mut self,
        target: &AssignTarget,
        value: &Term,
        origin: Origin,
        frame: &mut LocalFrame,
    ) -> GroundRule {
        let value = self.term(value, frame);
        let target = match target {
            AssignTarget::Slot(_, slot) => match self.variable(*slot) {
                Some(variable) => GroundTarget::Variable(variable),
                None => return GroundRule::Machine,
            },
            AssignTarget::Location(function, arguments) => {
                let arguments = self.terms(arguments, frame);
                let Some((base, indices, count)) = self.indices(*function, arguments) else {
                    return GroundRule::Machine;
                };
                let variables = (base..base.saturating_add(count)).map(|slot| self.variable(slot));
                let Some(variables) = variables.collect::<Option<Vec<u32>>>() else {
                    return GroundRule::Machine;
                };
                match fold::resolved(indices, variables) {
                    Some((indices, variables)) => match (indices.is_empty(), &*variables) {
                        (true, [variable]) => GroundTarget::Variable(*variable),
                        _ => GroundTarget::Table(indices, variables),
                    },
                    None => return GroundRule::Machine,
                }
            }
            AssignTarget::Local(_) => return GroundRule::Machine,
        };
        let first = match &target {
            GroundTarget::Variable(variable) => Some(*variable),
            GroundTarget::Table(_, variables) => variables.first().copied(),
        };
        let sort = first.and_then(|index| self.variables.get(index as usize));
        let Some(sort) = sort.map(|it| it.sort) else {
            return GroundRule::Machine;
        };
        let value = value.of_sort(sort);
        if value == GroundTerm::Constant(FAULT) {
            return GroundRule::Machine;
        }
        GroundRule::Update(target, value, origin)
    }

    fn rule_value(&mut self, rule: &Value, given: Vec<KnownTerm>) -> GroundRule {
        let program = self.context.program;
        let Value::Rule(id) = rule else {
            return GroundRule::Machine;
        };
        let Some(rule) = program.rules.get(id.0 as usize) else {
            return GroundRule::Machine;
        };
        let (Some(routine), false) = (rule.routine, rule.returns) else {
            return GroundRule::Machine;
        };
        let mut arguments: Vec<KnownTerm> = Vec::new();
        for body in &rule.arguments {
            arguments.push(self.call(*body, Vec::new()));
        }
        arguments.extend(given);
        self.routine(routine, arguments)
    }

    fn rule_switch(
        &mut self,
        subject: KnownTerm,
        cases: &[(Term, Rule)],
        otherwise: &Rule,
        frame: &mut LocalFrame,
    ) -> GroundRule {
        let Some(first) = loud(std::slice::from_ref(&subject)) else {
            return GroundRule::Machine;
        };
        let mut guarded = Vec::new();
        let mut last = None;
        for (case, rule) in cases {
            let case = self.term(case, frame);
            if !self.may_copy(&subject) {
                return GroundRule::Machine;
            }
            let guard = equal(subject.clone(), case).of_sort(Sort::Bool);
            match guard.constant() {
                Some(0) => {}
                Some(1) => {
                    last = Some(self.rule(rule, frame));
                    break;
                }
                Some(_) => return GroundRule::Machine,
                None => guarded.push((guard, self.rule(rule, frame))),
            }
        }
        let last = match last {
            Some(last) => last,
            None => self.rule(otherwise, frame),
        };
        let cases = guarded.into_iter().rev();
        let whole = cases.fold(last, |rest, (guard, rule)| {
            fold::rule_branch(guard, rule, rest)
        });
        fold::rule_after(first, whole)
    }
}

/// Puts a coverage counter around a rule, unless a machine executes it, which counts itself.
fn counted(counter: Counter, rule: GroundRule) -> GroundRule {
    if rule == GroundRule::Machine {
        rule
    } else {
        GroundRule::Counted(counter, Box::new(rule))
    }
}
