//! Collection terms, and the ranges of binders.

use crate::codes::a007::TypeMismatch;
use crate::codes::a018::NotACollection;
use crate::model::{Binder, Term, TermKind};
use crate::resolver::Resolver;
use crate::types::{Type, TypeId};
use asmotion_diagnostics::Span;
use asmotion_syntax::ast;

impl Resolver<'_> {
    /// Resolves binders from left to right: a range may refer to the variables bound before it.
    pub fn binders(&mut self, binders: &[ast::Binder]) -> Vec<Binder> {
        let mut bound = Vec::new();
        for binder in binders {
            let range = self.term(&binder.range);
            let root = self.declared.types.root(range.ty, &self.declared.domains);
            let item = match self.declared.types.get(root) {
                Type::Powerset(item) | Type::Seq(item) | Type::Bag(item) => *item,
                Type::Undef | Type::Invalid => range.ty,
                Type::Boolean
                | Type::Integer
                | Type::Natural
                | Type::Real
                | Type::Complex
                | Type::Char
                | Type::String
                | Type::Rule
                | Type::Domain(_)
                | Type::Prod(_)
                | Type::Map(..) => {
                    let actual = self.show(range.ty);
                    let name = binder.name.text.clone();
                    self.error(NotACollection {
                        name,
                        actual,
                        at: range.span,
                    });
                    self.ty(Type::Invalid)
                }
            };
            let variable = self.bind(&binder.name, item);
            bound.push(Binder { variable, range });
        }
        bound
    }

    pub fn listed(&mut self, collection: ast::Collection, items: &[ast::Term], span: Span) -> Term {
        let items = self.terms(items);
        let item = self.common("the elements", &items);
        self.new_term(
            TermKind::Listed(collection, items),
            of(collection, item),
            span,
        )
    }

    pub fn comprehension(
        &mut self,
        collection: ast::Collection,
        from: &ast::Comprehension,
        span: Span,
    ) -> Term {
        self.scoped(|this| {
            let (binders, guard, item) = this.generated(from);
            let ty = of(collection, item.ty);
            this.new_term(
                TermKind::Comprehension(collection, binders, guard, item),
                ty,
                span,
            )
        })
    }

    pub fn map_comprehension(
        &mut self,
        from: &ast::Comprehension,
        value: &ast::Term,
        span: Span,
    ) -> Term {
        self.scoped(|this| {
            let (binders, guard, key) = this.generated(from);
            let value = this.term(value);
            let ty = Type::Map(key.ty, value.ty);
            this.new_term(
                TermKind::MapComprehension(binders, guard, key, value),
                ty,
                span,
            )
        })
    }

    fn generated(&mut self, from: &ast::Comprehension) -> (Vec<Binder>, Option<Term>, Term) {
        let binders = self.binders(&from.binders);
        let guard = from
            .guard
            .as_ref()
            .map(|guard| self.boolean(guard, "a guard"));
        let item = self.term(&from.item);
        (binders, guard, item)
    }

    pub fn interval(
        &mut self,
        collection: ast::Collection,
        from: &ast::Interval,
        span: Span,
    ) -> Term {
        let first = self.term(&from.from);
        let last = self.term(&from.to);
        let step = from.step.as_ref().map(|step| self.term(step));
        let root = self.declared.types.root(first.ty, &self.declared.domains);
        let counts = self.declared.types.get(root).is_whole();
        if !counts && !matches!(self.declared.types.get(root), Type::Real | Type::Invalid) {
            let actual = self.show(first.ty);
            let error = TypeMismatch {
                what: "an interval".to_owned(),
                expected: "a number".to_owned(),
                actual,
                at: first.span,
                because: None,
                numbers: Vec::new(),
            };
            self.error(error);
        }
        for bound in [Some(&last), step.as_ref()].into_iter().flatten() {
            let other = self.declared.types.root(bound.ty, &self.declared.domains);
            if !(counts && self.declared.types.get(other).is_whole()) {
                self.expect(
                    bound,
                    first.ty,
                    "an interval",
                    Some((first.span, "has type")),
                );
            }
        }
        let ty = of(collection, root);
        self.new_term(TermKind::Interval(collection, first, last, step), ty, span)
    }

    pub fn map(&mut self, pairs: &[(ast::Term, ast::Term)], span: Span) -> Term {
        let pairs: Vec<(Term, Term)> = pairs
            .iter()
            .map(|(key, value)| (self.term(key), self.term(value)))
            .collect();
        let key = self.common("the keys", pairs.iter().map(|(key, _)| key));
        let value = self.common("the values", pairs.iter().map(|(_, value)| value));
        self.new_term(TermKind::Map(pairs), Type::Map(key, value), span)
    }
}

/// Returns the type of a collection with this element type.
fn of(collection: ast::Collection, item: TypeId) -> Type {
    match collection {
        ast::Collection::Set => Type::Powerset(item),
        ast::Collection::Seq => Type::Seq(item),
        ast::Collection::Bag => Type::Bag(item),
    }
}
