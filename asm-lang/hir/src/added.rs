//! Terms and rules added to a model after analysis: those of scenarios, prompts and watch
//! expressions.
//!
//! Their scope consists of the names of the main file and, where those do not hide them, the names
//! of every module it imports. Added parts are lowered with the model without changing the
//! locations of the program, so a machine in any state can continue with the extended program.

use crate::addition::{AddedRule, AddedTerm, Assignment};
use crate::codes::a016::WritesFixed;
use crate::declare::SignatureTables;
use crate::model::{Body, Expression, FunctionId, Meaning, Model, Term, TermKind, kind_name};
use crate::resolver::Resolver;
use crate::scope::Scope;
use crate::types::{Type, TypeId};
use asmotion_diagnostics::{Report, Span};
use asmotion_syntax::ast;
use std::collections::BTreeSet;

impl Model {
    /// Adds a term of any type.
    ///
    /// # Errors
    /// A name is unknown, or a type does not fit.
    pub fn add_term(&mut self, term: &ast::Term) -> Result<AddedTerm, Report> {
        let body = self.resolve(|mut resolver| {
            let root = resolver.term(term);
            Some(resolver.body(0, root))
        })?;
        Ok(self.added.term(body))
    }

    /// Adds a term of the type `expected`; `what` names the term in messages.
    ///
    /// # Errors
    /// As [`Model::add_term`].
    pub fn add_typed(
        &mut self,
        term: &ast::Term,
        expected: TypeId,
        what: &str,
    ) -> Result<AddedTerm, Report> {
        let body = self.resolve(|mut resolver| {
            let root = resolver.term(term);
            resolver.expect(&root, expected, what, None);
            Some(resolver.body(0, root))
        })?;
        Ok(self.added.term(body))
    }

    /// Adds a term of type Boolean; `what` names the term in messages.
    ///
    /// # Errors
    /// As [`Model::add_term`].
    pub fn add_condition(&mut self, term: &ast::Term, what: &str) -> Result<AddedTerm, Report> {
        let boolean = self.types.id(Type::Boolean);
        self.add_typed(term, boolean, what)
    }

    /// Adds a rule. Unlike a rule of the specification, it may update monitored functions.
    ///
    /// # Errors
    /// As [`Model::add_term`], or the rule updates a static or derived function.
    pub fn add_rule(&mut self, rule: &ast::Rule) -> Result<AddedRule, Report> {
        let body = self.resolve(|mut resolver| {
            resolver.mark_external();
            let root = resolver.rule(rule);
            Some(resolver.body(0, root))
        })?;
        Ok(self.added.rule(body))
    }

    /// Adds the arguments of a location and a value for it. Unlike in a rule, the location may
    /// belong to a monitored function.
    ///
    /// # Errors
    /// As [`Model::add_term`], or the function has no locations.
    pub fn add_assignment(
        &mut self,
        target: &ast::Assignee,
        value: &ast::Term,
    ) -> Result<Assignment, Report> {
        let (function, arguments, value) = self.resolve(|mut resolver| {
            let root = resolver.term(value);
            let (function, arguments) = resolver.setting(target, &root)?;
            let variables = resolver.variables();
            let body = |root| Body {
                parameters: 0,
                variables: variables.clone(),
                root,
            };
            let arguments: Vec<_> = arguments.into_iter().map(body).collect();
            Some((function, arguments, body(root)))
        })?;
        let arguments = arguments.into_iter();
        Ok(Assignment {
            function,
            arguments: arguments.map(|body| self.added.term(body)).collect(),
            value: self.added.term(value),
        })
    }

    /// Adds a subterm of an added term, with the variables bound in that term.
    pub fn add_part(&mut self, whole: AddedTerm, part: Term) -> AddedTerm {
        let whole = self.added.terms.get(whole.0 as usize);
        let variables = whole.map_or_else(Vec::new, |whole| whole.variables.clone());
        self.added.term(Body {
            parameters: 0,
            variables,
            root: part,
        })
    }

    /// Adds a term that consists of resolved parts.
    pub fn add_resolved(&mut self, term: Expression) -> AddedTerm {
        self.added.term(term)
    }

    /// Makes the functions that a standard library declares visible to added parts, as if the main file imported it, without the
    /// definitions of those that have one. Names that are visible already hide them. Returns `false` if all of them are hidden.
    pub fn offer_library(&mut self, library: &ast::File) -> bool {
        let offered = self.resolve(|resolver| Some(resolver.declared.offer_functions(library)));
        offered.unwrap_or_default()
    }

    /// Removes all added parts but the first `terms` terms and `rules` rules.
    pub fn forget_added(&mut self, terms: usize, rules: usize) {
        self.added.terms.truncate(terms);
        self.added.rules.truncate(rules);
    }

    /// Resolves a part in the scope of the main file. `work` returns `None` only after reporting an
    /// error.
    fn resolve<T>(&mut self, work: impl FnOnce(Resolver<'_>) -> Option<T>) -> Result<T, Report> {
        let mut declared = SignatureTables {
            types: std::mem::take(&mut self.types),
            domains: std::mem::take(&mut self.domains),
            functions: std::mem::take(&mut self.functions),
            rules: std::mem::take(&mut self.rules),
            atoms: std::mem::take(&mut self.atoms),
            scopes: vec![std::mem::take(&mut self.scope)],
            import_clauses: Vec::new(),
            headings: Vec::new(),
            lost_imports: Vec::new(),
            failed_imports: Vec::new(),
            report: Report::new(),
            chooses: false,
            missed: BTreeSet::new(),
            compatible: self.compatible,
        };
        let result = work(Resolver::new(&mut declared, 0));
        self.types = declared.types;
        self.domains = declared.domains;
        self.functions = declared.functions;
        self.rules = declared.rules;
        self.atoms = declared.atoms;
        self.scope = declared.scopes.pop().unwrap_or_default();
        match result {
            Some(result) if !declared.report.has_errors() => Ok(result),
            _ => Err(declared.report.finish()),
        }
    }
}

impl Resolver<'_> {
    /// Resolves the location of an assignment from outside: its function and arguments.
    fn setting(&mut self, target: &ast::Assignee, value: &Term) -> Option<(FunctionId, Vec<Term>)> {
        let ast::Assignee::Location {
            agent,
            function: name,
            arguments,
            span,
        } = target
        else {
            if let ast::Assignee::Variable(name) = target {
                self.unknown_variable(name);
            }
            return None;
        };
        let mut all = Vec::new();
        if let Some(agent) = agent {
            all.push(self.apply(agent, Vec::new(), agent.span));
        }
        all.extend(self.terms(arguments));
        let applied = self.apply(name, all, *span);
        if let TermKind::Invalid = *applied.kind {
            return None;
        }
        let Some((id, arguments)) = applied.kind.into_application() else {
            self.not_settable(name, "static", name.span);
            return None;
        };
        let function = &self.declared.functions[id.0 as usize];
        let (codomain, kind, declared) = (function.codomain, function.kind, function.span);
        if !matches!(function.meaning, Meaning::State) {
            self.not_settable(name, kind_name(kind), declared);
            return None;
        }
        let what = format!("`{}`", name.text);
        self.expect(value, codomain, &what, Some((declared, "declared")));
        Some((id, arguments))
    }

    fn not_settable(&mut self, name: &ast::NameText, kind: &'static str, declared: Span) {
        self.error(WritesFixed {
            function: name.text.clone(),
            kind,
            at: name.span,
            declared,
        });
    }
}

/// Merges the scopes of all files into the scope of added parts: names of the main file, the last
/// one, hide those of the others.
pub(crate) fn merged_scope(mut scopes: Vec<Scope>) -> Scope {
    let mut seen = scopes.pop().unwrap_or_default();
    for scope in scopes.iter().rev() {
        seen.complete(scope);
    }
    seen
}
