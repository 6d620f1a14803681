//! Lowering of rules.

use super::frame::{LoweringFrame, VariableBinding};
use super::{Lowering, domain};
use crate::code::{AssignTarget, Endless, Rule, RuleNode, Term, TermNode, ValueKind};
use crate::id::{Local, Origin};
use asmotion_diagnostics::Span;
use asmotion_hir::{RuleKind, RuleTerm, TermKind, Type, VarId};
use asmotion_value::{RuleId, Value};

impl Lowering<'_> {
    pub(super) fn rule(&mut self, rule: &RuleTerm, frame: &mut LoweringFrame) -> Rule {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            let node = self.rule_node(rule, frame);
            Rule {
                node: Box::new(node),
                origin: self.origin(rule.span),
            }
        })
    }

    fn skip(&mut self, span: Span) -> Rule {
        Rule {
            node: Box::new(RuleNode::Skip),
            origin: self.origin(span),
        }
    }

    fn or_skip(&mut self, rule: Option<&RuleTerm>, span: Span, frame: &mut LoweringFrame) -> Rule {
        match rule {
            Some(rule) => self.rule(rule, frame),
            None => self.skip(span),
        }
    }

    fn rule_node(&mut self, rule: &RuleTerm, frame: &mut LoweringFrame) -> RuleNode {
        let span = rule.span;
        match &*rule.kind {
            RuleKind::Skip | RuleKind::Invalid => RuleNode::Skip,
            RuleKind::Update(target, value) => {
                let value = self.term(value, frame);
                match self.assign_target(target, frame) {
                    Some(place) => RuleNode::Update(place, value),
                    None => RuleNode::Skip,
                }
            }
            RuleKind::Assign(target, callee, arguments) => {
                let arguments = self.terms(arguments, frame);
                let routine = self.routine_by_value(*callee);
                match self.assign_target(target, frame) {
                    Some(place) => RuleNode::Assign(Some(place), routine, arguments),
                    None => RuleNode::Skip,
                }
            }
            RuleKind::Call(callee, arguments) if let Some(act) = self.model.rule(*callee).act => {
                RuleNode::Act(act, self.terms(arguments, frame))
            }
            RuleKind::Call(callee, arguments) if self.leaves_result(*callee) => {
                let arguments = self.terms(arguments, frame);
                RuleNode::Assign(None, self.routine_by_value(*callee), arguments)
            }
            RuleKind::Call(callee, arguments) => self.call(*callee, arguments, frame, span),
            RuleKind::Run(term, arguments) => self.run(term, arguments, frame),
            RuleKind::Par(rules) => RuleNode::Par(self.block(rules, frame)),
            RuleKind::Seq(rules) => RuleNode::Seq(self.block(rules, frame)),
            RuleKind::If(guard, then, otherwise) => {
                let guard = self.term(guard, frame);
                let then = self.rule(then, frame);
                RuleNode::If(guard, then, self.or_skip(otherwise.as_ref(), span, frame))
            }
            RuleKind::Switch(subject, cases, otherwise) => {
                let subject = self.term(subject, frame);
                let mut lowered = Vec::new();
                for (case, rule) in cases {
                    let case = self.term(case, frame);
                    lowered.push((case, self.rule(rule, frame)));
                }
                RuleNode::Switch(
                    subject,
                    lowered,
                    self.or_skip(otherwise.as_ref(), span, frame),
                )
            }
            RuleKind::Choose(binders, guard, body, ifnone) => {
                self.choose(binders, guard.as_ref(), body, ifnone.as_ref(), span, frame)
            }
            RuleKind::Forall(binders, guard, body) => {
                let bound = self.binders(binders, frame);
                let guard = self.guard(guard.as_ref(), frame);
                let body = self.with_state(&variables(binders), body, frame);
                RuleNode::Forall(bound, guard, body)
            }
            RuleKind::Let(bindings, body) => {
                let variables: Vec<VarId> =
                    bindings.iter().map(|(variable, _)| *variable).collect();
                let bindings = self.bindings(bindings, frame);
                RuleNode::Let(bindings, self.with_state(&variables, body, frame))
            }
            RuleKind::Extend(extended, variables, body) => {
                let locals = variables
                    .iter()
                    .map(|&variable| frame.bind(variable))
                    .collect();
                let body = self.with_state(variables, body, frame);
                let extended = domain::id(*extended);
                self.extends(extended);
                RuleNode::Extend(extended, locals, body)
            }
            RuleKind::While(guard, body) => RuleNode::While {
                guard: Some(self.term(guard, frame)),
                body: self.rule(body, frame),
                until_idle: !self.model.compatible,
            },
            RuleKind::WhileRec(guard, body) => RuleNode::While {
                guard: Some(self.term(guard, frame)),
                body: self.rule(body, frame),
                until_idle: false,
            },
            RuleKind::Iterate(body) => RuleNode::While {
                guard: None,
                body: self.rule(body, frame),
                until_idle: true,
            },
            RuleKind::Local(local) => RuleNode::Local {
                run: frame.bind(local.run),
                initial: self.block(&local.initial, frame),
                body: self.rule(&local.body, frame),
            },
        }
    }

    /// Lowers `choose`. Variables over infinite domains are drawn beforehand, provided that the
    /// guard is missing or `true`.
    fn choose(
        &mut self,
        binders: &[asmotion_hir::Binder],
        guard: Option<&asmotion_hir::Term>,
        body: &RuleTerm,
        ifnone: Option<&RuleTerm>,
        span: Span,
        frame: &mut LoweringFrame,
    ) -> RuleNode {
        let chosen = variables(binders);
        let is_open =
            guard.is_none_or(|guard| matches!(&*guard.kind, TermKind::Value(Value::Bool(true))));
        let (endless, finite): (Vec<_>, Vec<_>) = binders
            .iter()
            .cloned()
            .partition(|binder| is_open && self.endless(binder).is_some());
        let drawn: Vec<(Local, Endless, Origin)> = endless
            .iter()
            .filter_map(|binder| {
                let endless = self.endless(binder)?;
                let range = self.origin(binder.range.span);
                Some((frame.bind(binder.variable), endless, range))
            })
            .collect();
        let bound = self.binders(&finite, frame);
        let guard = self.guard(guard, frame);
        let body = self.with_state(&chosen, body, frame);
        let node = if bound.is_empty() {
            *body.node
        } else {
            RuleNode::Choose(bound, guard, body, self.or_skip(ifnone, span, frame))
        };
        if drawn.is_empty() {
            return node;
        }
        let rule = Rule {
            node: Box::new(node),
            origin: self.origin(span),
        };
        RuleNode::Draw(drawn, rule)
    }

    /// Returns the sample of an infinite domain, if the binder ranges over one.
    fn endless(&self, binder: &asmotion_hir::Binder) -> Option<Endless> {
        let TermKind::Extent(ty) = *binder.range.kind else {
            return None;
        };
        match self.model.types.get(ty) {
            Type::Integer => Some(Endless::Integer),
            Type::Natural => Some(Endless::Natural),
            Type::Real => Some(Endless::Real),
            Type::Invalid
            | Type::Undef
            | Type::Boolean
            | Type::Complex
            | Type::Char
            | Type::String
            | Type::Rule
            | Type::Domain(_)
            | Type::Prod(_)
            | Type::Seq(_)
            | Type::Powerset(_)
            | Type::Bag(_)
            | Type::Map(..) => None,
        }
    }

    /// Lowers the body of a rule that binds these variables. A variable that rules assign becomes a
    /// location, initialised with the bound value and discarded after the body.
    pub(super) fn with_state(
        &mut self,
        bound: &[VarId],
        body: &RuleTerm,
        frame: &mut LoweringFrame,
    ) -> Rule {
        let assigned: Vec<(VarId, Local)> = bound
            .iter()
            .filter(|&&variable| {
                frame
                    .rule
                    .is_some_and(|rule| self.facts.assigns(rule, variable))
            })
            .filter_map(|&variable| match frame.binding(variable) {
                Some(VariableBinding::Local(local)) => Some((variable, local)),
                Some(VariableBinding::Term(_) | VariableBinding::State { .. }) | None => None,
            })
            .collect();
        if assigned.is_empty() || self.model.compatible {
            return self.rule(body, frame);
        }
        let origin = self.origin(body.span);
        let run = frame.fresh();
        let mut initial = Vec::new();
        for (variable, local) in assigned {
            let index = variable.0;
            let place = AssignTarget::Location(self.program.variables, at(run, index, origin));
            let value = Term::local(local, origin);
            initial.push(Rule {
                node: Box::new(RuleNode::Update(place, value)),
                origin,
            });
            frame.set(variable, VariableBinding::State { run, index });
        }
        let body = self.rule(body, frame);
        Rule {
            node: Box::new(RuleNode::Local { run, initial, body }),
            origin,
        }
    }

    /// Returns `true` if a turbo rule writes a result, which must be hidden from its caller.
    pub(super) fn leaves_result(&self, rule: RuleId) -> bool {
        let declared = self.model.rule(rule);
        declared.turbo && (declared.result.is_some() || self.facts.returns(rule))
    }

    fn block(&mut self, rules: &[RuleTerm], frame: &mut LoweringFrame) -> Vec<Rule> {
        rules.iter().map(|rule| self.rule(rule, frame)).collect()
    }

    fn run(
        &mut self,
        term: &asmotion_hir::Term,
        arguments: &[asmotion_hir::Term],
        frame: &mut LoweringFrame,
    ) -> RuleNode {
        let arguments = self.terms(arguments, frame);
        let term = self.term(term, frame);
        if let TermNode::Constant(Value::Undef) = *term.node {
            RuleNode::Skip
        } else if let TermNode::Program(agent) = *term.node {
            RuleNode::RunAgent(agent, arguments)
        } else {
            RuleNode::Run(term, arguments)
        }
    }
}

fn variables(binders: &[asmotion_hir::Binder]) -> Vec<VarId> {
    binders.iter().map(|binder| binder.variable).collect()
}

/// Returns the arguments of the location that stands for a variable in a run.
pub(super) fn at(run: Local, variable: u32, origin: Origin) -> Vec<Term> {
    let index = Term {
        node: Box::new(TermNode::Constant(Value::Int(i64::from(variable)))),
        kind: ValueKind::Int,
        origin,
    };
    vec![Term::local(run, origin), index]
}
