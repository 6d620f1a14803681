//! Terms resolved and typed.

use crate::declare::Declared;
use crate::error::HirError;
use crate::model::{
    Binder, Body, DomainKind, FunctionId, Meaning, RuleTerm, Term, TermKind, VarId, Variable,
};
use crate::scope::similar;
use crate::types::{Bindings, Type, TypeId};
use source::Span;
use std::sync::Arc;
use syntax::ast::{self, Literal, Operator};
use value::{RuleId, Value};

/// Resolves one body: a rule, a definition, a condition.
pub(crate) struct Resolver<'a> {
    pub declared: &'a mut Declared,
    pub unit: usize,
    variables: Vec<Variable>,
    /// The variables that can be seen, innermost last.
    visible: Vec<VarId>,
    /// How many of the first variables are parameters that may stand for locations: a macro's.
    location_parameters: usize,
    /// The domain of the turbo rule's result, while one is being resolved.
    pub result: Option<TypeId>,
}

impl<'a> Resolver<'a> {
    pub fn new(declared: &'a mut Declared, unit: usize) -> Self {
        Self {
            declared,
            unit,
            variables: Vec::new(),
            visible: Vec::new(),
            location_parameters: 0,
            result: None,
        }
    }

    /// Says that the body is that of a macro, whose parameters may stand for locations.
    pub fn enter_macro(&mut self, parameters: usize) {
        self.location_parameters = parameters;
    }

    /// Says that the body is that of a turbo rule with such a result.
    pub fn enter_turbo(&mut self, result: Option<TypeId>) {
        self.result = result;
    }

    /// Whether a variable may stand for a location. Parameters are bound before anything else.
    pub fn stands_for_location(&self, id: VarId) -> bool {
        (id.0 as usize) < self.location_parameters
    }

    pub fn body<T>(self, parameters: usize, root: T) -> Body<T> {
        Body { parameters, variables: self.variables, root }
    }

    pub fn variables(&self) -> Vec<Variable> {
        self.variables.clone()
    }

    /// Binds a variable from here on.
    pub fn bind(&mut self, name: &ast::Name, ty: TypeId) -> VarId {
        let id = VarId(self.variables.len() as u32);
        self.variables.push(Variable { name: name.text.clone(), ty, span: name.span });
        self.visible.push(id);
        id
    }

    /// Does something with the variables it binds, and forgets them.
    pub fn scoped<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let depth = self.visible.len();
        let result = work(self);
        self.visible.truncate(depth);
        result
    }

    pub fn lookup(&self, name: &str) -> Option<VarId> {
        self.visible.iter().rev().copied().find(|id| &*self.variable(*id).name == name)
    }

    pub fn variable(&self, id: VarId) -> &Variable {
        &self.variables[id.0 as usize]
    }

    pub fn ty(&mut self, ty: Type) -> TypeId {
        self.declared.types.id(ty)
    }

    pub fn show(&self, ty: TypeId) -> String {
        self.declared.types.show(ty, &self.declared.domains)
    }

    pub fn error(&mut self, error: HirError) {
        self.declared.report.push(error.diagnostic());
    }

    pub fn compatible(&self, a: TypeId, b: TypeId) -> bool {
        self.declared.types.compatible(a, b, &self.declared.domains)
    }

    /// Reports a term whose type does not fit.
    pub fn expect(&mut self, term: &Term, wanted: TypeId, what: &str, because: Option<(Span, &'static str)>) {
        if self.compatible(wanted, term.ty) {
            return;
        }
        let number = self.written_as(term, wanted);
        let (wanted, actual) = (self.show(wanted), self.show(term.ty));
        self.error(HirError::Mismatch { what: what.to_owned(), wanted, actual, at: term.span, because, number });
    }

    /// How a number is written in another domain of numbers.
    fn written_as(&self, term: &Term, wanted: TypeId) -> Option<String> {
        let TermKind::Value(Value::Int(number)) = *term.kind else {
            return None;
        };
        let root = self.declared.types.root(wanted, &self.declared.domains);
        match self.declared.types.get(root) {
            Type::Integer => Some(number.to_string()),
            Type::Natural => Some(format!("{number}n")),
            Type::Real => Some(format!("{number}.0")),
            _ => None,
        }
    }

    pub fn boolean(&mut self, term: &ast::Term, what: &str) -> Term {
        let term = self.term(term);
        let boolean = self.ty(Type::Boolean);
        self.expect(&term, boolean, what, None);
        term
    }

    /// A term, resolved and typed.
    pub fn term(&mut self, term: &ast::Term) -> Term {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term))
    }

    fn term_here(&mut self, term: &ast::Term) -> Term {
        let span = term.span;
        match &*term.kind {
            ast::TermKind::Literal(literal) => self.literal(literal, span),
            ast::TermKind::Variable(name) => self.variable_term(name),
            ast::TermKind::Constant(name) => self.constant(name),
            ast::TermKind::Apply { name, arguments } => {
                let arguments = self.terms(arguments);
                self.apply(name, arguments, span)
            }
            ast::TermKind::Dot { agent, name, arguments } => self.dot(agent, name, arguments, span),
            ast::TermKind::Binary { operator, at, left, right } => {
                self.lint_not(*operator, left, term.span);
                let arguments = vec![self.term(left), self.term(right)];
                self.operator(*operator, *at, arguments, span)
            }
            ast::TermKind::Unary { operator, at, operand } => {
                let arguments = vec![self.term(operand)];
                self.operator(*operator, *at, arguments, span)
            }
            ast::TermKind::Tuple(items) => {
                let items = self.terms(items);
                let ty = Type::Prod(items.iter().map(|item| item.ty).collect());
                self.made(TermKind::Tuple(items), ty, span)
            }
            ast::TermKind::If { guard, then, otherwise } => {
                let guard = self.boolean(guard, "a guard");
                let then = self.term(then);
                let otherwise = otherwise.as_ref().map(|term| self.term(term));
                let ty = otherwise.as_ref().map_or(then.ty, |other| self.agree("the branches", &then, other));
                Term { kind: Box::new(TermKind::If(guard, then, otherwise)), ty, span }
            }
            ast::TermKind::Switch { subject, cases, otherwise } => {
                self.switch(subject, cases, otherwise.as_ref(), span)
            }
            ast::TermKind::Let { bindings, body } => self.scoped(|this| {
                let bindings = this.bindings(bindings);
                let body = this.term(body);
                let ty = body.ty;
                Term { kind: Box::new(TermKind::Let(bindings, body)), ty, span }
            }),
            ast::TermKind::Quantified { quantifier, binders, guard } => self.scoped(|this| {
                let binders = this.binders(binders);
                let guard = guard.as_ref().map(|guard| this.boolean(guard, "a guard"));
                this.made(TermKind::Quantified(*quantifier, binders, guard), Type::Boolean, span)
            }),
            ast::TermKind::Listed { collection, items } => {
                let items = self.terms(items);
                let item = self.element_type(&items);
                self.made(TermKind::Listed(*collection, items), of(*collection, item), span)
            }
            ast::TermKind::Interval { collection, interval } => self.interval(*collection, interval, span),
            ast::TermKind::Comprehension { collection, comprehension } => self.scoped(|this| {
                let (binders, guard, item) = this.comprehension(comprehension);
                let ty = of(*collection, item.ty);
                this.made(TermKind::Comprehension(*collection, binders, guard, item), ty, span)
            }),
            ast::TermKind::Map(pairs) => self.map(pairs, span),
            ast::TermKind::MapComprehension { comprehension, value } => self.scoped(|this| {
                let (binders, guard, key) = this.comprehension(comprehension);
                let value = this.term(value);
                let ty = Type::Map(key.ty, value.ty);
                this.made(TermKind::MapComprehension(binders, guard, key, value), ty, span)
            }),
            ast::TermKind::RuleRef { name, domains } => self.rule_ref(name, domains, span),
            ast::TermKind::Domain(domain) => {
                let ty = self.declared.resolve_type(self.unit, domain);
                self.made(TermKind::Extent(ty), Type::Powerset(ty), span)
            }
            ast::TermKind::Invalid => self.invalid(span),
        }
    }

    pub fn terms(&mut self, terms: &[ast::Term]) -> Vec<Term> {
        terms.iter().map(|term| self.term(term)).collect()
    }

    pub fn made(&mut self, kind: TermKind, ty: Type, span: Span) -> Term {
        Term { kind: Box::new(kind), ty: self.ty(ty), span }
    }

    fn invalid(&mut self, span: Span) -> Term {
        self.made(TermKind::Invalid, Type::Invalid, span)
    }

    fn literal(&mut self, literal: &Literal, span: Span) -> Term {
        let (value, ty) = match literal {
            Literal::Undef => (Value::Undef, Type::Undef),
            Literal::Bool(truth) => (Value::Bool(*truth), Type::Boolean),
            Literal::Integer(Some(number)) => (Value::Int(*number), Type::Integer),
            Literal::Natural(Some(number)) => (Value::Int(*number), Type::Natural),
            Literal::Integer(None) | Literal::Natural(None) => return self.invalid(span),
            Literal::Real(number) => (Value::real(*number), Type::Real),
            Literal::Complex(re, im) => {
                let number = (value::Real::new(*re), value::Real::new(*im));
                (Value::Complex(Arc::new(number)), Type::Complex)
            }
            Literal::Char(character) => (Value::Char(*character), Type::Char),
            Literal::Text(text) => (Value::text(&**text), Type::String),
        };
        self.made(TermKind::Value(value), ty, span)
    }

    fn variable_term(&mut self, name: &ast::Name) -> Term {
        let Some(id) = self.lookup(&name.text) else {
            self.unknown_variable(name);
            return self.invalid(name.span);
        };
        let ty = self.variable(id).ty;
        Term { kind: Box::new(TermKind::Variable(id)), ty, span: name.span }
    }

    pub fn unknown_variable(&mut self, name: &ast::Name) {
        let bound = self.variables.iter().rev().find(|known| known.name == name.text).map(|known| known.span);
        let similar = similar(&name.text, self.visible.iter().map(|id| &self.variable(*id).name));
        self.error(HirError::UnknownVariable { name: name.text.clone(), at: name.span, similar, bound });
    }

    /// An enumeration literal, or a domain as the set of its elements.
    fn constant(&mut self, name: &ast::Name) -> Term {
        let scope = &self.declared.scopes[self.unit];
        if let Some(&atom) = scope.literals.get(&name.text).and_then(|atoms| atoms.last()) {
            let domain = self.declared.atoms[atom.0 as usize].domain;
            return self.made(TermKind::Value(Value::Atom(atom)), Type::Domain(domain), name.span);
        }
        if scope.domains.contains_key(&name.text) || Type::basic(&name.text).is_some() {
            let domain = ast::Type { kind: ast::TypeKind::Named(name.text.clone()), span: name.span };
            let ty = self.declared.resolve_type(self.unit, &domain);
            return self.made(TermKind::Extent(ty), Type::Powerset(ty), name.span);
        }
        let similar = scope.similar_constant(&name.text);
        self.error(HirError::UnknownConstant { name: name.text.clone(), at: name.span, similar });
        self.invalid(name.span)
    }

    /// `self.f(t)` is `f(self, t)`, `a.f(t)` is `f(a, t)`.
    fn dot(&mut self, agent: &ast::Name, name: &ast::Name, arguments: &[ast::Term], span: Span) -> Term {
        let agent = self.apply(agent, Vec::new(), agent.span);
        let mut all = vec![agent];
        all.extend(self.terms(arguments));
        self.apply(name, all, span)
    }

    fn operator(&mut self, operator: Operator, at: Span, arguments: Vec<Term>, span: Span) -> Term {
        let name = ast::Name { text: Arc::from(operator.function()), span: at };
        let candidates = self.candidates(&name);
        if candidates.is_empty() {
            let types: Vec<String> = arguments.iter().map(|term| self.show(term.ty)).collect();
            self.error(HirError::NoOverload {
                name: Arc::from(operator.symbol()),
                at,
                actual: types.join(" and "),
                candidates: Vec::new(),
                hint: Some("operators come with `import StandardLibrary`".to_owned()),
            });
            return self.invalid(span);
        }
        self.best(operator.symbol(), &name, &candidates, arguments, span)
    }

    /// The functions of this name.
    fn candidates(&self, name: &ast::Name) -> Vec<FunctionId> {
        self.declared.scopes[self.unit].functions.get(&name.text).cloned().unwrap_or_default()
    }

    fn lint_not(&mut self, operator: Operator, left: &ast::Term, whole: Span) {
        let comparison = matches!(
            operator,
            Operator::Eq | Operator::Neq | Operator::Lt | Operator::Le | Operator::Gt | Operator::Ge
        );
        if !comparison {
            return;
        }
        if let ast::TermKind::Unary { operator: Operator::Not, at, operand } = &*left.kind {
            // `(not a) = b` in brackets says what it means; its span begins before the `not`.
            if left.span.start == at.start && whole.start == at.start {
                let _ = operand;
                self.error(HirError::NotBinds { operator: operator.symbol(), at: *at, operand: whole });
            }
        }
    }

    /// The best overload of a function for these arguments.
    pub fn apply(&mut self, name: &ast::Name, arguments: Vec<Term>, span: Span) -> Term {
        let candidates = self.candidates(name);
        if candidates.is_empty() {
            let scope = &self.declared.scopes[self.unit];
            let similar = scope.similar_function(&name.text).map(|found| {
                let declared = scope.functions.get(&found).and_then(|ids| ids.first());
                let span = declared.map_or_else(Span::default, |id| self.declared.functions[id.0 as usize].span);
                (found, span)
            });
            self.error(HirError::UnknownFunction { name: name.text.clone(), at: name.span, similar });
            return self.invalid(span);
        }
        self.best(&name.text, name, &candidates, arguments, span)
    }

    /// The candidate that fits the arguments best, applied to them.
    fn best(
        &mut self,
        shown: &str,
        name: &ast::Name,
        candidates: &[FunctionId],
        arguments: Vec<Term>,
        span: Span,
    ) -> Term {
        // of two that fit alike, this file's own is meant
        let fitting = candidates.iter().filter_map(|&candidate| {
            let (fit, bindings) = self.fit(candidate, &arguments)?;
            let foreign = self.declared.functions[candidate.0 as usize].span.file != name.span.file;
            Some(((fit, foreign), candidate, bindings))
        });
        let Some((_, function, bindings)) = fitting.min_by_key(|(fit, ..)| *fit) else {
            return self.no_overload(shown, candidates, &arguments, span);
        };
        let codomain = self.declared.functions[function.0 as usize].codomain;
        let ty = self.declared.types.substitute(codomain, &self.declared.domains, &bindings);
        // `undef` and errors fit everything: no type of the result follows from them.
        let wanted = self.declared.functions[function.0 as usize].parameters.len();
        let kind = match &self.declared.functions[function.0 as usize].meaning {
            Meaning::Constant(atom) => TermKind::Value(Value::Atom(*atom)),
            _ if wanted != arguments.len() => match arguments.into_iter().next() {
                Some(tuple) => TermKind::Spread(function, tuple),
                None => TermKind::Invalid,
            },
            _ => TermKind::Apply(function, arguments),
        };
        Term { kind: Box::new(kind), ty, span }
    }

    /// How well a function fits the arguments, and what its type variables become.
    fn fit(&self, function: FunctionId, arguments: &[Term]) -> Option<(u32, Bindings)> {
        let parameters = &self.declared.functions[function.0 as usize].parameters;
        let types = &self.declared.types;
        let mut bindings = Bindings::new();
        let actual: Vec<TypeId> = match arguments {
            [tuple] if parameters.len() > 1 => match types.get(types.root(tuple.ty, &self.declared.domains)) {
                Type::Prod(items) => items.clone(),
                _ => return None,
            },
            _ => arguments.iter().map(|term| term.ty).collect(),
        };
        if parameters.len() != actual.len() {
            return None;
        }
        let mut total = 0;
        for (&wanted, &actual) in parameters.iter().zip(&actual) {
            total += types.fit(wanted, actual, &self.declared.domains, &mut bindings)?;
        }
        Some((total, bindings))
    }

    fn no_overload(&mut self, name: &str, candidates: &[FunctionId], arguments: &[Term], span: Span) -> Term {
        if arguments.iter().any(|term| *self.declared.types.get(term.ty) == Type::Invalid) {
            return self.invalid(span);
        }
        let types: Vec<String> = arguments.iter().map(|term| self.show(term.ty)).collect();
        let actual = match types.as_slice() {
            [] => "no arguments".to_owned(),
            [one] => one.clone(),
            several => several.join(" and "),
        };
        let own: Vec<(String, Span)> = candidates
            .iter()
            .map(|id| &self.declared.functions[id.0 as usize])
            .filter(|function| !function.library)
            .map(|function| {
                let types: Vec<String> = function.parameters.iter().map(|&ty| self.show(ty)).collect();
                (format!("this one takes ({})", types.join(", ")), function.span)
            })
            .collect();
        let hint = overload_hint(&types);
        self.error(HirError::NoOverload { name: Arc::from(name), at: span, actual, candidates: own, hint });
        self.invalid(span)
    }

    /// The type of terms that stand side by side.
    fn agree(&mut self, what: &'static str, first: &Term, second: &Term) -> TypeId {
        if let Some(ty) = self.declared.types.join(first.ty, second.ty, &self.declared.domains) {
            return ty;
        }
        let error = HirError::Disagree {
            what,
            first: self.show(first.ty),
            second: self.show(second.ty),
            first_at: first.span,
            second_at: second.span,
        };
        self.error(error);
        self.ty(Type::Invalid)
    }

    fn switch(
        &mut self,
        subject: &ast::Term,
        cases: &[(ast::Term, ast::Term)],
        otherwise: Option<&ast::Term>,
        span: Span,
    ) -> Term {
        let subject = self.term(subject);
        let mut resolved: Vec<(Term, Term)> = Vec::new();
        let mut ty = self.ty(Type::Undef);
        for (case, value) in cases {
            let case = self.case(&subject, case);
            let value = self.term(value);
            ty = match resolved.first() {
                Some((_, first)) => {
                    let first = first.clone();
                    self.agree("the cases", &first, &value)
                }
                None => value.ty,
            };
            resolved.push((case, value));
        }
        let otherwise = otherwise.map(|term| self.term(term));
        if let (Some(other), Some((_, first))) = (&otherwise, resolved.first()) {
            let first = first.clone();
            ty = self.agree("the cases", &first, other);
        }
        Term { kind: Box::new(TermKind::Switch(subject, resolved, otherwise)), ty, span }
    }

    /// A case of a switch; its type fits the subject's.
    pub fn case(&mut self, subject: &Term, case: &ast::Term) -> Term {
        let case = self.term(case);
        self.expect(&case, subject.ty, "a case", Some((subject.span, "this is")));
        case
    }

    pub fn bindings(&mut self, bindings: &[(ast::Name, ast::Term)]) -> Vec<(VarId, Term)> {
        let mut bound = Vec::new();
        for (name, term) in bindings {
            let term = self.term(term);
            let variable = self.bind(name, term.ty);
            bound.push((variable, term));
        }
        bound
    }

    /// Binders from left to right: a range may depend on the variables before it.
    pub fn binders(&mut self, binders: &[ast::Binder]) -> Vec<Binder> {
        let mut bound = Vec::new();
        for binder in binders {
            let range = self.term(&binder.range);
            let root = self.declared.types.root(range.ty, &self.declared.domains);
            let item = match self.declared.types.get(root) {
                Type::Powerset(item) | Type::Seq(item) | Type::Bag(item) => *item,
                Type::Undef | Type::Invalid => range.ty,
                _ => {
                    let actual = self.show(range.ty);
                    let name = binder.name.text.clone();
                    self.error(HirError::NotACollection { name, actual, at: range.span });
                    self.ty(Type::Invalid)
                }
            };
            let variable = self.bind(&binder.name, item);
            bound.push(Binder { variable, range });
        }
        bound
    }

    fn comprehension(&mut self, from: &ast::Comprehension) -> (Vec<Binder>, Option<Term>, Term) {
        let binders = self.binders(&from.binders);
        let guard = from.guard.as_ref().map(|guard| self.boolean(guard, "a guard"));
        let item = self.term(&from.item);
        (binders, guard, item)
    }

    fn element_type(&mut self, items: &[Term]) -> TypeId {
        let mut items = items.iter();
        let Some(first) = items.next() else {
            return self.ty(Type::Undef);
        };
        let mut ty = first.ty;
        for item in items {
            match self.declared.types.join(ty, item.ty, &self.declared.domains) {
                Some(joined) => ty = joined,
                None => ty = self.agree("the elements", first, item),
            }
        }
        ty
    }

    fn interval(&mut self, collection: ast::Collection, from: &ast::Interval, span: Span) -> Term {
        let first = self.term(&from.from);
        let last = self.term(&from.to);
        let step = from.step.as_ref().map(|step| self.term(step));
        let root = self.declared.types.root(first.ty, &self.declared.domains);
        let counts = self.declared.types.get(root).is_whole();
        if !counts && !matches!(self.declared.types.get(root), Type::Real | Type::Invalid) {
            let actual = self.show(first.ty);
            let error = HirError::Mismatch {
                what: "an interval".to_owned(),
                wanted: "a number".to_owned(),
                actual,
                at: first.span,
                because: None,
                number: None,
            };
            self.error(error);
        }
        for bound in [Some(&last), step.as_ref()].into_iter().flatten() {
            let other = self.declared.types.root(bound.ty, &self.declared.domains);
            if !(counts && self.declared.types.get(other).is_whole()) {
                self.expect(bound, first.ty, "an interval", Some((first.span, "this is")));
            }
        }
        let ty = of(collection, root);
        self.made(TermKind::Interval(collection, first, last, step), ty, span)
    }

    fn map(&mut self, pairs: &[(ast::Term, ast::Term)], span: Span) -> Term {
        let pairs: Vec<(Term, Term)> =
            pairs.iter().map(|(key, value)| (self.term(key), self.term(value))).collect();
        let (keys, values): (Vec<Term>, Vec<Term>) = pairs.iter().cloned().unzip();
        let key = self.element_type(&keys);
        let value = self.element_type(&values);
        self.made(TermKind::Map(pairs), Type::Map(key, value), span)
    }

    fn rule_ref(&mut self, name: &ast::Name, domains: &[ast::Type], span: Span) -> Term {
        let domains: Vec<TypeId> =
            domains.iter().map(|domain| self.declared.resolve_type(self.unit, domain)).collect();
        let candidates = self.declared.scopes[self.unit].rules.get(&name.text).cloned().unwrap_or_default();
        // the domains pick the overload; without them the first rule is meant
        let best = candidates.iter().copied().filter_map(|id| {
            let fit = if domains.is_empty() { Some(0) } else { self.rule_fit(id, &domains) };
            Some((fit?, id))
        });
        match best.min() {
            Some((_, rule)) => self.made(TermKind::Rule(rule), Type::Rule, span),
            None => {
                self.unknown_rule(name);
                self.invalid(span)
            }
        }
    }

    pub fn unknown_rule(&mut self, name: &ast::Name) {
        let scope = &self.declared.scopes[self.unit];
        let similar = scope.similar_rule(&name.text).map(|found| {
            let declared = scope.rules.get(&found).and_then(|ids| ids.first());
            let span = declared.map_or_else(Span::default, |id| self.declared.rules[id.0 as usize].span);
            (found, span)
        });
        self.error(HirError::UnknownRule { name: name.text.clone(), at: name.span, similar });
    }

    /// How well a rule's parameters fit.
    fn rule_fit(&self, rule: RuleId, actual: &[TypeId]) -> Option<u32> {
        let parameters = &self.declared.rules[rule.0 as usize].parameters;
        if parameters.len() != actual.len() {
            return None;
        }
        let (types, domains) = (&self.declared.types, &self.declared.domains);
        let mut bindings = Bindings::new();
        let mut pairs = parameters.iter().zip(actual);
        pairs.try_fold(0, |sum, (&wanted, &actual)| Some(sum + types.fit(wanted, actual, domains, &mut bindings)?))
    }

    /// The rule of this name that fits the arguments best.
    pub fn callee(&mut self, name: &ast::Name, arguments: &[Term]) -> Option<RuleId> {
        let candidates = self.declared.scopes[self.unit].rules.get(&name.text).cloned().unwrap_or_default();
        let Some(&first) = candidates.first() else {
            self.unknown_rule(name);
            return None;
        };
        let types: Vec<TypeId> = arguments.iter().map(|argument| argument.ty).collect();
        let fitting = candidates.iter().filter_map(|&id| Some((self.rule_fit(id, &types)?, id)));
        if let Some((_, id)) = fitting.min() {
            return Some(id);
        }
        let rule = &self.declared.rules[first.0 as usize];
        let (declared, parameters) = (rule.span, rule.parameters.clone());
        if parameters.len() == arguments.len() {
            for (&wanted, argument) in parameters.iter().zip(arguments) {
                self.expect(argument, wanted, &format!("`{}`", name.text), Some((declared, "takes")));
            }
        } else {
            self.error(HirError::Arity {
                name: name.text.clone(),
                wanted: parameters.len(),
                actual: arguments.len(),
                at: name.span,
                declared,
            });
        }
        None
    }

    /// Whether a domain can take new elements: it is abstract, or a subset of an abstract one.
    pub fn is_extensible(&self, ty: TypeId) -> bool {
        let root = self.declared.types.root(ty, &self.declared.domains);
        match self.declared.types.get(root) {
            Type::Domain(domain) => self.declared.domains[domain.0 as usize].kind == DomainKind::Abstract,
            _ => false,
        }
    }

    /// A rule as a node.
    pub fn rule_term(kind: crate::model::RuleKind, span: Span) -> RuleTerm {
        RuleTerm { kind: Box::new(kind), span }
    }
}

/// The type of a collection of such elements.
fn of(collection: ast::Collection, item: TypeId) -> Type {
    match collection {
        ast::Collection::Set => Type::Powerset(item),
        ast::Collection::Seq => Type::Seq(item),
        ast::Collection::Bag => Type::Bag(item),
    }
}

/// What helps when numbers of different kinds meet.
fn overload_hint(types: &[String]) -> Option<String> {
    let has = |name: &str| types.iter().any(|ty| ty == name);
    if has("Integer") && has("Real") {
        Some("Integer and Real do not mix: write `1.0` instead of `1`, or convert with `itor(…)`".to_owned())
    } else if has("Natural") && has("Real") {
        Some("Natural and Real do not mix: convert with `ntor(…)`".to_owned())
    } else if has("Integer") && has("Natural") {
        Some("Integer and Natural do not mix here: write `1n`, or convert with `iton(…)` or `ntoi(…)`".to_owned())
    } else {
        None
    }
}
