//! The context for resolving one body: its variables, the declarations, and the report.

use crate::codes::a002::UnknownVariable;
use crate::codes::a007::TypeMismatch;
use crate::codes::w021::OutOfScope;
use crate::codes::w025::IntegerForNatural;
use crate::declare::SignatureTables;
use crate::model::{Body, FunctionKind, Term, TermKind, VarId, Variable};
use crate::types::{Type, TypeId};
use asmotion_diagnostics::{Diagnostic, Finding, Span, similar};
use asmotion_syntax::ast;
use asmotion_value::Value;
use std::sync::Arc;

/// Resolves one body: a rule, a definition or a condition.
pub(crate) struct Resolver<'a> {
    pub declared: &'a mut SignatureTables,
    pub unit: usize,
    variables: Vec<Variable>,
    /// The visible variables, innermost last.
    visible: Vec<VarId>,
    /// Number of leading variables that are macro parameters and may therefore stand for locations.
    location_parameters: usize,
    /// Result type of the turbo rule that is being resolved.
    pub result: Option<TypeId>,
    /// Findings that are consequences if a part of the body could not be parsed.
    doubtful: Vec<Diagnostic>,
    is_incomplete: bool,
    /// `true` for a rule from outside, which may update monitored functions.
    from_outside: bool,
}

/// Reports the findings that depend on the whole body.
impl Drop for Resolver<'_> {
    fn drop(&mut self) {
        if !self.is_incomplete {
            let doubtful = std::mem::take(&mut self.doubtful);
            self.declared.report.diagnostics.extend(doubtful);
        }
    }
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
            doubtful: Vec::new(),
            is_incomplete: false,
            from_outside: false,
        }
    }

    /// Marks the body as that of a declared rule. The parameters of a macro stand for terms, and
    /// thus possibly for locations; a turbo rule may have a result.
    pub fn enter(&mut self, parameters: usize, turbo: bool, result: Option<TypeId>) {
        self.location_parameters = if turbo { 0 } else { parameters };
        self.result = result;
    }

    /// Marks the rule as coming from outside.
    pub fn mark_external(&mut self) {
        self.from_outside = true;
    }

    /// Returns `true` if the rule may update a function of this kind although the environment owns
    /// it.
    pub fn may_write(&self, kind: FunctionKind) -> bool {
        self.from_outside && kind == FunctionKind::Monitored
    }

    /// Returns `true` if a variable may stand for a location. Relies on parameters being bound
    /// first.
    pub fn stands_for_location(&self, id: VarId) -> bool {
        (id.0 as usize) < self.location_parameters
    }

    pub fn body<T>(mut self, parameters: usize, root: T) -> Body<T> {
        Body {
            parameters,
            variables: std::mem::take(&mut self.variables),
            root,
        }
    }

    pub fn variables(&self) -> Vec<Variable> {
        self.variables.clone()
    }

    /// Binds a variable and makes it visible.
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

    /// Creates a variable without a name, which the text cannot refer to.
    pub fn fresh(&mut self, ty: TypeId, span: Span) -> VarId {
        let name = Arc::from("");
        self.variables.push(Variable { name, ty, span });
        VarId(self.variables.len() as u32 - 1)
    }

    /// Runs `work`, then hides the variables that it has bound.
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

    /// Notes that a part of the body could not be parsed.
    pub fn mark_incomplete(&mut self) {
        self.is_incomplete = true;
    }

    /// Reports an error unless a part of the body could not be parsed: that part may have bound the variable, or what follows it is
    /// not a rule of its own.
    pub fn error_if_complete(&mut self, error: impl Finding) {
        self.doubtful.push(error.diagnostic());
    }

    pub fn error(&mut self, error: impl Finding) {
        self.declared.report.push(error.diagnostic());
    }

    pub fn compatible(&self, a: TypeId, b: TypeId) -> bool {
        self.declared.types.compatible(a, b, &self.declared.domains)
    }

    /// Reports a term whose type does not fit the wanted one. `what` names the term; `because`
    /// labels the place that determines the wanted type.
    pub fn expect(
        &mut self,
        term: &Term,
        expected: TypeId,
        what: &str,
        because: Option<(Span, &'static str)>,
    ) {
        if self.compatible(expected, term.ty) {
            return;
        }
        let numbers = self.respelt_into(term, expected).unwrap_or_default();
        if let ([number], true) = (&*numbers, self.is_natural(term, expected)) {
            let number = number.text.clone();
            let at = term.span;
            return self.error(IntegerForNatural { number, at });
        }
        let (expected, actual) = (self.show(expected), self.show(term.ty));
        self.error(TypeMismatch {
            what: what.to_owned(),
            expected,
            actual,
            at: term.span,
            because,
            numbers,
        });
    }

    /// Returns `true` if a term is a non-negative integer literal where a Natural is wanted: older
    /// models do not distinguish the two.
    fn is_natural(&self, term: &Term, expected: TypeId) -> bool {
        let root = self.declared.types.root(expected, &self.declared.domains);
        *self.declared.types.get(root) == Type::Natural
            && matches!(*term.kind, TermKind::Value(Value::Int(0..)))
    }

    pub fn boolean(&mut self, term: &ast::Term, what: &str) -> Term {
        let term = self.term(term);
        let boolean = self.ty(Type::Boolean);
        self.expect(&term, boolean, what, None);
        term
    }

    /// Resolves a variable that is not visible. One that is bound elsewhere in the body only gets a
    /// warning, because the reference accepts the text and fails only when the term is evaluated.
    /// Any other is an error.
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
        self.error_if_complete(UnknownVariable {
            name: name.text.clone(),
            at: name.span,
            similar,
        });
        self.invalid(name.span)
    }
}
