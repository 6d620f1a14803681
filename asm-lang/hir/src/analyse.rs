//! From trees to a model: declarations, then definitions, rules, properties and the initial state.

use crate::added::merged_scope;
use crate::codes::a001::UnknownFunction;
use crate::codes::a002::UnknownVariable;
use crate::codes::a003::UnknownRule;
use crate::codes::a004::UnknownDomain;
use crate::codes::a005::UnknownConstant;
use crate::codes::a006::NoOverload;
use crate::codes::a008::WrongArity;
use crate::codes::a009::DuplicateDeclaration;
use crate::codes::a020::DefinesUndeclared;
use crate::codes::a021::DefinesWrongKind;
use crate::codes::a023::MainParameters;
use crate::codes::a027::NoSuchInit;
use crate::codes::a028::NotARule;
use crate::codes::w002::FileNameDiffers;
use crate::codes::w004::EmptyDomain;
use crate::codes::w005::NoMainRule;
use crate::codes::w024::DefinesItself;
use crate::codes::w029::NothingChosen;
use crate::codes::w031::PropertiesNotVerified;
use crate::declare::{SignatureTables, declare};
use crate::hidden::NameKind;
use crate::load::LoadedFiles;
use crate::model::{
    Added, AgentProgram, Body, DomainKind, FunctionId, FunctionKind, Invariant, Meaning, Model,
    PropertyLogic, Reserved, TemporalProperty, Term, Variable, kind_name,
};
use crate::notation::temporal_notation;
use crate::options::ReadOptions;
use crate::resolver::Resolver;
use crate::types::{Type, TypeId};
use asmotion_diagnostics::{
    Code, Diagnostic, FileId, Finding, Fix, Label, Report, Sources, Span, did_you_mean, similar,
};
use asmotion_syntax::ast;
use asmotion_value::RuleId;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// As [`analyse_with`], with the default options.
pub fn analyse(loaded: &mut LoadedFiles, sources: &Sources) -> (Option<Model>, Report) {
    analyse_with(loaded, sources, &ReadOptions::default())
}

/// Resolves and types all loaded files. If no model is returned, one of the reports contains errors.
/// A name that may come from an import that could not be loaded has no finding of its own; instead,
/// a note with these names is added to the finding about the import.
pub fn analyse_with(
    loaded: &mut LoadedFiles,
    sources: &Sources,
    options: &ReadOptions,
) -> (Option<Model>, Report) {
    let Some(main) = loaded.units.last() else {
        return (None, Report::new());
    };
    let declared = declare(&loaded.units, options.compatible);
    let rules = declared.rules.iter().zip(0..);
    let mut analysis = Analysis {
        rule_ids: rules.map(|(rule, id)| (rule.span, RuleId(id))).collect(),
        declared,
        invariants: Vec::new(),
        properties: Vec::new(),
        programs: Vec::new(),
        sources,
        options,
    };
    for (index, unit) in loaded.units.iter().enumerate() {
        analysis.definitions(index, &unit.tree);
        analysis.rules(index, &unit.tree);
        analysis.properties(index, &unit.tree, unit.library);
    }
    let last = loaded.units.len() - 1;
    analysis.initial_state(last, &main.tree);
    let main_rule = analysis.main_rule(main);
    analysis.lint_schedule(&main.tree);
    analysis.undefined_domains();
    let report = std::mem::take(&mut analysis.declared.report);
    for failed in &analysis.declared.failed_imports {
        failed.note(&mut loaded.report.diagnostics);
    }
    let report = each_name_once(without_unread(report, loaded, sources));
    if report.has_errors() || loaded.report.has_errors() {
        return (None, report);
    }
    let name = main
        .tree
        .name
        .as_ref()
        .map_or_else(|| Arc::from(""), |name| name.text.clone());
    (Some(analysis.finish(name, main_rule)), report)
}

/// Returns a warning if the specification has temporal properties, which no run verifies; `is_watched` selects those that every
/// step of a run checks.
pub fn unverified_properties(
    model: &Model,
    is_watched: impl Fn(&TemporalProperty) -> bool,
) -> Option<Diagnostic> {
    let unwatched = model.properties.iter().filter(|it| !is_watched(it));
    let at = unwatched.clone().next()?.span;
    let count = unwatched.count();
    Some(PropertiesNotVerified { count, at }.diagnostic())
}

struct Analysis<'a> {
    declared: SignatureTables,
    /// The rules of all files by the span of the name.
    rule_ids: BTreeMap<Span, RuleId>,
    invariants: Vec<Invariant>,
    properties: Vec<TemporalProperty>,
    programs: Vec<AgentProgram>,
    sources: &'a Sources,
    options: &'a ReadOptions,
}

impl Analysis<'_> {
    fn resolver(&mut self, unit: usize) -> Resolver<'_> {
        Resolver::new(&mut self.declared, unit)
    }

    /// Resolves a term without free variables and checks its type.
    fn expression(
        &mut self,
        unit: usize,
        term: &ast::Term,
        expected: TypeId,
        what: &str,
        declared: Option<Span>,
    ) -> Body<Term> {
        let mut resolver = self.resolver(unit);
        let root = resolver.term(term);
        resolver.expect(
            &root,
            expected,
            what,
            declared.map(|declared| (declared, "declared as subset of")),
        );
        resolver.body(0, root)
    }

    fn condition(&mut self, unit: usize, term: &ast::Term, what: &str) -> Body<Term> {
        let boolean = self.declared.types.id(Type::Boolean);
        self.expression(unit, term, boolean, what, None)
    }

    fn definitions(&mut self, unit: usize, tree: &ast::File) {
        for definition in &tree.domain_definitions {
            self.domain_definition(unit, definition);
        }
        for definition in &tree.function_definitions {
            if let Some((id, body)) =
                self.function_definition(unit, definition, Purpose::Definition)
            {
                let known = match &self.declared.functions[id.0 as usize].meaning {
                    Meaning::Defined(known) => Some(known.root.span),
                    Meaning::State
                    | Meaning::Builtin(_)
                    | Meaning::Constant(_)
                    | Meaning::Machine
                    | Meaning::Missing => None,
                };
                if let Meaning::Constant(_) = self.declared.functions[id.0 as usize].meaning {
                    let error = DefinesItself {
                        name: definition.name.text.clone(),
                        at: definition.name.span,
                    };
                    self.declared.report.push(error.diagnostic());
                    continue;
                }
                self.check_unique(&definition.name, known);
                self.declared.functions[id.0 as usize].meaning = Meaning::Defined(body);
            }
        }
    }

    /// Reports a duplicate declaration if the name is already known.
    fn check_unique(&mut self, name: &ast::NameText, known: Option<Span>) {
        if let Some(first) = known {
            let error = DuplicateDeclaration {
                name: name.text.clone(),
                at: name.span,
                first,
            };
            self.declared.report.push(error.diagnostic());
        }
    }

    fn domain_definition(&mut self, unit: usize, definition: &ast::DomainDefinition) {
        let name = &definition.name;
        let Some(&id) = self.declared.scopes[unit].domains.get(&name.text) else {
            return self.declared.unknown_domain(unit, &name.text, name.span);
        };
        let declared = self.declared.domains[id.0 as usize].span;
        let DomainKind::Concrete { base } = self.declared.domains[id.0 as usize].kind else {
            let error = DefinesWrongKind {
                name: name.text.clone(),
                kind: "not a subset of another domain",
                why: "only `subsetof` domains are defined by their elements",
                help: "remove this definition",
                at: name.span,
                declared: Some(declared),
            };
            return self.declared.report.push(error.diagnostic());
        };
        let expected = self.declared.types.id(Type::Powerset(base));
        let what = format!("`{}`", name.text);
        let body = self.expression(unit, &definition.body, expected, &what, Some(declared));
        self.declared.domains[id.0 as usize].definition = Some(body);
    }

    /// Resolves `function f($x in D) = term`; the domains of the parameters select the overload.
    fn function_definition(
        &mut self,
        unit: usize,
        definition: &ast::FunctionDefinition,
        purpose: Purpose,
    ) -> Option<(FunctionId, Body<Term>)> {
        let name = &definition.name;
        let parameters: Vec<TypeId> = definition
            .parameters
            .iter()
            .map(|parameter| self.declared.resolve_type(unit, &parameter.domain))
            .collect();
        let id = self.defined_function(unit, name, &parameters)?;
        let function = &self.declared.functions[id.0 as usize];
        let (codomain, declared, kind) = (function.codomain, function.span, function.kind);
        let reserved = matches!(function.meaning, Meaning::Machine);
        let is_library = function.library;
        if let Some((why, help)) = purpose.forbids(kind, reserved) {
            let error = DefinesWrongKind {
                name: name.text.clone(),
                kind: kind_name(kind),
                why,
                help,
                at: name.span,
                declared: (!is_library).then_some(declared),
            };
            self.declared.report.push(error.diagnostic());
            return None;
        }
        let mut resolver = self.resolver(unit);
        for (parameter, &ty) in definition.parameters.iter().zip(&parameters) {
            resolver.bind(&parameter.name, ty);
        }
        let root = resolver.term(&definition.body);
        resolver.expect(
            &root,
            codomain,
            &format!("`{}`", name.text),
            Some((declared, "declared")),
        );
        let count = definition.parameters.len();
        let body = resolver.body(count, root);
        Some((id, body))
    }

    fn defined_function(
        &mut self,
        unit: usize,
        name: &ast::NameText,
        parameters: &[TypeId],
    ) -> Option<FunctionId> {
        if let Some(id) = self.declared.overload(unit, &name.text, parameters) {
            return Some(id);
        }
        let candidates = self.declared.scopes[unit]
            .functions
            .get(&name.text)
            .cloned()
            .unwrap_or_default();
        let fitting: Vec<FunctionId> = candidates
            .iter()
            .copied()
            .filter(|id| {
                let declared = &self.declared.functions[id.0 as usize].parameters;
                let fits = |(&a, &b): (&TypeId, &TypeId)| {
                    self.declared.types.compatible(a, b, &self.declared.domains)
                };
                declared.len() == parameters.len() && declared.iter().zip(parameters).all(fits)
            })
            .collect();
        if let Some(&id) = fitting.first() {
            return Some(id);
        }
        let Some(&first) = candidates.first() else {
            let similar = similar(&name.text, self.declared.scopes[unit].functions.keys())
                .map(|found| (found.clone(), self.first_span(unit, found)));
            let hidden = self.declared.hidden(unit, &name.text, NameKind::Function);
            if hidden.is_none() && self.declared.is_lost(unit, &name.text, NameKind::Function) {
                return None;
            }
            let error = DefinesUndeclared {
                name: name.text.clone(),
                at: name.span,
                similar,
                hidden,
            };
            self.declared.report.push(error.diagnostic());
            return None;
        };
        let function = &self.declared.functions[first.0 as usize];
        let error = WrongArity {
            name: name.text.clone(),
            expected: function.parameters.len(),
            actual: parameters.len(),
            at: name.span,
            declared: function.span,
        };
        self.declared.report.push(error.diagnostic());
        None
    }

    fn first_span(&self, unit: usize, name: &str) -> Span {
        let known = self.declared.scopes[unit].functions.get(name);
        known
            .and_then(|ids| ids.first())
            .map_or_else(Span::default, |id| {
                self.declared.functions[id.0 as usize].span
            })
    }

    fn rules(&mut self, unit: usize, tree: &ast::File) {
        for rule in tree.rules.iter().chain(&tree.main) {
            let Some(&id) = self.rule_ids.get(&rule.name.span) else {
                continue;
            };
            let parameters = self.declared.rules[id.0 as usize].parameters.clone();
            let result = self.declared.rules[id.0 as usize].result;
            let mut resolver = self.resolver(unit);
            resolver.enter(rule.parameters.len(), rule.turbo, result);
            for (parameter, ty) in rule.parameters.iter().zip(parameters) {
                resolver.bind(&parameter.name, ty);
            }
            let root = resolver.rule(&rule.body);
            let body = resolver.body(rule.parameters.len(), root);
            self.declared.rules[id.0 as usize].body = Some(body);
        }
    }

    fn properties(&mut self, unit: usize, tree: &ast::File, library: bool) {
        if library {
            return;
        }
        for property in &tree.properties {
            let (logic, formulas) = match &property.kind {
                ast::PropertyKind::Invariant { body, .. } => {
                    let first_finding = self.declared.report.diagnostics.len();
                    let condition = self.condition(unit, body, "an invariant");
                    self.explain_notations(first_finding, PropertyLogic::Ctl);
                    let name = match &property.name {
                        Some(name) => name.text.clone(),
                        None => Arc::from(self.sources.snippet(body.span)),
                    };
                    self.invariants.push(Invariant {
                        name,
                        condition,
                        span: property.span,
                    });
                    continue;
                }
                ast::PropertyKind::Constraint(body) => (PropertyLogic::Constraint, vec![body]),
                ast::PropertyKind::Justice(body) => (PropertyLogic::Justice, vec![body]),
                ast::PropertyKind::Compassion(p, q) => (PropertyLogic::Compassion, vec![p, q]),
                ast::PropertyKind::Ctl(body) => (PropertyLogic::Ctl, vec![body]),
                ast::PropertyKind::Ltl(body) => (PropertyLogic::Ltl, vec![body]),
            };
            let text = formulas
                .first()
                .map_or("", |body| self.sources.snippet(body.span));
            let text = Arc::from(text);
            let first_finding = self.declared.report.diagnostics.len();
            let formulas = formulas
                .into_iter()
                .map(|body| self.condition(unit, body, "a property"))
                .collect();
            self.explain_notations(first_finding, logic);
            let name = property.name.as_ref().map(|name| name.text.clone());
            self.properties.push(TemporalProperty {
                name,
                text,
                logic,
                formulas,
                span: property.span,
            });
        }
    }

    /// Names the operators to write in place of unknown names that are operators in other notations, in the findings about a property.
    fn explain_notations(&mut self, first_finding: usize, logic: PropertyLogic) {
        let findings = &mut self.declared.report.diagnostics;
        let unknown = [UnknownFunction::CODE, UnknownConstant::CODE];
        for finding in findings.iter_mut().skip(first_finding) {
            let place = finding.primary.as_ref().map(|label| label.span);
            let word = place.map_or("", |place| self.sources.snippet(place));
            if finding.is_any(&unknown)
                && let Some((operator, meaning)) = temporal_notation(word, Some(logic))
            {
                finding.helps = vec![format!("{meaning}: write `{operator}`")];
                finding.fix = None;
            }
        }
    }

    fn initial_state(&mut self, unit: usize, tree: &ast::File) {
        let selected = self.requested_init(tree);
        // the initial states that were not selected are only checked
        for (index, init) in tree.inits.iter().enumerate() {
            let is_selected = selected == Some(index);
            for definition in &init.domains {
                // the reference simulator ignores the initial elements of dynamic domains
                if is_selected && !self.options.compatible {
                    self.domain_definition(unit, definition);
                }
            }
            for definition in &init.functions {
                let resolved = self.function_definition(unit, definition, Purpose::Initial);
                if let (Some((id, body)), true) = (resolved, is_selected) {
                    let known = self.declared.functions[id.0 as usize].initial.as_ref();
                    self.check_unique(&definition.name, known.map(|known| known.root.span));
                    self.declared.functions[id.0 as usize].initial = Some(body);
                }
            }
            for agent in &init.agents {
                if let (Some(program), true) = (self.program(unit, agent), is_selected) {
                    self.programs.push(program);
                }
            }
        }
    }

    /// Returns the index of the initial state to use: the requested one, or else the default.
    fn requested_init(&mut self, tree: &ast::File) -> Option<usize> {
        let first = tree.inits.first()?;
        let at = first.name.span;
        let mut inits = tree.inits.iter();
        let found = match &self.options.initial {
            Some(name) => inits.position(|init| *init.name.text == **name),
            None => inits.position(|init| init.default),
        };
        if found.is_none() {
            let names = tree.inits.iter().map(|init| &init.name.text);
            let (wanted, help) = match &self.options.initial {
                Some(name) => (format!("called `{name}`"), suggestion(name, names)),
                None => (
                    "the default".to_owned(),
                    "write `default init` for the one to start from".to_owned(),
                ),
            };
            let error = NoSuchInit {
                expected: wanted,
                at,
                help,
            };
            self.declared.report.push(error.diagnostic());
        }
        found
    }

    fn program(&mut self, unit: usize, agent: &ast::AgentInit) -> Option<AgentProgram> {
        let name = &agent.domain;
        // like the reference, an agent finds its domain in imported files without regard to exports
        let scopes = &self.declared.scopes;
        let mut scopes = std::iter::once(&scopes[unit]).chain(scopes.iter().rev());
        let Some(domain) = scopes.find_map(|scope| scope.domains.get(&name.text).copied()) else {
            self.declared.unknown_domain(unit, &name.text, name.span);
            return None;
        };
        let mut resolver = self.resolver(unit);
        let arguments: Vec<Term> = agent
            .arguments
            .iter()
            .map(|term| resolver.term(term))
            .collect();
        let rule = resolver.callee(&agent.rule, &arguments)?;
        let variables: Vec<Variable> = resolver.variables();
        let arguments = arguments
            .into_iter()
            .map(|root| Body {
                parameters: 0,
                variables: variables.clone(),
                root,
            })
            .collect();
        Some(AgentProgram {
            domain,
            rule,
            arguments,
        })
    }

    /// Warns about an `asyncr` machine without any `choose`: such a machine always runs all its
    /// agents.
    fn lint_schedule(&mut self, tree: &ast::File) {
        if let (true, Some(main), false) = (tree.asyncr, &tree.main, self.declared.chooses) {
            let at = main.name.span;
            self.declared.report.push(NothingChosen { at }.diagnostic());
        }
    }

    fn main_rule(&mut self, main: &crate::load::SourceUnit) -> Option<RuleId> {
        let tree = &main.tree;
        if let Some(name) = &tree.name {
            let stem = std::path::Path::new(&main.path)
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy();
            if *stem != *name.text && !stem.is_empty() && !main.path.starts_with('<') {
                let error = FileNameDiffers {
                    name: name.text.clone(),
                    stem: stem.into_owned(),
                    at: name.span,
                };
                self.declared.report.push(error.diagnostic());
            }
        }
        let Some(rule) = &tree.main else {
            if let (Some(name), false) = (&tree.name, tree.module) {
                let error = NoMainRule {
                    name: name.text.clone(),
                    at: name.span,
                };
                self.declared.report.push(error.diagnostic());
            }
            return None;
        };
        if !rule.parameters.is_empty() {
            self.declared
                .report
                .push(MainParameters { at: rule.name.span }.diagnostic());
        }
        self.rule_ids.get(&rule.name.span).copied()
    }

    fn undefined_domains(&mut self) {
        for domain in &self.declared.domains {
            let DomainKind::Concrete { base } = domain.kind else {
                continue;
            };
            let root = self.declared.types.root(base, &self.declared.domains);
            let types = &self.declared.types;
            // an invalid type was reported
            let needs_definition = *types.get(root) != Type::Invalid
                && !types.is_abstract(root, &self.declared.domains);
            if needs_definition && domain.definition.is_none() && !domain.dynamic {
                let error = EmptyDomain {
                    domain: domain.name.clone(),
                    at: domain.span,
                };
                self.declared.report.push(error.diagnostic());
            }
        }
    }

    fn finish(mut self, name: Arc<str>, main: Option<RuleId>) -> Model {
        let variables = self.declared.variables();
        let functions = &self.declared.functions;
        let reserved = |name: &str| {
            let at = functions.iter().position(|function| {
                &*function.name == name && matches!(function.meaning, Meaning::Machine)
            });
            at.map(|index| FunctionId(index as u32))
        };
        let reserved = Reserved {
            self_: reserved("self"),
            program: reserved("program"),
            result: reserved("result"),
            variables,
        };
        Model {
            name,
            types: self.declared.types,
            domains: self.declared.domains,
            functions: self.declared.functions,
            rules: self.declared.rules,
            atoms: self.declared.atoms,
            main,
            programs: self.programs,
            invariants: self.invariants,
            properties: self.properties,
            reserved,
            compatible: self.options.compatible,
            added: Added::default(),
            scope: merged_scope(self.declared.scopes),
        }
    }
}

/// The context of a `function f(…) = …`.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    /// Under `definitions:`.
    Definition,
    /// In an initial state.
    Initial,
}

impl Purpose {
    /// Explains why a function of this kind cannot be defined in this context, and suggests a
    /// remedy.
    fn forbids(self, kind: FunctionKind, reserved: bool) -> Option<(&'static str, &'static str)> {
        if reserved {
            return Some((
                "set by the machine",
                "remove this; assign programs to agents with `agent Domain: r_rule[]`",
            ));
        }
        let fixed = matches!(kind, FunctionKind::Static | FunctionKind::Derived);
        match self {
            Self::Definition if !fixed => Some((
                "takes its values from rules or the environment",
                "move this to `default init` to set the first value, or declare the function `derived`",
            )),
            Self::Initial if fixed => Some((
                "needs a definition, not an initial value",
                "remove this, or declare the function `controlled`",
            )),
            Self::Definition | Self::Initial => None,
        }
    }
}

/// Suggests the initial state with a similar name, or lists all of them.
fn suggestion<'a>(name: &str, known: impl Iterator<Item = &'a Arc<str>> + Clone) -> String {
    match similar(name, known.clone()) {
        Some(similar) => did_you_mean(similar),
        None => {
            let known: Vec<String> = known.map(|name| format!("`{name}`")).collect();
            format!("the initial states are {}", known.join(", "))
        }
    }
}

/// Codes of findings about undeclared names.
const UNKNOWN: &[&Code] = &[
    UnknownFunction::CODE,
    UnknownRule::CODE,
    UnknownDomain::CODE,
    UnknownConstant::CODE,
    DefinesUndeclared::CODE,
];

/// Codes of findings about an undeclared name at a place of its use.
const NAMES: &[&Code] = &[
    UnknownFunction::CODE,
    UnknownRule::CODE,
    UnknownDomain::CODE,
    UnknownConstant::CODE,
];

/// Removes findings that may only follow from unreadable parts of the texts: a name that occurs in
/// such a part could be declared there, and a term before `=` at its beginning is probably the location of an
/// update, as in `n = 1`.
fn without_unread(mut report: Report, loaded: &LoadedFiles, sources: &Sources) -> Report {
    let unread = loaded.units.iter().flat_map(|unit| &unit.tree.unread);
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let words: BTreeSet<&str> = unread
        .flat_map(|span| sources.snippet(*span).split(|c| !is_word(c)))
        .collect();
    report.diagnostics.retain(|finding| {
        let at = finding.primary.as_ref().map(|label| label.span);
        let name = at.map_or("", |at| sources.snippet(at));
        let is_updated = || at.is_some_and(|at| is_before_equals(at, loaded, sources));
        // the lexer has reported a name such as `x$y`
        let is_invalid = (finding.is_any(NAMES) || finding.is_any(&[UnknownVariable::CODE]))
            && name.get(1..).is_some_and(|rest| rest.contains('$'));
        let may_be_declared = finding.is_any(UNKNOWN) && words.contains(name);
        let may_be_updated = finding.is_any(&[NotARule::CODE]) && is_updated();
        let mut labels = finding.secondary.iter();
        let is_misread = finding.is_any(&[NoOverload::CODE, WrongArity::CODE])
            && labels.any(|label| is_cut_off(label.span, loaded, sources));
        !may_be_declared && !may_be_updated && !is_invalid && !is_misread
    });
    report
}

/// Number of further places of an unknown name that are shown.
const SHOWN_PLACES: usize = 3;

/// Merges the findings about one undeclared name in a file: the first one shows the other places. Those with different ways out
/// stay apart: `G` means another operator in an invariant than in LTL.
fn each_name_once(mut report: Report) -> Report {
    let place = |finding: &Diagnostic| finding.primary.as_ref().map(|label| label.span);
    report.diagnostics.sort_by_key(place);
    let mut first: BTreeMap<(&str, String, FileId, Vec<String>), usize> = BTreeMap::new();
    let mut merged: Vec<(Diagnostic, usize)> = Vec::new();
    for finding in report.diagnostics {
        if let Some(at) = place(&finding).filter(|_| finding.is_any(NAMES)) {
            let (message, helps) = (finding.message.clone(), finding.helps.clone());
            let name = (finding.code.name, message, at.file, helps);
            let known = *first.entry(name).or_insert(merged.len());
            if let Some((known, others)) = merged.get_mut(known) {
                if place(known) != Some(at) {
                    *others += 1;
                    add_place(known, *others, at, finding.fix);
                }
                continue;
            }
        }
        merged.push((finding, 0));
    }
    let noted = merged.into_iter().map(|(finding, others)| match others {
        0..=SHOWN_PLACES => finding,
        _ => finding.note(format!("used at {others} further places")),
    });
    noted.collect()
}

/// Adds a further place of a name to the finding about it, and its edits to those of the finding.
fn add_place(finding: &mut Diagnostic, number: usize, at: Span, fix: Option<Fix>) {
    if number <= SHOWN_PLACES {
        finding.secondary.push(Label {
            span: at,
            text: "also here".to_owned(),
        });
    }
    if let (Some(known), Some(fix)) = (&mut finding.fix, fix)
        && known.title == fix.title
    {
        known.edits.extend(fix.edits);
    }
}

/// Returns whether an unreadable part follows the name of a declaration on its line, so that its domain is not known.
fn is_cut_off(name: Span, loaded: &LoadedFiles, sources: &Sources) -> bool {
    let unread = loaded.units.iter().flat_map(|unit| &unit.tree.unread);
    let mut behind = unread.filter(|it| it.file == name.file && it.start >= name.end);
    behind.any(|it| {
        let between = Span {
            start: name.end,
            end: it.start,
            ..name
        };
        !sources.snippet(between).contains('\n')
    })
}

/// Returns whether an unreadable part that begins with `=` follows the span, after blanks at most.
fn is_before_equals(at: Span, loaded: &LoadedFiles, sources: &Sources) -> bool {
    let unread = loaded.units.iter().flat_map(|unit| &unit.tree.unread);
    let mut behind = unread.filter(|it| it.file == at.file && it.start >= at.end);
    behind.any(|it| {
        let between = Span {
            start: at.end,
            end: it.start,
            ..at
        };
        sources.snippet(between).trim().is_empty() && sources.snippet(*it).starts_with('=')
    })
}
