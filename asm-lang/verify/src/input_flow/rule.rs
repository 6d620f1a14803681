//! The flow of values through rules.

use super::{Denotation, EscapeUse, Frame, InputFlow, Point};
use asmotion_lang::ir::{AssignTarget, Binder, Origin, Rule, RuleNode, Term};

impl InputFlow<'_> {
    pub(super) fn rule(&mut self, rule: &Rule) {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.rule_here(rule));
    }

    fn rule_here(&mut self, rule: &Rule) {
        match &*rule.node {
            RuleNode::Skip => {}
            RuleNode::Update(target, value) => {
                let flow = self.term(value);
                self.assign(target, flow, rule.origin);
            }
            RuleNode::Assign(target, routine, arguments) => {
                self.call(Frame::Routine(*routine), arguments);
                if let Some(target) = target {
                    let result = self.program.dense_function(self.program.result);
                    let result = result.map(|id| self.at(Point::Function(id)));
                    self.assign(target, result.unwrap_or_else(Denotation::any), rule.origin);
                }
            }
            RuleNode::Call(routine, arguments) => self.call(Frame::Routine(*routine), arguments),
            RuleNode::Run(term, arguments) | RuleNode::RunAgent(term, arguments) => {
                self.need_all(std::iter::once(term).chain(arguments), &EscapeUse::Other);
                self.rules_as_values();
            }
            RuleNode::Par(rules) | RuleNode::Seq(rules) => {
                for rule in rules {
                    self.rule(rule);
                }
            }
            RuleNode::If(guard, then, otherwise) => {
                self.need(guard, &EscapeUse::Other);
                self.rule(then);
                self.rule(otherwise);
            }
            RuleNode::Switch(subject, cases, otherwise) => {
                for (case, rule) in cases {
                    self.compare(subject, case, false, case.origin);
                    self.rule(rule);
                }
                self.rule(otherwise);
            }
            RuleNode::Choose(binders, guard, body, otherwise) => {
                self.binding(binders, guard.as_ref(), body);
                self.rule(otherwise);
            }
            RuleNode::Forall(binders, guard, body) => {
                self.binding(binders, guard.as_ref(), body);
            }
            RuleNode::Let(bindings, body) => {
                for (local, term) in bindings {
                    let flow = self.term(term);
                    self.variable(*local, flow);
                }
                self.rule(body);
            }
            RuleNode::Extend(_, locals, body) => {
                for local in locals {
                    self.variable(*local, Denotation::any());
                }
                self.rule(body);
            }
            RuleNode::Watched(rule) | RuleNode::Counted(_, rule) => self.rule(rule),
            RuleNode::While { guard, body, .. } => {
                self.need_all(guard, &EscapeUse::Other);
                self.rule(body);
            }
            RuleNode::Local { run, initial, body } => {
                self.variable(*run, Denotation::any());
                for rule in initial {
                    self.rule(rule);
                }
                self.rule(body);
            }
            RuleNode::Draw(drawn, body) => {
                for (local, ..) in drawn {
                    self.variable(*local, Denotation::any());
                }
                self.rule(body);
            }
            RuleNode::Act(_, arguments) => self.need_all(arguments, &EscapeUse::Sent),
        }
    }

    fn binding(&mut self, binders: &[Binder], guard: Option<&Term>, body: &Rule) {
        self.bind_all(binders);
        self.need_all(guard, &EscapeUse::Other);
        self.rule(body);
    }

    fn assign(&mut self, target: &AssignTarget, flow: Denotation, origin: Origin) {
        match target {
            AssignTarget::Local(local) => self.variable(*local, flow),
            AssignTarget::Slot(function, _) => self.store(*function, flow, origin),
            AssignTarget::Location(function, arguments) => {
                self.need_all(arguments, &EscapeUse::Argument(*function));
                self.store(*function, flow, origin);
            }
        }
    }

    /// Any rule that is a value can be executed, with any arguments.
    fn rules_as_values(&mut self) {
        for rule in &self.program.rules {
            if let Some(routine) = rule.routine {
                self.open(Frame::Routine(routine));
            }
            for body in &rule.arguments {
                self.open(Frame::Body(*body));
                let flow = self.at(Point::Result(*body));
                let origin = self.program.bodies.get(body.0 as usize);
                let origin = origin.map_or(Origin::default(), |body| body.origin);
                self.escape(&flow, origin, &EscapeUse::Other);
            }
        }
    }
}
