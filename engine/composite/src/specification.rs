//! Signatures of `.asm` files, read with the language crates.

use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use asmotion_coordinator::CONTROL_STATES;
use asmotion_diagnostics::{FileId, Finding, Loader, Report, Sources, Span};
use asmotion_lang::Specification;
use asmotion_lang::hir::{self, DomainKind, Model, RuleKind, TermKind, Type, TypeId, UpdateTarget};
use asmotion_lang::ir::{self, MessageRole, message_uses};
use asmotion_lang::stdlib;
use asmotion_lang::syntax::ast::File;
use asmotion_lang::value::{Atom, Value};
use asmotion_verify::Monitors;

use crate::codes::c201::UnwatchedProperties;
use crate::first_step::Executable;
use crate::signature::{
    Annotated, AnnotatedPort, Annotations, Codomain, EnteredState, FunctionInfo, FunctionKind,
    MissingLiteral, ParameterInfo, Signature, Specifications, StartValue, StatedProperties,
};

/// Loads `.asm` files with the language crates.
#[derive(Clone, Copy)]
pub struct AsmFiles<'a> {
    loader: &'a dyn Loader,
}

impl<'a> AsmFiles<'a> {
    /// Creates a loader of specifications from a loader of files.
    pub fn new(loader: &'a dyn Loader) -> Self {
        Self { loader }
    }
}

impl Specifications for AsmFiles<'_> {
    /// Errors of the specification are reported with the composite, and properties that no run verifies; its other
    /// warnings are omitted, since checking the specification itself reports them.
    fn open(
        &self,
        path: &str,
        sources: &mut Sources,
    ) -> Result<Option<Box<dyn Signature>>, Report> {
        let mut loaded = hir::load(path, self.loader, sources);
        let (model, found) = hir::analyse(&mut loaded, sources);
        let hir::LoadedFiles { units, mut report } = loaded;
        report.extend(found);
        match model.filter(|_| !report.has_errors()) {
            Some(model) => {
                let annotations = units.last().map(|main| annotations(&main.tree, &model));
                let annotations = annotations.unwrap_or_default();
                // what cannot be lowered is reported when the specification starts
                let executable = ir::lower(&model).ok().map(|lowered| Executable {
                    program: Arc::new(lowered.program),
                    origins: lowered.origins,
                });
                let (model, warnings) = unwatched(model, sources);
                Ok(Some(Box::new(ModelSignature {
                    model: RefCell::new(model),
                    functions: OnceCell::new(),
                    states_without_exit: OnceCell::new(),
                    executable,
                    annotations,
                    warnings,
                    read_functions: LastCall::new(),
                    missing_literals: LastCall::new(),
                    undefined_at_start: LastCall::new(),
                })))
            }
            None => Err(report.finish()),
        }
    }
}

struct ModelSignature {
    /// Terms are added to it and removed again for their check.
    model: RefCell<Model>,
    /// The functions of the model, in the form of [`Signature::functions`], once they have been asked for.
    functions: OnceCell<Vec<FunctionInfo>>,
    /// [`Signature::states_without_exit`], once they have been asked for.
    states_without_exit: OnceCell<Vec<EnteredState>>,
    /// The model in executable form; `None` if it cannot be lowered.
    executable: Option<Executable>,
    annotations: Annotations,
    /// Warnings that concern runs.
    warnings: Report,
    read_functions: LastCall<Vec<String>, Option<BTreeSet<String>>>,
    missing_literals: LastCall<BTreeMap<String, BTreeSet<String>>, Vec<MissingLiteral>>,
    undefined_at_start: LastCall<BTreeMap<String, StartValue>, Vec<(String, Span)>>,
}

/// The last call of a function: its argument and its result. Components that are instances of one element ask the same, one after
/// the other.
struct LastCall<K, V>(RefCell<Option<(K, V)>>);

impl<K: PartialEq, V: Clone> LastCall<K, V> {
    fn new() -> Self {
        Self(RefCell::new(None))
    }

    /// Returns the result of the last call if it had this argument; otherwise computes it.
    fn get(&self, is_argument: impl FnOnce(&K) -> bool, call: impl FnOnce() -> (K, V)) -> V {
        if let Some((last, result)) = &*self.0.borrow()
            && is_argument(last)
        {
            return result.clone();
        }
        let (argument, result) = call();
        *self.0.borrow_mut() = Some((argument, result.clone()));
        result
    }
}

/// Returns the model, and a warning about properties that a run cannot watch.
fn unwatched(model: Model, sources: &Sources) -> (Model, Report) {
    if model.properties.is_empty() {
        return (model, Report::new());
    }
    let Ok(lowered) = ir::lower(&model) else {
        return (model, Report::new());
    };
    let mut specification = Specification {
        model,
        program: Arc::new(lowered.program),
        origins: lowered.origins,
        sources: sources.clone(),
        report: Report::new(),
    };
    let monitors = Monitors::of(&mut specification, &[]).unwrap_or_default();
    let mut model = specification.model;
    model.forget_added(0, 0);
    let mut unwatched: Vec<(Span, String)> = Vec::new();
    for property in monitors.watched() {
        if let (Some(at), false) = (property.at, property.unwatched.is_empty()) {
            let reasons = property.unwatched.join("; ");
            unwatched.push((at, format!("watched in part: {reasons}")));
        }
    }
    let wholly = monitors.unwatched().iter();
    unwatched.extend(wholly.filter_map(|it| Some((it.at?, it.reason.clone()))));
    unwatched.sort_by_key(|(at, _)| (at.file, at.start));
    let mut report = Report::new();
    if !unwatched.is_empty() {
        report.push(UnwatchedProperties { unwatched }.diagnostic());
    }
    (model, report)
}

impl Signature for ModelSignature {
    fn stated_properties(&self) -> Option<StatedProperties> {
        let model = self.model.borrow();
        let states = |logic| model.properties.iter().any(|it| it.logic == logic);
        Some(StatedProperties {
            ctl: states(hir::PropertyLogic::Ctl),
            ltl: states(hir::PropertyLogic::Ltl),
            invariants: !model.invariants.is_empty(),
        })
    }

    fn warnings(&self) -> Report {
        self.warnings.clone()
    }

    fn functions(&self) -> &[FunctionInfo] {
        self.functions.get_or_init(|| {
            let model = self.model.borrow();
            let own = model.own_functions();
            // operations of partners are not outputs
            let own = own.filter(|(_, function)| !model.is_operation(function));
            let functions = own.map(|(id, function)| FunctionInfo {
                name: function.name.to_string(),
                kind: kind(function.kind),
                domain: domain(&model, &function.parameters),
                parameters: self.parameters(&model, id, &function.parameters),
                codomain: codomain(&model, function.codomain),
                declared: function.span,
            });
            functions.collect()
        })
    }

    fn awaits(&self, partner: &str) -> Option<(String, Span)> {
        let model = self.model.borrow();
        let uses = message_uses(&model);
        let awaited = uses.iter().find(|used| {
            let asks = used.role == MessageRole::Ask && used.reply.is_some();
            asks && element(&model, used.partner) == Some(partner)
        });
        awaited.map(|used| (stdlib::operation(used.operation).to_owned(), used.at))
    }

    fn exchanges_messages(&self) -> Option<bool> {
        Some(!message_uses(&self.model.borrow()).is_empty())
    }

    fn annotations(&self) -> Annotations {
        self.annotations.clone()
    }

    fn states_without_exit(&self) -> &[EnteredState] {
        let find = || states_without_exit(&self.model.borrow(), &self.annotations);
        self.states_without_exit.get_or_init(find)
    }

    fn term(&self, text: &str) -> Result<Option<Codomain>, String> {
        let mut model = self.model.borrow_mut();
        let first = |report: Report| {
            let mut found = report.diagnostics.into_iter();
            found.next().map(|it| it.message).unwrap_or_default()
        };
        let term = asmotion_lang::syntax::parse_term(FileId::default(), text).map_err(first)?;
        let (terms, rules) = (model.added.terms.len(), model.added.rules.len());
        let added = model.add_term(&term).map_err(first)?;
        let found = model.added.terms.get(added.0 as usize).map(|it| it.root.ty);
        let found = found.map(|found| codomain(&model, found));
        model.forget_added(terms, rules);
        Ok(found)
    }

    fn rule(&self, text: &str) -> Result<(), String> {
        let mut model = self.model.borrow_mut();
        let first = |report: Report| {
            let mut found = report.diagnostics.into_iter();
            found.next().map(|it| it.message).unwrap_or_default()
        };
        let rule = asmotion_lang::syntax::parse_rule(FileId::default(), text).map_err(first)?;
        let (terms, rules) = (model.added.terms.len(), model.added.rules.len());
        model.add_rule(&rule).map_err(first)?;
        model.forget_added(terms, rules);
        Ok(())
    }

    fn read_functions(&self, terms: &[&str]) -> Option<BTreeSet<String>> {
        let call = || {
            let owned = terms.iter().map(|it| (*it).to_owned());
            (owned.collect(), Some(self.find_read_functions(terms)))
        };
        self.read_functions.get(|last| *last == terms, call)
    }

    fn missing_literals(&self, inputs: &BTreeMap<String, BTreeSet<String>>) -> Vec<MissingLiteral> {
        let call = || (inputs.clone(), self.find_missing_literals(inputs));
        self.missing_literals.get(|last| last == inputs, call)
    }

    fn undefined_at_start(&self, values: &BTreeMap<String, StartValue>) -> Vec<(String, Span)> {
        let find = |it: &Executable| it.undefined_at_start(&self.model.borrow(), values);
        let call = || {
            let found = self.executable.as_ref().map_or_else(Vec::new, find);
            (values.clone(), found)
        };
        self.undefined_at_start.get(|last| last == values, call)
    }

    fn main_rule(&self) -> Option<(String, Span)> {
        let model = self.model.borrow();
        let main = model.main?;
        let rule = model.rules.get(main.0 as usize)?;
        Some((rule.name.to_string(), rule.span))
    }
}

impl ModelSignature {
    /// [`Signature::read_functions`].
    fn find_read_functions(&self, terms: &[&str]) -> BTreeSet<String> {
        let mut model = self.model.borrow_mut();
        let mut read = ir::read_functions(&model);
        for text in terms {
            // an error in a term is reported where it is checked
            let Ok(term) = asmotion_lang::syntax::parse_term(FileId::default(), text) else {
                continue;
            };
            let (terms, rules) = (model.added.terms.len(), model.added.rules.len());
            if let Ok(added) = model.add_term(&term) {
                let term = model.added.terms.get(added.0 as usize);
                read.extend(term.iter().flat_map(|it| ir::applied_functions(&it.root)));
                model.forget_added(terms, rules);
            }
        }
        let names = read
            .into_iter()
            .map(|id| model.function(id).name.to_string());
        names.collect()
    }

    /// [`Signature::missing_literals`].
    fn find_missing_literals(
        &self,
        inputs: &BTreeMap<String, BTreeSet<String>>,
    ) -> Vec<MissingLiteral> {
        let model = self.model.borrow();
        let given = |id: hir::FunctionId| {
            let function = model.function(id);
            let names = inputs.get(&*function.name)?;
            let all = (0..).map(Atom).zip(&model.atoms);
            let given = all.filter(|(_, atom)| names.contains(&*atom.name));
            Some(given.map(|(atom, _)| atom).collect())
        };
        let always: BTreeSet<Atom> = ir::unreached_literals(&model, &|_| None)
            .into_iter()
            .map(|unreached| unreached.atom)
            .collect();
        let unreached = ir::unreached_literals(&model, &given).into_iter();
        let missing = unreached.filter(|it| !always.contains(&it.atom));
        let missing = missing.filter_map(|unreached| {
            let literal = model.atoms.get(unreached.atom.0 as usize)?;
            Some(MissingLiteral {
                literal: literal.name.to_string(),
                domain: model.domain(literal.domain).name.to_string(),
                compared: unreached.compared?,
            })
        });
        missing.collect()
    }

    fn parameters(
        &self,
        model: &Model,
        function: hir::FunctionId,
        types: &[TypeId],
    ) -> Vec<ParameterInfo> {
        let program = self.executable.as_ref().map(|it| &*it.program);
        let declared = program.and_then(|it| it.functions.get(function.0 as usize));
        let parameters = types.iter().enumerate().map(|(at, kind)| {
            let shape = declared.and_then(|declared| declared.parameters.get(at));
            let known = shape.and_then(|shape| program?.named_elements(shape));
            let names = |known: Vec<(String, Value)>| known.into_iter().map(|(name, _)| name);
            ParameterInfo {
                name: model.show_type(*kind),
                domain: codomain(model, *kind),
                elements: known.map(|known| names(known).collect()),
            }
        });
        parameters.collect()
    }
}

/// Returns the control states that rules enter and none leaves, except those that an annotation names.
fn states_without_exit(model: &Model, annotations: &Annotations) -> Vec<EnteredState> {
    let mut stuck = Vec::new();
    for (id, function) in model.own_functions() {
        let is_control = CONTROL_STATES.contains(&&*function.name);
        if !is_control || !function.parameters.is_empty() {
            continue;
        }
        for (atom, entered) in entered_states(model, id) {
            let Some(literal) = model.atoms.get(atom as usize) else {
                continue;
            };
            let state = literal.name.to_string();
            let is_final = annotations.final_states.contains(&state);
            if !is_final && !model.has_exit(id, &Value::Atom(Atom(atom))) {
                stuck.push(EnteredState {
                    function: function.name.to_string(),
                    state,
                    entered,
                });
            }
        }
    }
    stuck
}

/// Returns the literals that updates give a function, each with the first location. Where a macro gives it the value of a
/// parameter, the literals among the arguments of calls count.
fn entered_states(model: &Model, function: hir::FunctionId) -> BTreeMap<u32, Span> {
    let mut entered = BTreeMap::new();
    let mut passed = BTreeMap::new();
    let mut takes_parameter = false;
    let codomain = model.function(function).codomain;
    let own = model.rules.iter().filter(|rule| !rule.library);
    for body in own.filter_map(|rule| rule.body.as_ref()) {
        ir::visit_rules(&body.root, &mut |rule| match &*rule.kind {
            RuleKind::Update(UpdateTarget::Location(target, _), value) if *target == function => {
                takes_parameter |= matches!(&*value.kind, TermKind::Variable(_));
                note_literal(value, &mut entered);
            }
            RuleKind::Call(_, arguments) => {
                let fitting = arguments.iter().filter(|it| it.ty == codomain);
                fitting.for_each(|argument| note_literal(argument, &mut passed));
            }
            RuleKind::Update(..)
            | RuleKind::Assign(..)
            | RuleKind::Run(..)
            | RuleKind::Skip
            | RuleKind::Par(_)
            | RuleKind::Seq(_)
            | RuleKind::If(..)
            | RuleKind::Switch(..)
            | RuleKind::Choose(..)
            | RuleKind::Forall(..)
            | RuleKind::Let(..)
            | RuleKind::Extend(..)
            | RuleKind::While(..)
            | RuleKind::WhileRec(..)
            | RuleKind::Iterate(_)
            | RuleKind::Local(_)
            | RuleKind::Invalid => {}
        });
    }
    if takes_parameter {
        for (literal, at) in passed {
            entered.entry(literal).or_insert(at);
        }
    }
    entered
}

/// Notes the first location of a literal.
fn note_literal(term: &hir::Term, literals: &mut BTreeMap<u32, Span>) {
    if let TermKind::Value(Value::Atom(Atom(index))) = &*term.kind {
        literals.entry(*index).or_insert(term.span);
    }
}

/// Returns the name of the element denoted by a term.
fn element<'m>(model: &'m Model, term: &hir::Term) -> Option<&'m str> {
    let hir::TermKind::Value(Value::Atom(Atom(index))) = &*term.kind else {
        return None;
    };
    model.atoms.get(*index as usize).map(|atom| &*atom.name)
}

fn domain(model: &Model, parameters: &[TypeId]) -> String {
    let shown = parameters
        .iter()
        .map(|parameter| model.show_type(*parameter));
    shown.collect::<Vec<_>>().join(", ")
}

fn codomain(model: &Model, written: TypeId) -> Codomain {
    let root = model.types.root(written, &model.domains);
    match model.types.get(root) {
        Type::Boolean => Codomain::Boolean,
        Type::Integer | Type::Natural => Codomain::Integer,
        Type::Real => Codomain::Real,
        Type::String => Codomain::Text,
        Type::Domain(id) => {
            let domain = model.domain(*id);
            match domain.kind {
                DomainKind::Enum { first, count } => Codomain::Enum {
                    name: domain.name.to_string(),
                    literals: literals(model, first.0, count),
                    declared: Some(domain.span),
                },
                DomainKind::Abstract => Codomain::Abstract(model.show_type(written)),
                DomainKind::Any | DomainKind::Basic | DomainKind::Concrete { .. } => {
                    Codomain::Other(model.show_type(written))
                }
            }
        }
        Type::Seq(item) | Type::Powerset(item) | Type::Bag(item) => Codomain::List {
            name: model.show_type(written),
            item: Box::new(codomain(model, *item)),
        },
        Type::Prod(items) => Codomain::Tuple {
            name: model.show_type(written),
            items: items.iter().map(|item| codomain(model, *item)).collect(),
        },
        Type::Char => Codomain::Character,
        Type::Map(key, item) => Codomain::Map {
            name: model.show_type(written),
            key: Box::new(codomain(model, *key)),
            item: Box::new(codomain(model, *item)),
        },
        Type::Invalid | Type::Undef | Type::Complex | Type::Rule => {
            Codomain::Other(model.show_type(written))
        }
    }
}

fn literals(model: &Model, first: u32, count: u32) -> Vec<String> {
    let atoms = model.atoms.iter().skip(first as usize).take(count as usize);
    atoms.map(|atom| atom.name.to_string()).collect()
}

/// Collects the annotations; each belongs to the import or function that follows it.
fn annotations(tree: &File, model: &Model) -> Annotations {
    let mut found = Annotations::default();
    let functions = tree.functions.iter().map(|it| (&it.name, true));
    let imports = tree.imports.iter().map(|it| (&it.path, false));
    let declared: Vec<_> = functions.chain(imports).collect();
    for annotation in &tree.annotations {
        if &*annotation.name.text == "Final" {
            let words = annotation
                .rest
                .split(|sign: char| !sign.is_alphanumeric() && sign != '_');
            let states = words.filter(|word| !word.is_empty()).map(str::to_owned);
            found.final_states.extend(states);
            continue;
        }
        let at = annotation.name.span;
        if &*annotation.name.text == "Echo" {
            found.echoes.push((annotation.rest.trim().to_owned(), at));
            continue;
        }
        let behind = declared
            .iter()
            .filter(|(name, _)| name.span.start > at.start);
        let Some((name, is_function)) = behind.min_by_key(|(name, _)| name.span.start) else {
            continue;
        };
        let text = name.text.to_string();
        let declared = name.span;
        match (&*annotation.name.text, is_function) {
            ("Reference", true) => {
                let function = model.own_functions().find(|(_, it)| it.name == name.text);
                let interface = function.map(|(_, it)| model.show_type(it.codomain));
                found.references.push(Annotated {
                    name: text,
                    interface: interface.unwrap_or_default(),
                    declared,
                });
            }
            ("Port", true) => found.ports.push(AnnotatedPort {
                function: text,
                end: annotation.rest.trim().to_owned(),
                at,
            }),
            ("MainService" | "Provided", false) => found.provided.push(Annotated {
                interface: text.rsplit('/').next().unwrap_or_default().to_owned(),
                name: text,
                declared,
            }),
            (_, _) => {}
        }
    }
    found
}

fn kind(kind: hir::FunctionKind) -> FunctionKind {
    match kind {
        hir::FunctionKind::Static => FunctionKind::Static,
        hir::FunctionKind::Derived => FunctionKind::Derived,
        hir::FunctionKind::Monitored => FunctionKind::Monitored,
        hir::FunctionKind::Controlled => FunctionKind::Controlled,
        hir::FunctionKind::Shared => FunctionKind::Shared,
        hir::FunctionKind::Out => FunctionKind::Out,
        hir::FunctionKind::Local => FunctionKind::Local,
    }
}
