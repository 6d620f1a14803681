//! Rules lowered. Macro arguments that must be passed by name are built into a copy of the macro;
//! all others are passed by value.

use super::{Lowering, domain, facts};
use crate::code::{Kind, Node, Rule, RuleNode, Term};
use crate::program::{Local, Origin, RoutineId};
use hir::{RuleKind, RuleTerm, TermKind, VarId};
use source::{Diagnostic, Span};
use std::collections::BTreeSet;
use std::rc::Rc;
use value::{RuleId, Value};

/// Macros may be built into each other this deep.
const MAX_DEPTH: usize = 64;

/// Terms may nest this deep, those passed by name included; in the text they nest less.
const MAX_NESTING: usize = 1200;

/// Terms passed by name may be written out this often, in a whole program.
const MAX_EXPANSIONS: usize = 1 << 20;

/// A rule, and for each parameter what is built in for it; `None` for one passed by value.
pub(super) type Special = (RuleId, Vec<Option<String>>);

/// What a variable stands for.
#[derive(Clone, Debug)]
pub(super) enum Binding {
    /// A local of the frame.
    Local(Local),
    /// A term passed by name.
    Term(Rc<Closed>),
}

/// A term passed by name, with what its variables stand for.
#[derive(Debug)]
pub(super) struct Closed {
    pub term: hir::Term,
    bindings: Vec<Option<Binding>>,
    /// Equal keys, equal terms.
    key: String,
}

/// The variables of a body while it is lowered.
#[derive(Debug)]
pub(super) struct Frame {
    bindings: Vec<Option<Binding>>,
    /// How many locals are in use.
    pub locals: u32,
}

impl Frame {
    /// A frame whose first variables are its arguments.
    pub fn of(arguments: usize, variables: usize) -> Self {
        let bindings = (0..variables)
            .map(|index| (index < arguments).then_some(Binding::Local(index as Local)))
            .collect();
        Self {
            bindings,
            locals: arguments as u32,
        }
    }

    pub fn binding(&self, variable: VarId) -> Option<Binding> {
        self.bindings.get(variable.0 as usize).cloned().flatten()
    }

    /// A local without a variable.
    pub fn fresh(&mut self) -> Local {
        self.locals += 1;
        self.locals - 1
    }

    /// Gives a variable a local.
    pub fn bind(&mut self, variable: VarId) -> Local {
        let local = self.fresh();
        let index = variable.0 as usize;
        if self.bindings.len() <= index {
            self.bindings.resize(index + 1, None);
        }
        self.bindings[index] = Some(Binding::Local(local));
        local
    }

    /// Works with the variables of a term passed by name, in this frame.
    pub fn within<T>(&mut self, closed: &Closed, work: impl FnOnce(&mut Self) -> T) -> T {
        let outer = std::mem::replace(&mut self.bindings, closed.bindings.clone());
        let result = work(self);
        self.bindings = outer;
        result
    }
}

impl Lowering<'_> {
    /// A rule with all arguments passed by value: the main rule, turbo rules, rule values.
    pub(super) fn routine_by_value(&mut self, rule: RuleId) -> RoutineId {
        let parameters = self.model.rule(rule).parameters.len();
        self.routine(rule, vec![None; parameters], 0)
    }

    /// The routine of a rule for these by-name arguments, whose variables are `extras` more
    /// arguments after those passed by value.
    fn routine(
        &mut self,
        rule: RuleId,
        by_name: Vec<Option<Rc<Closed>>>,
        extras: u32,
    ) -> RoutineId {
        let keys = by_name
            .iter()
            .map(|closed| closed.as_ref().map(|closed| closed.key.clone()))
            .collect();
        let special = (rule, keys);
        if let Some(&known) = self.routines.get(&special) {
            return known;
        }
        let declared = self.model.rule(rule);
        let id = self.reserve_routine(declared);
        self.routines.insert(special, id);
        let Some(body) = &declared.body else {
            return id;
        };
        if self.depth >= MAX_DEPTH {
            let finding = Diagnostic::error(
                "A031",
                format!("`{}` calls itself with ever other terms", declared.name),
            )
            .label(
                declared.span,
                "this macro takes a term by name that grows with each call",
            );
            self.grows(finding);
            return id;
        }
        let mut frame = Frame::of(0, body.variables.len());
        for (index, closed) in by_name.into_iter().enumerate() {
            match closed {
                None => {
                    frame.bind(VarId(index as u32));
                }
                Some(closed) => frame.bindings[index] = Some(Binding::Term(closed)),
            }
        }
        frame.locals += extras;
        let arguments = frame.locals;
        self.depth += 1;
        let code = self.rule(&body.root, &mut frame);
        self.depth -= 1;
        let routine = &mut self.program.routines[id.0 as usize];
        routine.arguments = arguments;
        routine.locals = frame.locals;
        routine.code = code;
        id
    }

    /// A rule that is not declared.
    pub(super) fn added_routine(&mut self, body: &hir::Body<RuleTerm>) -> RoutineId {
        let id = self.reserve_routine_at(body.root.span, false);
        let mut frame = Frame::of(0, body.variables.len());
        let code = self.rule(&body.root, &mut frame);
        let routine = &mut self.program.routines[id.0 as usize];
        routine.locals = frame.locals;
        routine.code = code;
        id
    }

    /// A term passed by name, where its parameter stands.
    pub(super) fn by_name(&mut self, closed: &Closed, frame: &mut Frame, origin: Origin) -> Term {
        self.expansions += 1;
        if self.nesting <= MAX_NESTING && self.expansions <= MAX_EXPANSIONS {
            frame.within(closed, |frame| self.term(&closed.term, frame))
        } else {
            let finding = Diagnostic::error("A031", "a term passed by name becomes too large")
                .label(closed.term.span, "passed on by one macro after the other");
            self.grows(finding);
            Term::undef(origin)
        }
    }

    /// Reports macros whose terms grow, once.
    fn grows(&mut self, finding: Diagnostic) {
        if !self.has_grown {
            let help = "make the macro a `turbo rule`, which takes values, or bind the value with `let` before the call";
            self.report.push(finding.help(help));
        }
        self.has_grown = true;
    }

    /// A call: which arguments are passed by name is decided here.
    fn call(
        &mut self,
        rule: RuleId,
        arguments: &[hir::Term],
        frame: &mut Frame,
        span: Span,
    ) -> RuleNode {
        let mut values = Vec::new();
        let mut by_name = Vec::new();
        let mut extras: Vec<Local> = Vec::new();
        let turbo = self.model.rule(rule).turbo;
        let named: Vec<Option<(hir::Term, Vec<Option<Binding>>)>> = arguments
            .iter()
            .enumerate()
            .map(|(index, argument)| {
                let (term, bindings) = match self.variable_term(argument, frame) {
                    Some(closed) => (closed.term.clone(), closed.bindings.clone()),
                    None => (argument.clone(), frame.bindings.clone()),
                };
                (!turbo && self.is_by_name(rule, index, &term, &bindings))
                    .then_some((term, bindings))
            })
            .collect();
        let value_count = named.iter().filter(|named| named.is_none()).count() as u32;
        for (index, (argument, named)) in arguments.iter().zip(named).enumerate() {
            match named {
                None => {
                    values.push(self.term(argument, frame));
                    by_name.push(None);
                }
                Some((term, bindings)) => {
                    if self.facts.assigns(rule, index) && !is_location(self.model, &term) {
                        self.not_a_location(rule, index, argument.span);
                    }
                    by_name.push(Some(Rc::new(close(
                        &term,
                        &bindings,
                        &mut extras,
                        value_count,
                    ))));
                }
            }
        }
        let origin = self.origin(span);
        let extra_count = extras.len() as u32;
        values.extend(extras.into_iter().map(|local| Term {
            node: Box::new(Node::Local(local)),
            kind: Kind::Other,
            origin,
        }));
        RuleNode::Call(self.routine(rule, by_name, extra_count), values)
    }

    /// What a variable passed by name stands for, if the term is one.
    fn variable_term(&self, term: &hir::Term, frame: &Frame) -> Option<Rc<Closed>> {
        match &*term.kind {
            TermKind::Variable(variable) => match frame.binding(*variable) {
                Some(Binding::Term(closed)) => Some(closed),
                Some(Binding::Local(_)) | None => None,
            },
            _ => None,
        }
    }

    /// By name and by value differ only if the macro writes the parameter, or reads it again after a
    /// state in between.
    fn is_by_name(
        &self,
        rule: RuleId,
        parameter: usize,
        argument: &hir::Term,
        bindings: &[Option<Binding>],
    ) -> bool {
        let holds_name = || {
            let mut found = false;
            facts::visit(argument, &mut |term| {
                if let TermKind::Variable(variable) = &*term.kind {
                    found |= matches!(
                        bindings.get(variable.0 as usize),
                        Some(Some(Binding::Term(_)))
                    );
                }
            });
            found
        };
        self.facts.assigns(rule, parameter)
            || (self.facts.is_sequential(rule) && (self.facts.is_dynamic(argument) || holds_name()))
    }

    fn not_a_location(&mut self, rule: RuleId, parameter: usize, span: Span) {
        let declared = self.model.rule(rule);
        let name = declared.body.as_ref().map_or_else(String::new, |body| {
            body.variables[parameter].name.to_string()
        });
        self.report.push(
            Diagnostic::error(
                "A032",
                format!(
                    "`{}` updates its parameter `{name}`, so it needs a location",
                    declared.name
                ),
            )
            .label(span, "this is a value")
            .label(declared.span, "declared here")
            .help("pass a controlled function, applied to its arguments"),
        );
    }

    /// A rule in a frame.
    pub(super) fn rule(&mut self, rule: &RuleTerm, frame: &mut Frame) -> Rule {
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

    fn or_skip(&mut self, rule: Option<&RuleTerm>, span: Span, frame: &mut Frame) -> Rule {
        match rule {
            Some(rule) => self.rule(rule, frame),
            None => self.skip(span),
        }
    }

    fn rule_node(&mut self, rule: &RuleTerm, frame: &mut Frame) -> RuleNode {
        let span = rule.span;
        match &*rule.kind {
            RuleKind::Skip | RuleKind::Invalid => RuleNode::Skip,
            RuleKind::Update(target, value) => {
                let value = self.term(value, frame);
                match self.place(target, frame) {
                    Some(place) => RuleNode::Update(place, value),
                    None => RuleNode::Skip,
                }
            }
            RuleKind::Assign(target, callee, arguments) => {
                let arguments = self.terms(arguments, frame);
                let routine = self.routine_by_value(*callee);
                match self.place(target, frame) {
                    Some(place) => RuleNode::Assign(Some(place), routine, arguments),
                    None => RuleNode::Skip,
                }
            }
            RuleKind::Call(callee, arguments) if self.model.rule(*callee).result.is_some() => {
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
                let binders = self.binders(binders, frame);
                let guard = self.guard(guard.as_ref(), frame);
                let body = self.rule(body, frame);
                RuleNode::Choose(
                    binders,
                    guard,
                    body,
                    self.or_skip(ifnone.as_ref(), span, frame),
                )
            }
            RuleKind::Forall(binders, guard, body) => {
                let binders = self.binders(binders, frame);
                let guard = self.guard(guard.as_ref(), frame);
                RuleNode::Forall(binders, guard, self.rule(body, frame))
            }
            RuleKind::Let(bindings, body) => {
                let bindings = self.bindings(bindings, frame);
                RuleNode::Let(bindings, self.rule(body, frame))
            }
            RuleKind::Extend(extended, variables, body) => {
                let locals = variables
                    .iter()
                    .map(|&variable| frame.bind(variable))
                    .collect();
                RuleNode::Extend(domain::id(*extended), locals, self.rule(body, frame))
            }
            RuleKind::While(guard, body) => {
                let guard = self.term(guard, frame);
                RuleNode::While(guard, self.rule(body, frame))
            }
            RuleKind::Unsupported(what) => {
                self.unsupported(&format!("`{what}`"), span);
                RuleNode::Skip
            }
        }
    }

    fn block(&mut self, rules: &[RuleTerm], frame: &mut Frame) -> Vec<Rule> {
        rules.iter().map(|rule| self.rule(rule, frame)).collect()
    }

    fn run(&mut self, term: &hir::Term, arguments: &[hir::Term], frame: &mut Frame) -> RuleNode {
        let arguments = self.terms(arguments, frame);
        let term = self.term(term, frame);
        match *term.node {
            Node::Program(agent) => RuleNode::RunAgent(agent, arguments),
            Node::Constant(Value::Undef) => RuleNode::Skip,
            node => RuleNode::Run(
                Term {
                    node: Box::new(node),
                    ..term
                },
                arguments,
            ),
        }
    }
}

/// Whether a term is a location that rules may write.
fn is_location(model: &hir::Model, term: &hir::Term) -> bool {
    match &*term.kind {
        TermKind::Apply(function, _) | TermKind::Spread(function, _) => matches!(
            model.function(*function).kind,
            hir::FunctionKind::Controlled | hir::FunctionKind::Out | hir::FunctionKind::Shared
        ),
        _ => false,
    }
}

/// Closes a term over the locals its variables stand for: they become further arguments of the
/// macro, numbered from `base` on.
fn close(
    term: &hir::Term,
    bindings: &[Option<Binding>],
    extras: &mut Vec<Local>,
    base: u32,
) -> Closed {
    let mut variables = BTreeSet::new();
    facts::visit(term, &mut |term| {
        if let TermKind::Variable(variable) = &*term.kind {
            variables.insert(variable.0 as usize);
        }
    });
    let mut closed: Vec<Option<Binding>> = vec![None; bindings.len()];
    let mut key = format!("{:?}", term.span);
    for index in variables {
        let Some(Some(binding)) = bindings.get(index) else {
            continue;
        };
        let rebound = match binding {
            Binding::Local(local) => {
                extras.push(*local);
                let local = base + extras.len() as u32 - 1;
                key.push_str(&format!(" {index}={local}"));
                Binding::Local(local)
            }
            Binding::Term(inner) => {
                let inner = close(&inner.term, &inner.bindings, extras, base);
                key.push_str(&format!(" {index}=({})", inner.key));
                Binding::Term(Rc::new(inner))
            }
        };
        closed[index] = Some(rebound);
    }
    Closed {
        term: term.clone(),
        bindings: closed,
        key,
    }
}
