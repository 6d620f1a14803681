//! Resolution of rules.

use crate::codes::a007::TypeMismatch;
use crate::codes::a014::WritesMonitored;
use crate::codes::a016::WritesFixed;
use crate::codes::a024::RuleWithoutResult;
use crate::codes::a025::WrongCallForm;
use crate::codes::a026::CannotExtend;
use crate::codes::a028::NotARule;
use crate::codes::a034::WritesReserved;
use crate::codes::w020::WritesVariable;
use crate::codes::w022::ResultUndeclared;
use crate::codes::w023::ReturnsToMonitored;
use crate::codes::w027::ExtendsStatic;
use crate::model::kind_name;
use crate::model::{
    DomainKind, FunctionId, FunctionKind, LocalFunctions, Meaning, RuleKind, RuleTerm, Term,
    TermKind, UpdateTarget,
};
use crate::resolver::Resolver;
use crate::types::{Type, TypeId};
use asmotion_diagnostics::{Diagnostic, Finding, Span};
use asmotion_syntax::ast;
use asmotion_value::RuleId;

impl Resolver<'_> {
    pub fn rule(&mut self, rule: &ast::Rule) -> RuleTerm {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            let kind = self.rule_kind(rule);
            RuleTerm {
                kind: Box::new(kind),
                span: rule.span,
            }
        })
    }

    fn rule_kind(&mut self, rule: &ast::Rule) -> RuleKind {
        match &*rule.kind {
            ast::RuleKind::Skip => RuleKind::Skip,
            ast::RuleKind::Update { target, value } => self.update(target, value),
            ast::RuleKind::Assign {
                target,
                rule,
                arguments,
            } => self.assign(target, rule, arguments),
            ast::RuleKind::Macro { name, arguments } => self.call(name, arguments, false),
            ast::RuleKind::Turbo { name, arguments } => self.call(name, arguments, true),
            ast::RuleKind::Term { term, arguments } => self.run(term, arguments),
            ast::RuleKind::Par(rules) => RuleKind::Par(self.block(rules)),
            ast::RuleKind::Seq(rules) => RuleKind::Seq(self.block(rules)),
            ast::RuleKind::If {
                guard,
                then,
                otherwise,
            } => {
                let guard = self.boolean(guard, "a guard");
                let then = self.rule(then);
                RuleKind::If(guard, then, otherwise.as_ref().map(|rule| self.rule(rule)))
            }
            ast::RuleKind::Switch(switch) => self.switch_rule(switch),
            ast::RuleKind::Choose {
                binders,
                guard,
                body,
                ifnone,
            } => {
                self.declared.chooses = true;
                let chosen = self.scoped(|this| {
                    let binders = this.binders(binders);
                    let guard = guard.as_ref().map(|guard| this.boolean(guard, "a guard"));
                    (binders, guard, this.rule(body))
                });
                let ifnone = ifnone.as_ref().map(|rule| self.rule(rule));
                RuleKind::Choose(chosen.0, chosen.1, chosen.2, ifnone)
            }
            ast::RuleKind::Forall {
                binders,
                guard,
                body,
            } => self.scoped(|this| {
                let binders = this.binders(binders);
                let guard = guard.as_ref().map(|guard| this.boolean(guard, "a guard"));
                RuleKind::Forall(binders, guard, this.rule(body))
            }),
            ast::RuleKind::Let { bindings, body } => self.scoped(|this| {
                let bindings = this.bindings(bindings);
                RuleKind::Let(bindings, this.rule(body))
            }),
            ast::RuleKind::Extend {
                domain,
                variables,
                body,
            } => self.extend(domain, variables, body),
            ast::RuleKind::While { guard, body } => {
                let guard = self.boolean(guard, "a guard");
                RuleKind::While(guard, self.rule(body))
            }
            ast::RuleKind::WhileRec { guard, body } => {
                let guard = self.boolean(guard, "a guard");
                RuleKind::WhileRec(guard, self.rule(body))
            }
            ast::RuleKind::Iterate(body) => RuleKind::Iterate(self.rule(body)),
            ast::RuleKind::Local { functions, body } => self.local(functions, body),
            ast::RuleKind::Invalid => {
                self.mark_incomplete();
                RuleKind::Invalid
            }
        }
    }

    fn block(&mut self, rules: &[ast::Rule]) -> Vec<RuleTerm> {
        rules.iter().map(|rule| self.rule(rule)).collect()
    }

    fn update(&mut self, target: &ast::Assignee, value: &ast::Term) -> RuleKind {
        let value = self.term(value);
        match self.target(target, WriteForm::Update) {
            Some((target, wanted, what, declared)) => {
                self.expect(&value, wanted, &what, Some((declared, "declared")));
                RuleKind::Update(target, value)
            }
            None => RuleKind::Invalid,
        }
    }

    fn assign(
        &mut self,
        target: &ast::Assignee,
        rule: &ast::NameText,
        arguments: &[ast::Term],
    ) -> RuleKind {
        let arguments = self.terms(arguments);
        let target = self.target(target, WriteForm::Return);
        let Some(callee) = self.callee(rule, &arguments) else {
            return RuleKind::Invalid;
        };
        let Some((target, wanted, what, location)) = target else {
            return RuleKind::Invalid;
        };
        let Some(result) = self.result_of(rule, callee) else {
            return RuleKind::Invalid;
        };
        if !self.compatible(wanted, result) {
            let (expected, actual) = (self.show(wanted), self.show(result));
            let error = TypeMismatch {
                what,
                expected,
                actual,
                at: rule.span,
                because: Some((location, "declared")),
                numbers: Vec::new(),
            };
            self.error(error);
        }
        RuleKind::Assign(target, callee, arguments)
    }

    /// Returns the result type of a turbo rule; a rule that declares none may return any value.
    fn result_of(&mut self, name: &ast::NameText, callee: RuleId) -> Option<TypeId> {
        let rule = &self.declared.rules[callee.0 as usize];
        let (declared, turbo, result) = (rule.span, rule.turbo, rule.result);
        if result.is_none() {
            let (name, at) = (name.text.clone(), name.span);
            if turbo {
                self.error(ResultUndeclared { name, at, declared })
            } else {
                self.error(RuleWithoutResult { name, at, declared })
            }
            return turbo.then(|| self.ty(Type::Undef));
        }
        result
    }

    /// Resolves the left-hand side of an update; returns it with its type, its name and the span of
    /// its declaration.
    fn target(
        &mut self,
        target: &ast::Assignee,
        writer: WriteForm,
    ) -> Option<(UpdateTarget, TypeId, String, Span)> {
        match target {
            ast::Assignee::Variable(name) => {
                let Some(id) = self.lookup(&name.text) else {
                    self.unknown_variable(name);
                    return None;
                };
                let (ty, bound) = (self.variable(id).ty, self.variable(id).span);
                if !self.stands_for_location(id) {
                    self.error(WritesVariable {
                        name: name.text.clone(),
                        at: name.span,
                        bound,
                    });
                }
                Some((
                    UpdateTarget::Variable(id),
                    ty,
                    format!("`{}`", name.text),
                    bound,
                ))
            }
            ast::Assignee::Location {
                agent,
                function,
                arguments,
                span,
            } => {
                let mut all = Vec::new();
                if let Some(agent) = agent {
                    all.push(self.apply(agent, Vec::new(), agent.span));
                }
                all.extend(self.terms(arguments));
                let applied = self.apply(function, all, *span);
                self.location(function, applied, writer)
            }
        }
    }

    fn location(
        &mut self,
        name: &ast::NameText,
        applied: Term,
        writer: WriteForm,
    ) -> Option<(UpdateTarget, TypeId, String, Span)> {
        if let TermKind::Value(_) = *applied.kind {
            let constant = self.declared.scopes[self.unit].functions.get(&name.text);
            let declared = constant
                .and_then(|ids| ids.first())
                .map_or(name.span, |id| self.declared.functions[id.0 as usize].span);
            let function = name.text.clone();
            self.error(WritesFixed {
                function,
                kind: "static",
                at: name.span,
                declared,
            });
        }
        let (id, arguments) = applied.kind.into_application()?;
        let function = &self.declared.functions[id.0 as usize];
        let (kind, declared) = (function.kind, function.span);
        let mut ty = function.codomain;
        if self.is_result(id) {
            ty = self.result.unwrap_or(ty);
        } else if matches!(function.meaning, Meaning::Machine) && kind == FunctionKind::Controlled {
            self.error(WritesReserved {
                function: name.text.clone(),
                at: name.span,
            });
            return None;
        } else if !self.may_write(kind)
            && let Some(error) = forbidden(name, kind, declared, writer)
        {
            let fatal = !error.is_any(&[ReturnsToMonitored::CODE]);
            self.declared.report.push(error);
            if fatal {
                return None;
            }
        }
        Some((
            UpdateTarget::Location(id, arguments),
            ty,
            format!("`{}`", name.text),
            declared,
        ))
    }

    fn is_result(&self, id: FunctionId) -> bool {
        let function = &self.declared.functions[id.0 as usize];
        &*function.name == "result" && matches!(function.meaning, Meaning::Machine)
    }

    fn call(&mut self, name: &ast::NameText, arguments: &[ast::Term], turbo: bool) -> RuleKind {
        let arguments = self.terms(arguments);
        let Some(rule) = self.callee(name, &arguments) else {
            return RuleKind::Invalid;
        };
        let declared = &self.declared.rules[rule.0 as usize];
        if declared.turbo != turbo {
            let (is, want) = if declared.turbo {
                ("turbo", "call a turbo rule with parentheses: `r_x(…)`")
            } else {
                ("macro", "call a macro rule with square brackets: `r_x[…]`")
            };
            let declared = declared.span;
            self.error(WrongCallForm {
                name: name.text.clone(),
                is,
                want,
                at: name.span,
                declared,
            });
        }
        RuleKind::Call(rule, arguments)
    }

    fn run(&mut self, term: &ast::Term, arguments: &[ast::Term]) -> RuleKind {
        let term = self.term(term);
        let arguments = self.terms(arguments);
        let rule = self.ty(Type::Rule);
        if !self.compatible(rule, term.ty) {
            let actual = self.show(term.ty);
            self.error_if_complete(NotARule {
                actual,
                at: term.span,
            });
            return RuleKind::Invalid;
        }
        RuleKind::Run(term, arguments)
    }

    fn switch_rule(&mut self, switch: &ast::SwitchRule) -> RuleKind {
        let subject = self.term(&switch.subject);
        let mut cases = Vec::new();
        for (case, rule) in &switch.cases {
            let case = self.case(&subject, case);
            cases.push((case, self.rule(rule)));
        }
        let otherwise = switch.otherwise.as_ref().map(|rule| self.rule(rule));
        RuleKind::Switch(subject, cases, otherwise)
    }

    fn extend(
        &mut self,
        domain: &ast::NameText,
        variables: &[ast::NameText],
        body: &ast::Rule,
    ) -> RuleKind {
        let ty = ast::Type {
            kind: ast::TypeKind::Named(domain.text.clone()),
            span: domain.span,
        };
        let ty = self.declared.resolve_type(self.unit, &ty);
        let id = self.declared.types.get(ty).as_domain();
        let extensible = self.is_extensible(ty);
        let body = self.scoped(|this| {
            let variables = variables.iter().map(|name| this.bind(name, ty)).collect();
            (variables, this.rule(body))
        });
        let Some(id) = id else {
            if *self.declared.types.get(ty) != Type::Invalid {
                let kind = "a basic domain";
                let error = CannotExtend {
                    domain: domain.text.clone(),
                    kind,
                    at: domain.span,
                    declared: domain.span,
                };
                self.error(error);
            }
            return RuleKind::Invalid;
        };
        if !extensible {
            let kind = match self.declared.domains[id.0 as usize].kind {
                DomainKind::Enum { .. } => "an enumeration",
                DomainKind::Any => "an anydomain",
                DomainKind::Basic => "a basic domain",
                DomainKind::Concrete { .. } => "a subset of a basic domain",
                DomainKind::Abstract => "abstract",
            };
            let declared = self.declared.domains[id.0 as usize].span;
            self.error(CannotExtend {
                domain: domain.text.clone(),
                kind,
                at: domain.span,
                declared,
            });
        }
        let extended = &self.declared.domains[id.0 as usize];
        if extensible && !extended.dynamic {
            let declared = extended.span;
            self.error(ExtendsStatic {
                domain: domain.text.clone(),
                at: domain.span,
                declared,
            });
        }
        RuleKind::Extend(id, body.0, body.1)
    }

    /// Resolves `local f: D [R] … S`. The functions are visible only in the rules `R` and `S`.
    fn local(&mut self, functions: &[(ast::Function, ast::Rule)], body: &ast::Rule) -> RuleKind {
        let Some((first, _)) = functions.first() else {
            return self.rule(body).kind.as_ref().clone();
        };
        let integer = self.ty(Type::Integer);
        let run = ast::NameText {
            text: "local".into(),
            span: first.name.span,
        };
        let outer = self.declared.scopes[self.unit].functions.clone();
        let local = self.scoped(|this| {
            let run = this.bind(&run, integer);
            for (function, _) in functions {
                this.declared.local_function(this.unit, function, run);
            }
            let initial = functions.iter().map(|(_, rule)| this.rule(rule)).collect();
            let body = this.rule(body);
            LocalFunctions { run, initial, body }
        });
        self.declared.scopes[self.unit].functions = outer;
        RuleKind::Local(local)
    }

    /// Returns `true` if `extend` can add elements to a domain: it is abstract or a subset of an
    /// abstract one.
    fn is_extensible(&self, ty: TypeId) -> bool {
        self.declared.types.is_abstract(ty, &self.declared.domains)
    }
}

/// The rule form that updates a location.
#[derive(Clone, Copy)]
enum WriteForm {
    /// `f := t`
    Update,
    /// `f <- r_x(…)`
    Return,
}

/// Returns the finding for an update of a function that no rule may update, or `None` if it may be
/// updated.
fn forbidden(
    name: &ast::NameText,
    kind: FunctionKind,
    declared: Span,
    writer: WriteForm,
) -> Option<Diagnostic> {
    let function = name.text.clone();
    let at = name.span;
    match kind {
        FunctionKind::Controlled
        | FunctionKind::Out
        | FunctionKind::Shared
        | FunctionKind::Local => None,
        FunctionKind::Monitored => Some(match writer {
            WriteForm::Update => WritesMonitored {
                function,
                at,
                declared,
            }
            .diagnostic(),
            WriteForm::Return => ReturnsToMonitored {
                function,
                at,
                declared,
            }
            .diagnostic(),
        }),
        FunctionKind::Static | FunctionKind::Derived => Some(
            WritesFixed {
                function,
                kind: kind_name(kind),
                at,
                declared,
            }
            .diagnostic(),
        ),
    }
}
