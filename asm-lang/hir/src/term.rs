//! Resolution and typing of terms.

use crate::codes::a005::UnknownConstant;
use crate::codes::a006::Respelt;
use crate::codes::a019::DisagreeingDomains;
use crate::codes::w032::InterpolatedText;
use crate::hidden::NameKind;
use crate::model::{Term, TermKind, VarId};
use crate::resolver::Resolver;
use crate::types::{Type, TypeId};
use asmotion_diagnostics::Span;
use asmotion_syntax::ast::{self, ChainLink, Literal};
use asmotion_value::Value;
use std::sync::Arc;

impl Resolver<'_> {
    /// Resolves a term and determines its type.
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
            ast::TermKind::Dot {
                agent,
                name,
                arguments,
            } => self.dot(agent, name, arguments, span),
            ast::TermKind::Chain { first, links } => self.chain(first, links, span),
            ast::TermKind::Unary {
                operator,
                at,
                operand,
            } => {
                let arguments = vec![self.term(operand)];
                self.operator(*operator, *at, arguments, span)
            }
            ast::TermKind::Tuple(items) => {
                let items = self.terms(items);
                let ty = Type::Prod(items.iter().map(|item| item.ty).collect());
                self.new_term(TermKind::Tuple(items), ty, span)
            }
            ast::TermKind::If {
                guard,
                then,
                otherwise,
            } => {
                let guard = self.boolean(guard, "a guard");
                let then = self.term(then);
                let otherwise = otherwise.as_ref().map(|term| self.term(term));
                let ty = self.common("the branches", std::iter::once(&then).chain(&otherwise));
                Term {
                    kind: Box::new(TermKind::If(guard, then, otherwise)),
                    ty,
                    span,
                }
            }
            ast::TermKind::Switch {
                subject,
                cases,
                otherwise,
            } => self.switch(subject, cases, otherwise.as_ref(), span),
            ast::TermKind::Let { bindings, body } => self.scoped(|this| {
                let bindings = this.bindings(bindings);
                let body = this.term(body);
                let ty = body.ty;
                Term {
                    kind: Box::new(TermKind::Let(bindings, body)),
                    ty,
                    span,
                }
            }),
            ast::TermKind::Quantified {
                quantifier,
                binders,
                guard,
            } => self.scoped(|this| {
                let binders = this.binders(binders);
                let guard = guard.as_ref().map(|guard| this.boolean(guard, "a guard"));
                this.new_term(
                    TermKind::Quantified(*quantifier, binders, guard),
                    Type::Boolean,
                    span,
                )
            }),
            ast::TermKind::Listed { collection, items } => self.listed(*collection, items, span),
            ast::TermKind::Interval {
                collection,
                interval,
            } => self.interval(*collection, interval, span),
            ast::TermKind::Comprehension {
                collection,
                comprehension,
            } => self.comprehension(*collection, comprehension, span),
            ast::TermKind::Map(pairs) => self.map(pairs, span),
            ast::TermKind::MapComprehension {
                comprehension,
                value,
            } => self.map_comprehension(comprehension, value, span),
            ast::TermKind::RuleRef { name, domains } => self.rule_ref(name, domains, span),
            ast::TermKind::Domain(domain) => {
                let ty = self.declared.resolve_type(self.unit, domain);
                self.new_term(TermKind::Extent(ty), Type::Powerset(ty), span)
            }
            ast::TermKind::Invalid => {
                self.mark_incomplete();
                self.invalid(span)
            }
        }
    }

    pub fn terms(&mut self, terms: &[ast::Term]) -> Vec<Term> {
        terms.iter().map(|term| self.term(term)).collect()
    }

    pub fn new_term(&mut self, kind: TermKind, ty: Type, span: Span) -> Term {
        Term {
            kind: Box::new(kind),
            ty: self.ty(ty),
            span,
        }
    }

    pub fn invalid(&mut self, span: Span) -> Term {
        self.new_term(TermKind::Invalid, Type::Invalid, span)
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
                let number = (
                    asmotion_value::Real::new(*re),
                    asmotion_value::Real::new(*im),
                );
                (Value::Complex(Arc::new(number)), Type::Complex)
            }
            Literal::Char(character) => (Value::Char(*character), Type::Char),
            Literal::Text(text) => {
                self.lint_interpolation(text, span);
                (Value::text(&**text), Type::String)
            }
        };
        self.new_term(TermKind::Value(value), ty, span)
    }

    /// Warns of the first `${…}` in a text that begins with a variable or with a function that a
    /// specification declares.
    fn lint_interpolation(&mut self, text: &str, span: Span) {
        const QUOTE: usize = 1;
        if !text.contains("${") {
            return;
        }
        let string = self.ty(Type::String);
        let found = text.match_indices("${").find_map(|(at, opening)| {
            let (inside, _) = text[at + opening.len()..].split_once('}')?;
            let word = inside.trim_start().trim_start_matches('$');
            let is_end = |c: char| !c.is_alphanumeric() && c != '_';
            let name = &word[..word.find(is_end).unwrap_or(word.len())];
            let length = opening.len() + inside.len() + 1;
            let (name, ty, declared) = self.interpolated(name)?;
            let start = span.range().start + QUOTE + at;
            Some(InterpolatedText {
                placeholder: text[at..at + length].to_owned(),
                name,
                is_text: self.declared.types.root(ty, &self.declared.domains) == string,
                at: Span::new(span.file, start, start + length),
                declared,
            })
        });
        if let Some(found) = found {
            self.error(found);
        }
    }

    /// Returns the variable or the function of a specification that a placeholder names, with its
    /// domain and the span of its declaration.
    fn interpolated(&self, name: &str) -> Option<(Arc<str>, TypeId, Span)> {
        if let Some(id) = self.lookup(&format!("${name}")) {
            let variable = self.variable(id);
            return Some((variable.name.clone(), variable.ty, variable.span));
        }
        let functions = self.declared.scopes[self.unit].functions.get(name)?;
        let mut functions = functions
            .iter()
            .map(|id| &self.declared.functions[id.0 as usize]);
        functions
            .find(|function| !function.library)
            .map(|function| (function.name.clone(), function.codomain, function.span))
    }

    fn variable_term(&mut self, name: &ast::NameText) -> Term {
        let Some(id) = self.lookup(&name.text) else {
            return self.unknown_variable(name);
        };
        self.variable_of(id, name.span)
    }

    pub fn variable_of(&self, id: VarId, span: Span) -> Term {
        Term {
            kind: Box::new(TermKind::Variable(id)),
            ty: self.variable(id).ty,
            span,
        }
    }

    /// Resolves an upper-case name: an enumeration literal, or a domain as the set of its elements.
    fn constant(&mut self, name: &ast::NameText) -> Term {
        let scope = &self.declared.scopes[self.unit];
        if let Some(&atom) = scope
            .literals
            .get(&name.text)
            .and_then(|atoms| atoms.first())
        {
            let domain = self.declared.atoms[atom.0 as usize].domain;
            return self.new_term(
                TermKind::Value(Value::Atom(atom)),
                Type::Domain(domain),
                name.span,
            );
        }
        if scope.domains.contains_key(&name.text) || Type::basic(&name.text).is_some() {
            let domain = ast::Type {
                kind: ast::TypeKind::Named(name.text.clone()),
                span: name.span,
            };
            let ty = self.declared.resolve_type(self.unit, &domain);
            return self.new_term(TermKind::Extent(ty), Type::Powerset(ty), name.span);
        }
        let booleans = ["true", "false"];
        let boolean = booleans
            .iter()
            .find(|it| it.eq_ignore_ascii_case(&name.text));
        let similar = match boolean {
            Some(boolean) => Some(Arc::from(*boolean)),
            None => scope.similar_constant(&name.text),
        };
        if let Some(element) = self.element(name) {
            return element;
        }
        let kind = NameKind::Constant;
        let hidden = self.declared.hidden(self.unit, &name.text, kind);
        if hidden.is_none() && self.declared.is_lost(self.unit, &name.text, kind) {
            return self.invalid(name.span);
        }
        self.error(UnknownConstant {
            name: name.text.clone(),
            at: name.span,
            similar,
            hidden,
        });
        self.invalid(name.span)
    }

    /// Resolves `self.f(t)` to `f(self, t)`, and `a.f(t)` to `f(a, t)`.
    fn dot(
        &mut self,
        agent: &ast::NameText,
        name: &ast::NameText,
        arguments: &[ast::Term],
        span: Span,
    ) -> Term {
        let agent = self.apply(agent, Vec::new(), agent.span);
        let mut all = vec![agent];
        all.extend(self.terms(arguments));
        self.apply(name, all, span)
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
        for (case, value) in cases {
            let case = self.case(&subject, case);
            resolved.push((case, self.term(value)));
        }
        let otherwise = otherwise.map(|term| self.term(term));
        let values = resolved.iter().map(|(_, value)| value);
        let ty = self.common("the cases", values.chain(&otherwise));
        Term {
            kind: Box::new(TermKind::Switch(subject, resolved, otherwise)),
            ty,
            span,
        }
    }

    /// Resolves a case of a `switch` and checks its type against that of the subject.
    pub fn case(&mut self, subject: &Term, case: &ast::Term) -> Term {
        let case = self.term(case);
        self.expect(
            &case,
            subject.ty,
            "a case",
            Some((subject.span, "has type")),
        );
        case
    }

    /// Resolves a chain such as `a + b - c` from left to right. Long chains are cut into pieces
    /// that are bound to variables by `let`, so that the depth of the resulting term does not grow
    /// with the length of the chain.
    fn chain(&mut self, first: &ast::Term, links: &[ChainLink], span: Span) -> Term {
        let mut pieces = Vec::new();
        let negated = links
            .first()
            .and_then(|link| self.negated_operand(first, link));
        let mut value = negated.unwrap_or_else(|| self.term(first));
        let is_sound = *self.declared.types.get(value.ty) != Type::Invalid;
        for (index, link) in links.iter().enumerate() {
            let is_last = index + 1 == links.len();
            let whole = if is_last {
                span
            } else {
                first.span.to(link.operand.span)
            };
            if index == 0 {
                if is_sound {
                    self.lint_not(link.operator, first, whole);
                }
            } else if index % ChainLink::NESTED as usize == 0 {
                let variable = self.fresh(value.ty, value.span);
                let known = self.variable_of(variable, value.span);
                pieces.push((variable, std::mem::replace(&mut value, known)));
            }
            let arguments = vec![value, self.term(&link.operand)];
            value = self.operator(link.operator, link.at, arguments, whole);
        }
        if pieces.is_empty() {
            return value;
        }
        Term {
            ty: value.ty,
            kind: Box::new(TermKind::Let(pieces, value)),
            span,
        }
    }

    pub fn bindings(&mut self, bindings: &[(ast::NameText, ast::Term)]) -> Vec<(VarId, Term)> {
        let mut bound = Vec::new();
        for (name, term) in bindings {
            let term = self.term(term);
            let variable = self.bind(name, term.ty);
            bound.push((variable, term));
        }
        bound
    }

    /// Returns the spelling of an integer literal in the number domain of another term.
    fn as_number_of(&self, literal: &Term, other: &Term) -> Option<Respelt> {
        let root = self.declared.types.root(other.ty, &self.declared.domains);
        self.respelt_as(literal, Respelt::domain(&self.show(root))?)
    }

    /// Returns the common type of several terms, such as the elements of a collection.
    pub fn common<'t>(
        &mut self,
        what: &'static str,
        terms: impl IntoIterator<Item = &'t Term>,
    ) -> TypeId {
        let mut known: Option<(&Term, TypeId)> = None;
        for term in terms {
            let Some((first, ty)) = known else {
                known = Some((term, term.ty));
                continue;
            };
            let Some(joined) = self
                .declared
                .types
                .join(ty, term.ty, &self.declared.domains)
            else {
                let number = self
                    .as_number_of(term, first)
                    .or_else(|| self.as_number_of(first, term));
                let error = DisagreeingDomains {
                    what,
                    number,
                    first: self.show(ty),
                    second: self.show(term.ty),
                    first_at: first.span,
                    second_at: term.span,
                };
                self.error(error);
                return self.ty(Type::Invalid);
            };
            // `undef` fits every type, so later terms are compared with the first that has one
            known = Some((if joined == ty { first } else { term }, joined));
        }
        known.map_or_else(|| self.ty(Type::Undef), |(_, ty)| ty)
    }
}
