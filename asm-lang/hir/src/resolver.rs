//! What resolving a body needs: its variables, the types, a place for findings.

use crate::codes::a002::UnknownVariable;
use crate::codes::a007::TypeMismatch;
use crate::codes::w021::OutOfScope;
use crate::codes::w025::IntegerForNatural;
use crate::declare::SignatureTables;
use crate::model::{Body, FunctionKind, Term, TermKind, VarId, Variable};
use crate::types::{Type, TypeId};
use asmotion_diagnostics::{Finding, Span, similar};
use asmotion_syntax::ast;
use asmotion_value::Value;
use std::sync::Arc;

/// Resolves one body: a rule, a definition, a condition.
pub(crate) struct Resolver<'a> {
    pub declared: &'a mut SignatureTables,
    pub unit: usize,
    variables: Vec<Variable>,
    /// The variables that can be seen, innermost last.
    visible: Vec<VarId>,
    /// How many of the first variables are parameters that may stand for locations: a macro's.
    location_parameters: usize,
    /// The domain of the turbo rule's result, while one is being resolved.
    pub result: Option<TypeId>,
    /// Whether the rule comes from outside: then it may write what the environment owns.
    from_outside: bool,
}

impl<'a> Resolver<'a> {
    pub fn new(declared: &'a mut SignatureTables, unit: usize) -> Self {
        Self {
            declared,
            unit,
            variables: Vec::new(),
            visible: Vec::new(),
            location_parameters: 0,
            result: None,
            from_outside: false,
        }
    }

    /// Says that the body is that of a rule. The parameters of a macro stand for terms, and so for
    /// locations; a turbo rule may have a result.
    pub fn enter(&mut self, parameters: usize, turbo: bool, result: Option<TypeId>) {
        self.location_parameters = if turbo { 0 } else { parameters };
        self.result = result;
    }

    /// Says that the rule comes from outside.
    pub fn enter_from_outside(&mut self) {
        self.from_outside = true;
    }

    /// Whether the rule may write a function although it is the environment's.
    pub fn may_write(&self, kind: FunctionKind) -> bool {
        self.from_outside && kind == FunctionKind::Monitored
    }

    /// Whether a variable may stand for a location. Parameters are bound before anything else.
    pub fn stands_for_location(&self, id: VarId) -> bool {
        (id.0 as usize) < self.location_parameters
    }

    pub fn body<T>(self, parameters: usize, root: T) -> Body<T> {
        Body {
            parameters,
            variables: self.variables,
            root,
        }
    }

    pub fn variables(&self) -> Vec<Variable> {
        self.variables.clone()
    }

    /// Binds a variable from here on.
    pub fn bind(&mut self, name: &ast::NameText, ty: TypeId) -> VarId {
        let id = VarId(self.variables.len() as u32);
        self.variables.push(Variable {
            name: name.text.clone(),
            ty,
            span: name.span,
        });
        self.visible.push(id);
        id
    }

    /// A variable that the text does not name.
    pub fn fresh(&mut self, ty: TypeId, span: Span) -> VarId {
        let name = Arc::from("");
        self.variables.push(Variable { name, ty, span });
        VarId(self.variables.len() as u32 - 1)
    }

    /// Does something with the variables it binds, and forgets them.
    pub fn scoped<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let depth = self.visible.len();
        let result = work(self);
        self.visible.truncate(depth);
        result
    }

    pub fn lookup(&self, name: &str) -> Option<VarId> {
        self.visible
            .iter()
            .rev()
            .copied()
            .find(|id| &*self.variable(*id).name == name)
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

    pub fn error(&mut self, error: impl Finding) {
        self.declared.report.push(error.diagnostic());
    }

    pub fn compatible(&self, a: TypeId, b: TypeId) -> bool {
        self.declared.types.compatible(a, b, &self.declared.domains)
    }

    /// Reports a term whose type does not fit.
    pub fn expect(
        &mut self,
        term: &Term,
        wanted: TypeId,
        what: &str,
        because: Option<(Span, &'static str)>,
    ) {
        if self.compatible(wanted, term.ty) {
            return;
        }
        let number = self.written_as(term, wanted);
        if let (Some(number), true) = (&number, self.is_natural(term, wanted)) {
            let number = number.clone();
            let at = term.span;
            return self.error(IntegerForNatural { number, at });
        }
        let (wanted, actual) = (self.show(wanted), self.show(term.ty));
        self.error(TypeMismatch {
            what: what.to_owned(),
            wanted,
            actual,
            at: term.span,
            because,
            number,
        });
    }

    /// Whether a term is a number that a Natural may be, and a Natural is wanted: older models do not
    /// tell them apart.
    fn is_natural(&self, term: &Term, wanted: TypeId) -> bool {
        let root = self.declared.types.root(wanted, &self.declared.domains);
        *self.declared.types.get(root) == Type::Natural
            && matches!(*term.kind, TermKind::Value(Value::Int(0..)))
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

    /// A variable bound further out is no longer to be had: the reference takes such a text and
    /// fails where it is evaluated. One that is bound nowhere is a mistake.
    pub fn unknown_variable(&mut self, name: &ast::NameText) -> Term {
        let bound = self
            .variables
            .iter()
            .rev()
            .find(|known| known.name == name.text)
            .map(|known| (known.span, known.ty));
        if let Some((bound, ty)) = bound {
            self.error(OutOfScope {
                name: name.text.clone(),
                at: name.span,
                bound,
            });
            return Term {
                kind: Box::new(TermKind::Unbound),
                ty,
                span: name.span,
            };
        }
        let similar = similar(
            &name.text,
            self.visible.iter().map(|id| &self.variable(*id).name),
        )
        .cloned();
        self.error(UnknownVariable {
            name: name.text.clone(),
            at: name.span,
            similar,
        });
        self.invalid(name.span)
    }
}
