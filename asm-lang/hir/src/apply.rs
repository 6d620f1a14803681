//! Overload resolution: selects the function or rule that a name with arguments refers to.

use crate::codes::a001::UnknownFunction;
use crate::codes::a003::UnknownRule;
use crate::codes::a006::NoOverload;
use crate::codes::a008::WrongArity;
use crate::codes::a036::NotImported;
use crate::codes::w001::NotBinds;
use crate::codes::w028::ArgumentTooWide;
use crate::compatibility::TypeBindings;
use crate::hidden::NameKind;
use crate::model::{FunctionId, Meaning, Term, TermKind};
use crate::resolver::Resolver;
use crate::types::{Type, TypeId};
use asmotion_diagnostics::Span;
use asmotion_syntax::ast::{self, Operator};
use asmotion_value::{RuleId, Value, element_name};
use std::sync::Arc;

impl Resolver<'_> {
    pub fn operator(
        &mut self,
        operator: Operator,
        at: Span,
        arguments: Vec<Term>,
        span: Span,
    ) -> Term {
        let name = ast::NameText {
            text: Arc::from(operator.function()),
            span: at,
        };
        let candidates = self.candidates(&name);
        if candidates.is_empty() {
            let (name, symbol) = (&name.text, Arc::from(operator.symbol()));
            self.not_imported(name, symbol, at);
            return self.invalid(span);
        }
        self.best(operator.symbol(), &name, &candidates, arguments, span)
    }

    /// Returns all overloads of a name.
    fn candidates(&self, name: &ast::NameText) -> Vec<FunctionId> {
        self.declared.scopes[self.unit]
            .functions
            .get(&name.text)
            .cloned()
            .unwrap_or_default()
    }

    pub fn lint_not(&mut self, operator: Operator, left: &ast::Term, whole: Span) {
        if !is_comparison(operator) {
            return;
        }
        // not reported for `(not a) = b`, where brackets make the meaning explicit: that term
        // begins before the `not`
        if let ast::TermKind::Unary {
            operator: Operator::Not,
            at,
            operand,
        } = &*left.kind
            && left.span.start == at.start
            && whole.start == at.start
        {
            self.error(NotBinds {
                operator: operator.symbol(),
                at: *at,
                operand: whole,
                comparison: Span {
                    start: operand.span.start,
                    ..whole
                },
            });
        }
    }

    /// Resolves `not a` at the beginning of a comparison, or returns `None` for any other term. If
    /// `a` is not Boolean, the finding suggests to negate the comparison.
    pub fn negated_operand(&mut self, left: &ast::Term, link: &ast::ChainLink) -> Option<Term> {
        let ast::TermKind::Unary {
            operator: Operator::Not,
            at,
            operand,
        } = &*left.kind
        else {
            return None;
        };
        // a bracketed `(not a)` begins before the `not`
        if !is_comparison(link.operator) || left.span.start != at.start {
            return None;
        }
        let negated = self.term(operand);
        let boolean = self.ty(Type::Boolean);
        if self.compatible(boolean, negated.ty) {
            return Some(self.operator(Operator::Not, *at, vec![negated], left.span));
        }
        let actual = self.show(negated.ty);
        self.error(NoOverload {
            name: Arc::from(Operator::Not.symbol()),
            at: left.span,
            actual,
            candidates: Vec::new(),
            hint: None,
            numbers: Vec::new(),
            comparison: Some(operand.span.to(link.operand.span)),
        });
        Some(self.invalid(left.span))
    }

    /// Applies the best overload of a function to these arguments.
    pub fn apply(&mut self, name: &ast::NameText, arguments: Vec<Term>, span: Span) -> Term {
        let candidates = self.candidates(name);
        if candidates.is_empty() {
            if let (Some(element), []) = (self.element(name), arguments.as_slice()) {
                return element;
            }
            let hidden = self
                .declared
                .hidden(self.unit, &name.text, NameKind::Function);
            if hidden.is_none() && self.may_be_imported(name, NameKind::Function) {
                return self.invalid(span);
            }
            let scope = &self.declared.scopes[self.unit];
            let literal = scope
                .literal_ignoring_case(&name.text)
                .filter(|_| arguments.is_empty());
            let literal = literal.map(|(literal, atom)| {
                let atom = self.declared.atoms.get(atom.0 as usize);
                (literal, atom.map_or_else(Span::default, |atom| atom.span))
            });
            let similar = scope.similar_function(&name.text).map(|found| {
                let declared = scope.functions.get(&found).and_then(|ids| ids.first());
                let span = declared.map_or_else(Span::default, |id| {
                    self.declared.functions[id.0 as usize].span
                });
                (found, span)
            });
            self.error(UnknownFunction {
                name: name.text.clone(),
                at: name.span,
                similar: literal.or(similar),
                hidden,
            });
            return self.invalid(span);
        }
        self.best(&name.text, name, &candidates, arguments, span)
    }

    /// Returns `true` if an unknown name needs no finding of its own: a library declares it, or it
    /// may come from an import that could not be loaded. StandardLibrary takes precedence, because
    /// nearly every file imports it directly.
    fn may_be_imported(&mut self, name: &ast::NameText, kind: NameKind) -> bool {
        let library = asmotion_stdlib::library_declaring(&name.text);
        let is_standard = library.is_some_and(|library| library.name == "StandardLibrary");
        (!is_standard && self.declared.is_lost(self.unit, &name.text, kind))
            || self.not_imported(&name.text, name.text.clone(), name.span)
    }

    /// Reports that an unknown name is declared by a library that the file does not import; returns
    /// `false` if no library declares it. Reported once for each library.
    fn not_imported(&mut self, name: &str, shown: Arc<str>, at: Span) -> bool {
        let Some(library) = asmotion_stdlib::library_declaring(name) else {
            return false;
        };
        if self.declared.missed.insert((self.unit, library.name)) {
            let heading = self.declared.headings.get(self.unit).copied().flatten();
            self.error(NotImported {
                name: shown,
                library: library.name,
                at,
                heading,
            });
        }
        true
    }

    /// Resolves `person!1`, the name of an element that `extend` added to `Person`. The lexer
    /// accepts such names only in terms from outside.
    pub fn element(&mut self, name: &ast::NameText) -> Option<Term> {
        let (domain, number) = name.text.split_once('!')?;
        let domains = &self.declared.scopes[self.unit].domains;
        let (_, &id) = domains
            .iter()
            .find(|(known, _)| known.eq_ignore_ascii_case(domain))?;
        let shown = element_name(&self.declared.domains[id.0 as usize].name, number);
        let kind = TermKind::Element(id, shown.into());
        Some(self.new_term(kind, Type::Domain(id), name.span))
    }

    /// Applies the candidate that fits the arguments best.
    fn best(
        &mut self,
        shown: &str,
        name: &ast::NameText,
        candidates: &[FunctionId],
        arguments: Vec<Term>,
        span: Span,
    ) -> Term {
        // of two equally good candidates, prefer the one declared in this file
        let fitting = candidates.iter().filter_map(|&candidate| {
            let (fit, bindings) = self.fit(candidate, &arguments)?;
            let foreign = self.declared.functions[candidate.0 as usize].span.file != name.span.file;
            Some(((fit, foreign), candidate, bindings))
        });
        let Some((_, function, bindings)) = fitting.min_by_key(|(fit, ..)| *fit) else {
            return self.no_overload(shown, candidates, &arguments, span);
        };
        self.lint_width(function, &arguments);
        let codomain = self.declared.functions[function.0 as usize].codomain;
        let ty = self
            .declared
            .types
            .substitute(codomain, &self.declared.domains, &bindings);
        // `undef` and erroneous terms fit every type and therefore do not determine the type of the
        // result
        let expected = self.declared.functions[function.0 as usize]
            .parameters
            .len();
        let run = self.declared.functions[function.0 as usize].run;
        let kind = match &self.declared.functions[function.0 as usize].meaning {
            Meaning::Constant(atom) => TermKind::Value(Value::Atom(*atom)),
            _ if run.is_some() => {
                let run = run.map(|run| self.variable_of(run, span));
                TermKind::Apply(function, run.into_iter().chain(arguments).collect())
            }
            _ if expected != arguments.len() => match arguments.into_iter().next() {
                Some(tuple) => TermKind::Spread(function, tuple),
                None => TermKind::Invalid,
            },
            Meaning::State
            | Meaning::Defined(_)
            | Meaning::Builtin(_)
            | Meaning::Machine
            | Meaning::Missing => TermKind::Apply(function, arguments),
        };
        Term {
            kind: Box::new(kind),
            ty,
            span,
        }
    }

    /// Warns if the domain of an argument is wider than the declared subset of an abstract domain.
    /// An argument `self` is exempt: the domain of the running agent follows from its program.
    fn lint_width(&mut self, function: FunctionId, arguments: &[Term]) {
        let declared = &self.declared.functions[function.0 as usize];
        if declared.library || declared.parameters.len() != arguments.len() {
            return;
        }
        let (name, span) = (declared.name.clone(), declared.span);
        let pairs: Vec<(TypeId, TypeId, Span)> = declared
            .parameters
            .iter()
            .zip(arguments)
            .filter(|(_, argument)| !self.is_self(argument))
            .map(|(&wanted, argument)| (wanted, argument.ty, argument.span))
            .collect();
        for (wanted, actual, at) in pairs {
            if self.is_wider(actual, wanted) {
                let (expected, actual) = (self.show(wanted), self.show(actual));
                self.error(ArgumentTooWide {
                    name: name.clone(),
                    expected,
                    actual,
                    at,
                    declared: span,
                });
            }
        }
    }

    fn is_self(&self, term: &Term) -> bool {
        matches!(&*term.kind, TermKind::Apply(function, _)
            if &*self.declared.functions[function.0 as usize].name == "self")
    }

    /// Returns `true` if `wide` is an abstract domain or a subset of one, and `narrow` is a subset
    /// of `wide`.
    fn is_wider(&self, wide: TypeId, narrow: TypeId) -> bool {
        let (types, domains) = (&self.declared.types, &self.declared.domains);
        types.is_abstract(wide, domains)
            && wide != narrow
            && matches!(types.get(narrow), Type::Domain(_))
            && types
                .reachable_types(narrow, domains)
                .any(|part| part == wide)
    }

    /// Returns how well a function fits the arguments, with the bindings of its type variables.
    fn fit(&self, function: FunctionId, arguments: &[Term]) -> Option<(u32, TypeBindings)> {
        let declared = &self.declared.functions[function.0 as usize];
        let parameters = &declared.parameters[usize::from(declared.run.is_some())..];
        let types = &self.declared.types;
        let is_equality = declared.library && matches!(&*declared.name, "eq" | "neq");
        let mut bindings = TypeBindings::of(is_equality);
        let actual: Vec<TypeId> = match arguments {
            [tuple] if parameters.len() > 1 && declared.run.is_none() => {
                let root = types.root(tuple.ty, &self.declared.domains);
                let Type::Prod(items) = types.get(root) else {
                    return None;
                };
                items.clone()
            }
            _ => arguments.iter().map(|term| term.ty).collect(),
        };
        if parameters.len() != actual.len() {
            return None;
        }
        let mut total = 0u32;
        for (&wanted, &actual) in parameters.iter().zip(&actual) {
            let fit = types.fit(wanted, actual, &self.declared.domains, &mut bindings)?;
            total = fit.saturating_add(total);
        }
        Some((total, bindings))
    }

    fn no_overload(
        &mut self,
        name: &str,
        candidates: &[FunctionId],
        arguments: &[Term],
        span: Span,
    ) -> Term {
        if arguments
            .iter()
            .any(|term| *self.declared.types.get(term.ty) == Type::Invalid)
        {
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
                let types: Vec<String> = function
                    .parameters
                    .iter()
                    .map(|&ty| self.show(ty))
                    .collect();
                (format!("takes ({})", types.join(", ")), function.span)
            })
            .collect();
        let roots: Vec<String> = arguments
            .iter()
            .map(|term| self.show(self.declared.types.root(term.ty, &self.declared.domains)))
            .collect();
        let hint = overload_hint(&roots);
        let numbers = self.respelt(candidates, arguments, &roots);
        self.error(NoOverload {
            name: Arc::from(name),
            at: span,
            actual,
            candidates: own,
            hint,
            numbers,
            comparison: None,
        });
        self.invalid(span)
    }

    pub fn rule_ref(&mut self, name: &ast::NameText, domains: &[ast::Type], span: Span) -> Term {
        let domains: Vec<TypeId> = domains
            .iter()
            .map(|domain| self.declared.resolve_type(self.unit, domain))
            .collect();
        let candidates = self.declared.scopes[self.unit]
            .rules
            .get(&name.text)
            .cloned()
            .unwrap_or_default();
        // the domains select the overload; without them, the first rule is taken
        let best = candidates.iter().copied().filter_map(|id| {
            let fit = if domains.is_empty() {
                Some(0)
            } else {
                self.rule_fit(id, &domains)
            };
            Some((fit?, id))
        });
        match best.min() {
            Some((_, rule)) => self.new_term(TermKind::Rule(rule), Type::Rule, span),
            None => {
                self.unknown_rule(name);
                self.invalid(span)
            }
        }
    }

    pub fn unknown_rule(&mut self, name: &ast::NameText) {
        let hidden = self.declared.hidden(self.unit, &name.text, NameKind::Rule);
        if hidden.is_none() && self.declared.is_lost(self.unit, &name.text, NameKind::Rule) {
            return;
        }
        let scope = &self.declared.scopes[self.unit];
        let similar = scope.similar_rule(&name.text).map(|found| {
            let declared = scope.rules.get(&found).and_then(|ids| ids.first());
            let span =
                declared.map_or_else(Span::default, |id| self.declared.rules[id.0 as usize].span);
            (found, span)
        });
        self.error(UnknownRule {
            name: name.text.clone(),
            at: name.span,
            similar,
            hidden,
        });
    }

    /// Returns how well the parameters of a rule fit the arguments; smaller is better.
    fn rule_fit(&self, rule: RuleId, actual: &[TypeId]) -> Option<u32> {
        let parameters = &self.declared.rules[rule.0 as usize].parameters;
        if parameters.len() != actual.len() {
            return None;
        }
        let (types, domains) = (&self.declared.types, &self.declared.domains);
        let mut bindings = TypeBindings::default();
        let mut pairs = parameters.iter().zip(actual);
        pairs.try_fold(0u32, |sum, (&wanted, &actual)| {
            let fit = types.fit(wanted, actual, domains, &mut bindings)?;
            Some(fit.saturating_add(sum))
        })
    }

    /// Returns the rule of this name that fits the arguments best.
    pub fn callee(&mut self, name: &ast::NameText, arguments: &[Term]) -> Option<RuleId> {
        let candidates = self.declared.scopes[self.unit]
            .rules
            .get(&name.text)
            .cloned()
            .unwrap_or_default();
        let Some(&first) = candidates.first() else {
            self.unknown_rule(name);
            return None;
        };
        let types: Vec<TypeId> = arguments.iter().map(|argument| argument.ty).collect();
        let fitting = candidates
            .iter()
            .filter_map(|&id| Some((self.rule_fit(id, &types)?, id)));
        if let Some((_, id)) = fitting.min() {
            return Some(id);
        }
        let rule = &self.declared.rules[first.0 as usize];
        let (declared, parameters) = (rule.span, rule.parameters.clone());
        if parameters.len() == arguments.len() {
            let what = format!("`{}`", name.text);
            let mut fits = true;
            for (&wanted, argument) in parameters.iter().zip(arguments) {
                fits &= self.compatible(wanted, argument.ty);
                self.expect(argument, wanted, &what, Some((declared, "takes")));
            }
            if fits {
                // two arguments of one type variable can each fit and still disagree with each
                // other
                for (index, argument) in arguments.iter().enumerate() {
                    let same = |&other: &usize| parameters[other] == parameters[index];
                    if let Some(first) = (0..index).find(same) {
                        let expected = types[first];
                        self.expect(argument, expected, &what, Some((declared, "takes")));
                    }
                }
            }
        } else {
            self.error(WrongArity {
                name: name.text.clone(),
                expected: parameters.len(),
                actual: arguments.len(),
                at: name.span,
                declared,
            });
        }
        None
    }
}

/// Suggests how to write numbers of different domains in one term.
fn is_comparison(operator: Operator) -> bool {
    matches!(
        operator,
        Operator::Eq | Operator::Neq | Operator::Lt | Operator::Le | Operator::Gt | Operator::Ge
    )
}

fn overload_hint(types: &[String]) -> Option<String> {
    let has = |name: &str| types.iter().any(|ty| ty == name);
    if has("Integer") && has("Real") {
        Some(
            "Integer and Real do not mix: write `1.0` instead of `1`, or convert with `itor(…)`"
                .to_owned(),
        )
    } else if has("Natural") && has("Real") {
        Some("Natural and Real do not mix: convert with `ntor(…)`".to_owned())
    } else if has("Integer") && has("Natural") {
        Some("Integer and Natural do not mix here: write `1n`, or convert with `iton(…)` or `ntoi(…)`".to_owned())
    } else {
        None
    }
}
