//! Lowering of terms: operators become nodes, and locations become slots where possible.

use super::frame::{LoweringFrame, VariableBinding};
use super::rule::at;
use super::{Lowering, constant, domain, function_id};
use crate::code::{
    Arithmetic, AssignTarget, Binder, BinderRange, Comparison, Connective, Term, TermNode,
    ValueKind,
};
use crate::id::{FunctionId, Local, Origin, Slot};
use crate::program::Storage;
use asmotion_hir::{Meaning, TermKind, Type, TypeId};
use asmotion_value::Value;

impl Term {
    /// Creates a term for the value of a local.
    pub(super) fn local(local: Local, origin: Origin) -> Self {
        Self {
            node: Box::new(TermNode::Local(local)),
            kind: ValueKind::Other,
            origin,
        }
    }

    /// Creates a term for `undef`.
    pub(super) fn undef(origin: Origin) -> Self {
        Self {
            node: Box::new(TermNode::Constant(Value::Undef)),
            kind: ValueKind::Other,
            origin,
        }
    }
}

impl Lowering<'_> {
    pub(super) fn kind(&self, ty: TypeId) -> ValueKind {
        let root = self.model.types.root(ty, &self.model.domains);
        match self.model.types.get(root) {
            Type::Boolean => ValueKind::Bool,
            Type::Integer | Type::Natural => ValueKind::Int,
            Type::Real => ValueKind::Real,
            Type::Domain(domain) => match self.model.domain(*domain).kind {
                asmotion_hir::DomainKind::Enum { .. } | asmotion_hir::DomainKind::Abstract => {
                    ValueKind::Atom
                }
                asmotion_hir::DomainKind::Any
                | asmotion_hir::DomainKind::Basic
                | asmotion_hir::DomainKind::Concrete { .. } => ValueKind::Other,
            },
            Type::Invalid
            | Type::Undef
            | Type::Complex
            | Type::Char
            | Type::String
            | Type::Rule
            | Type::Prod(_)
            | Type::Seq(_)
            | Type::Powerset(_)
            | Type::Bag(_)
            | Type::Map(..) => ValueKind::Other,
        }
    }

    pub(super) fn terms(
        &mut self,
        terms: &[asmotion_hir::Term],
        frame: &mut LoweringFrame,
    ) -> Vec<Term> {
        terms.iter().map(|term| self.term(term, frame)).collect()
    }

    fn optional(
        &mut self,
        term: Option<&asmotion_hir::Term>,
        frame: &mut LoweringFrame,
    ) -> Option<Term> {
        term.map(|term| self.term(term, frame))
    }

    pub(super) fn term(&mut self, term: &asmotion_hir::Term, frame: &mut LoweringFrame) -> Term {
        self.nesting += 1;
        let lowered = stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term, frame));
        self.nesting -= 1;
        lowered
    }

    fn term_here(&mut self, term: &asmotion_hir::Term, frame: &mut LoweringFrame) -> Term {
        let origin = self.origin(term.span);
        let kind = self.kind(term.ty);
        let node = match &*term.kind {
            TermKind::Value(value) => TermNode::Constant(value.clone()),
            TermKind::Variable(variable) => match frame.binding(*variable) {
                Some(VariableBinding::Local(local)) => TermNode::Local(local),
                Some(VariableBinding::Term(closed)) => return self.by_name(&closed, frame, origin),
                Some(VariableBinding::State { run, index }) => {
                    TermNode::Location(self.program.variables, at(run, index, origin))
                }
                None => TermNode::Constant(Value::Undef),
            },
            TermKind::Apply(function, arguments) => {
                let arguments = self.terms(arguments, frame);
                self.apply(*function, arguments, origin)
            }
            TermKind::Spread(function, tuple) => {
                return self.apply_to_tuple(*function, tuple, frame, term);
            }
            TermKind::Tuple(items) => TermNode::Tuple(self.terms(items, frame)),
            TermKind::If(guard, then, otherwise) => {
                let guard = self.term(guard, frame);
                let then = self.term(then, frame);
                let otherwise = self.optional(otherwise.as_ref(), frame);
                TermNode::If(guard, then, otherwise.unwrap_or(Term::undef(origin)))
            }
            TermKind::Switch(subject, cases, otherwise) => {
                let subject = self.term(subject, frame);
                let mut lowered = Vec::new();
                for (case, value) in cases {
                    let case = self.term(case, frame);
                    lowered.push((case, self.term(value, frame)));
                }
                let otherwise = self.optional(otherwise.as_ref(), frame);
                TermNode::Switch(subject, lowered, otherwise.unwrap_or(Term::undef(origin)))
            }
            TermKind::Let(bindings, body) => {
                let bindings = self.bindings(bindings, frame);
                TermNode::Let(bindings, self.term(body, frame))
            }
            TermKind::Quantified(quantifier, binders, guard) => {
                let binders = self.binders(binders, frame);
                let guard = self.optional(guard.as_ref(), frame);
                TermNode::Quantified(*quantifier, binders, guard)
            }
            TermKind::Listed(collection, items) => {
                let items = self.terms(items, frame);
                match constant::listed(*collection, &items) {
                    Some(value) => TermNode::Constant(value),
                    None => TermNode::Listed(*collection, items),
                }
            }
            TermKind::Interval(collection, from, to, step) => {
                let from = self.term(from, frame);
                let to = self.term(to, frame);
                let step = self.optional(step.as_ref(), frame);
                TermNode::Interval(*collection, from, to, step)
            }
            TermKind::Comprehension(collection, binders, guard, item) => {
                let binders = self.binders(binders, frame);
                let guard = self.optional(guard.as_ref(), frame);
                TermNode::Collect(*collection, binders, guard, self.term(item, frame))
            }
            TermKind::Map(pairs) => {
                let mut lowered = Vec::new();
                for (key, value) in pairs {
                    let key = self.term(key, frame);
                    lowered.push((key, self.term(value, frame)));
                }
                match constant::map(&lowered) {
                    Some(value) => TermNode::Constant(value),
                    None => TermNode::Map(lowered),
                }
            }
            TermKind::MapComprehension(binders, guard, key, value) => {
                let binders = self.binders(binders, frame);
                let guard = self.optional(guard.as_ref(), frame);
                let key = self.term(key, frame);
                TermNode::CollectMap(binders, guard, key, self.term(value, frame))
            }
            TermKind::Rule(rule) => TermNode::Constant(Value::Rule(*rule)),
            TermKind::Extent(ty) => TermNode::Extent(self.shape(*ty)),
            TermKind::Element(id, name) => {
                let name = Term {
                    node: Box::new(TermNode::Constant(Value::text(&**name))),
                    kind: ValueKind::Other,
                    origin,
                };
                TermNode::Named(domain::id(*id), name)
            }
            TermKind::Unbound => TermNode::Unbound,
            TermKind::Invalid => TermNode::Constant(Value::Undef),
        };
        Term {
            node: Box::new(node),
            kind,
            origin,
        }
    }

    pub(super) fn bindings(
        &mut self,
        bindings: &[(asmotion_hir::VarId, asmotion_hir::Term)],
        frame: &mut LoweringFrame,
    ) -> Vec<(Local, Term)> {
        let mut bound = Vec::new();
        for (variable, term) in bindings {
            let term = self.term(term, frame);
            bound.push((frame.bind(*variable), term));
        }
        bound
    }

    pub(super) fn binders(
        &mut self,
        binders: &[asmotion_hir::Binder],
        frame: &mut LoweringFrame,
    ) -> Vec<Binder> {
        let mut bound = Vec::new();
        for binder in binders {
            let origin = self.origin(binder.range.span);
            let extent = if let TermKind::Extent(ty) = &*binder.range.kind {
                Some(self.model.types.get(*ty))
            } else {
                None
            };
            let range = match extent {
                Some(Type::Boolean) => BinderRange::Bools,
                Some(Type::Domain(domain)) => self.range(*domain),
                Some(_) | None => BinderRange::Elements(self.term(&binder.range, frame)),
            };
            bound.push(Binder {
                local: frame.bind(binder.variable),
                range,
                origin,
            });
        }
        bound
    }

    /// Lowers the application of a function to lowered arguments.
    fn apply(
        &mut self,
        function: asmotion_hir::FunctionId,
        arguments: Vec<Term>,
        origin: Origin,
    ) -> TermNode {
        let reserved = self.model.reserved;
        if reserved.self_ == Some(function) {
            return TermNode::Agent;
        }
        let declared = self.model.function(function);
        match &declared.meaning {
            Meaning::State => self.location(function_id(function), arguments),
            Meaning::Machine if reserved.result == Some(function) => {
                self.location(function_id(function), arguments)
            }
            Meaning::Machine if reserved.program == Some(function) => {
                match arguments.into_iter().next() {
                    Some(agent) => TermNode::Program(agent),
                    None => TermNode::Constant(Value::Undef),
                }
            }
            Meaning::Machine => self.name(declared, arguments),
            Meaning::Constant(atom) => TermNode::Constant(Value::Atom(*atom)),
            Meaning::Missing => TermNode::Constant(Value::Undef),
            Meaning::Builtin(builtin) => self.builtin(builtin, arguments, origin),
            Meaning::Defined(body) => {
                if let (TermKind::Value(value), true) = (&*body.root.kind, arguments.is_empty()) {
                    return TermNode::Constant(value.clone());
                }
                let Some(&id) = self.definitions.get(&function) else {
                    return TermNode::Constant(Value::Undef);
                };
                match self.caches.get(&function) {
                    Some(&cache) => {
                        let kind = self.kind(declared.codomain);
                        TermNode::Cached(
                            cache,
                            Term {
                                node: Box::new(TermNode::Call(id, arguments)),
                                kind,
                                origin,
                            },
                        )
                    }
                    None => TermNode::Call(id, arguments),
                }
            }
        }
    }

    /// Lowers `id(a)` and `getAgent("a")`, which convert between an element and its name.
    fn name(&mut self, declared: &asmotion_hir::Function, arguments: Vec<Term>) -> TermNode {
        let Some(argument) = arguments.into_iter().next() else {
            return TermNode::Constant(Value::Undef);
        };
        match self.model.types.get(declared.codomain).as_domain() {
            Some(agents) => TermNode::Named(domain::id(agents), argument),
            None => TermNode::Name(argument),
        }
    }

    /// Lowers `f(t)` where the single term is the tuple of all arguments.
    fn apply_to_tuple(
        &mut self,
        function: asmotion_hir::FunctionId,
        tuple: &asmotion_hir::Term,
        frame: &mut LoweringFrame,
        term: &asmotion_hir::Term,
    ) -> Term {
        let origin = self.origin(term.span);
        let kind = self.kind(term.ty);
        let (bindings, arguments) = self.components(function, tuple, frame);
        let node = self.apply(function, arguments, origin);
        let applied = Term {
            node: Box::new(node),
            kind,
            origin,
        };
        Term {
            node: Box::new(TermNode::Let(bindings, applied)),
            kind,
            origin,
        }
    }

    /// Binds a tuple to a variable and returns its components as the arguments of a function.
    fn components(
        &mut self,
        function: asmotion_hir::FunctionId,
        tuple: &asmotion_hir::Term,
        frame: &mut LoweringFrame,
    ) -> (Vec<(Local, Term)>, Vec<Term>) {
        let lowered = self.term(tuple, frame);
        let origin = lowered.origin;
        let local = frame.fresh();
        let parameters = self.model.function(function).parameters.clone();
        let components = parameters
            .iter()
            .enumerate()
            .map(|(index, &ty)| {
                let tuple = Term {
                    node: Box::new(TermNode::Local(local)),
                    kind: ValueKind::Other,
                    origin,
                };
                let node = TermNode::Component(tuple, index as u32);
                Term {
                    node: Box::new(node),
                    kind: self.kind(ty),
                    origin,
                }
            })
            .collect();
        (vec![(local, lowered)], components)
    }

    /// Lowers a location: to a slot if its arguments are constants on their axes.
    fn location(&mut self, function: FunctionId, arguments: Vec<Term>) -> TermNode {
        match self.slot(function, &arguments) {
            Some(slot) => TermNode::Slot(function, slot),
            None => TermNode::Location(function, arguments),
        }
    }

    fn slot(&self, function: FunctionId, arguments: &[Term]) -> Option<Slot> {
        let Storage::Dense {
            base,
            axes,
            lazy: false,
            ..
        } = &self.program.functions[function.0 as usize].storage
        else {
            return None;
        };
        let mut slot = *base;
        for (axis, argument) in axes.iter().zip(arguments) {
            let TermNode::Constant(value) = &*argument.node else {
                return None;
            };
            slot += axis.over.index(value)? * axis.stride;
        }
        Some(slot)
    }

    /// Lowers the left-hand side of an update; returns `None` after an error.
    pub(super) fn assign_target(
        &mut self,
        target: &asmotion_hir::UpdateTarget,
        frame: &mut LoweringFrame,
    ) -> Option<AssignTarget> {
        match target {
            asmotion_hir::UpdateTarget::Location(function, arguments) => {
                let expected = self.model.function(*function).parameters.len();
                let arguments = match arguments.as_slice() {
                    // `f(t) := …` with a single tuple of all arguments
                    [tuple] if expected > 1 => self.literal_components(*function, tuple, frame)?,
                    arguments => self.terms(arguments, frame),
                };
                let node = self.location(function_id(*function), arguments);
                if let TermNode::Slot(function, slot) = node {
                    Some(AssignTarget::Slot(function, slot))
                } else if let TermNode::Location(function, arguments) = node {
                    Some(AssignTarget::Location(function, arguments))
                } else {
                    None
                }
            }
            asmotion_hir::UpdateTarget::Variable(variable) => {
                if let (Some(VariableBinding::Local(local)), true) =
                    (frame.binding(*variable), self.model.compatible)
                {
                    return Some(AssignTarget::Local(local));
                }
                if let Some(VariableBinding::State { run, index }) = frame.binding(*variable) {
                    let origin = Origin::default();
                    return Some(AssignTarget::Location(
                        self.program.variables,
                        at(run, index, origin),
                    ));
                }
                if let Some(VariableBinding::Term(closed)) = frame.binding(*variable) {
                    let target = if let TermKind::Variable(variable) = &*closed.term.kind {
                        Some(asmotion_hir::UpdateTarget::Variable(*variable))
                    } else {
                        let application = closed.term.kind.clone().into_application();
                        application.map(|(function, arguments)| {
                            asmotion_hir::UpdateTarget::Location(function, arguments)
                        })
                    };
                    if let Some(target) = target {
                        return frame.within(&closed, |frame| self.assign_target(&target, frame));
                    }
                }
                None
            }
        }
    }

    fn literal_components(
        &mut self,
        function: asmotion_hir::FunctionId,
        tuple: &asmotion_hir::Term,
        frame: &mut LoweringFrame,
    ) -> Option<Vec<Term>> {
        if let TermKind::Tuple(items) = &*tuple.kind {
            return Some(self.terms(items, frame));
        }
        let (bindings, components) = self.components(function, tuple, frame);
        let (_, tuple) = bindings.into_iter().next()?;
        // each component evaluates the tuple again, which gives the same value within a step
        Some(
            components
                .into_iter()
                .map(|mut component| {
                    if let TermNode::Component(whole, _) = &mut *component.node {
                        whole.clone_from(&tuple);
                    }
                    component
                })
                .collect(),
        )
    }

    /// Lowers the application of a library function; the operators of the machine become nodes.
    fn builtin(
        &mut self,
        builtin: &'static asmotion_stdlib::Builtin,
        arguments: Vec<Term>,
        origin: Origin,
    ) -> TermNode {
        let integers = !arguments.is_empty()
            && arguments
                .iter()
                .all(|argument| argument.kind == ValueKind::Int);
        let truths = !arguments.is_empty()
            && arguments
                .iter()
                .all(|argument| argument.kind == ValueKind::Bool);
        let mut operands = arguments.iter().cloned();
        if let (Some(left), Some(right), None) = (operands.next(), operands.next(), operands.next())
        {
            if let Some(logic) = logic(builtin.name).filter(|_| {
                // the reference always evaluates both operands
                builtin.domain == "Prod(Boolean,Boolean)" && !self.model.compatible
            }) {
                return TermNode::Logic(logic, left, right);
            }
            if let Some(comparison) = comparison(builtin.name).filter(|_| integers) {
                return TermNode::Compare(comparison, left, right);
            }
            if let Some(arithmetic) =
                arithmetic(builtin.name).filter(|_| integers && !self.model.compatible)
            {
                return TermNode::Arithmetic(arithmetic, left, right);
            }
            // numbers of different domains compare by numeric value, which needs a conversion by
            // the library
            let mixed = left.kind != right.kind && builtin.domain.contains("Real");
            if builtin.name == "eq" && !mixed {
                return TermNode::Equal(left, right);
            }
            if builtin.name == "neq" && !mixed {
                let equal = TermNode::Equal(left, right);
                return TermNode::Not(Term {
                    node: Box::new(equal),
                    kind: ValueKind::Bool,
                    origin,
                });
            }
        }
        if builtin.name == "not" && truths {
            if let Some(operand) = arguments.into_iter().next() {
                return TermNode::Not(operand);
            }
            return TermNode::Constant(Value::Undef);
        }
        if let ("pre", [term]) = (builtin.name, arguments.as_slice()) {
            return TermNode::Pre(term.clone());
        }
        TermNode::Builtin(builtin, arguments)
    }

    /// Lowers an optional guard; `None` also for a guard that is the constant `true`.
    pub(super) fn guard(
        &mut self,
        guard: Option<&asmotion_hir::Term>,
        frame: &mut LoweringFrame,
    ) -> Option<Term> {
        let guard = self.optional(guard, frame)?;
        let always = matches!(*guard.node, TermNode::Constant(Value::Bool(true)));
        (!always).then_some(guard)
    }
}

fn logic(name: &str) -> Option<Connective> {
    Some(match name {
        "and" => Connective::And,
        "or" => Connective::Or,
        "xor" => Connective::Xor,
        "implies" => Connective::Implies,
        "iff" => Connective::Iff,
        _ => return None,
    })
}

fn comparison(name: &str) -> Option<Comparison> {
    Some(match name {
        "lt" => Comparison::Lt,
        "le" => Comparison::Le,
        "gt" => Comparison::Gt,
        "ge" => Comparison::Ge,
        _ => return None,
    })
}

fn arithmetic(name: &str) -> Option<Arithmetic> {
    Some(match name {
        "plus" => Arithmetic::Plus,
        "minus" => Arithmetic::Minus,
        "mult" => Arithmetic::Mult,
        "mod" => Arithmetic::Mod,
        _ => return None,
    })
}
