//! Uses of functions and literals in a specification: what it reads, and which literals of its enumerations no
//! function can take.

use super::facts::{definition, each_term, subterms, visit, walk};
use asmotion_diagnostics::Span;
use asmotion_hir::{
    DomainId, DomainKind, FunctionId, FunctionKind, Meaning, Model, RuleKind, RuleTerm, Term,
    TermKind, TypeId,
};
use asmotion_value::{Atom, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Returns the functions that a term applies.
pub fn applied_functions(term: &Term) -> BTreeSet<FunctionId> {
    let mut applied = BTreeSet::new();
    visit(term, &mut |term| applied.extend(term.kind.function()));
    applied
}

/// Returns the functions that any rule, definition, initial value, invariant or property reads. The target of an update is
/// not read.
pub fn read_functions(model: &Model) -> BTreeSet<FunctionId> {
    let mut read = BTreeSet::new();
    for term in terms(model) {
        visit(term, &mut |term| read.extend(term.kind.function()));
    }
    for rule in rules(model) {
        walk(rule, &mut |rule| {
            each_term(rule, &mut |term| {
                visit(term, &mut |term| read.extend(term.kind.function()));
            });
        });
    }
    read
}

/// A literal of an enumeration that no function can take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnreachedLiteral {
    /// The literal.
    pub atom: Atom,
    /// The first place where a value is compared with it; `None` if nothing mentions it.
    pub compared: Option<Span>,
}

/// Returns the literals that nothing in the specification yields: they occur only where a value is compared with them, or
/// nowhere. Only enumerations declared in the file of the main rule are examined.
///
/// `inputs` are the literals that the environment may give a monitored or shared function; `None` stands for all.
pub fn unreached_literals(
    model: &Model,
    inputs: &dyn Fn(FunctionId) -> Option<BTreeSet<Atom>>,
) -> Vec<UnreachedLiteral> {
    let Some(main) = model.main else {
        return Vec::new();
    };
    let file = model.rule(main).span.file;
    let mut search = LiteralSearch {
        model,
        reached: BTreeSet::new(),
        compared: BTreeMap::new(),
    };
    search.functions(inputs);
    for program in &model.programs {
        search.domain(program.domain);
    }
    for term in terms(model) {
        search.term(term);
    }
    for rule in rules(model) {
        walk(rule, &mut |rule| search.rule(rule));
    }
    let own = model.domains.iter().filter(|it| it.span.file == file);
    let literals = own.flat_map(|domain| literals(&domain.kind));
    let unreached = literals.filter(|atom| !search.reached.contains(atom));
    let found = unreached.map(|atom| UnreachedLiteral {
        atom,
        compared: search.compared.get(&atom).copied(),
    });
    found.collect()
}

/// The terms of a specification outside its rules, without those of the libraries.
fn terms(model: &Model) -> impl Iterator<Item = &Term> {
    let functions = model.own_functions();
    let functions = functions.flat_map(|(_, it)| definition(it).into_iter().chain(&it.initial));
    let domains = model.domains.iter().flat_map(|it| &it.definition);
    let arguments = model.programs.iter().flat_map(|it| &it.arguments);
    let invariants = model.invariants.iter().map(|it| &it.condition);
    let properties = model.properties.iter().flat_map(|it| &it.formulas);
    let bodies = functions.chain(domains).chain(arguments);
    bodies
        .chain(invariants)
        .chain(properties)
        .map(|body| &body.root)
}

/// The bodies of the rules of a specification, without those of the libraries.
fn rules(model: &Model) -> impl Iterator<Item = &RuleTerm> {
    let own = model.rules.iter().filter(|rule| !rule.library);
    own.filter_map(|rule| Some(&rule.body.as_ref()?.root))
}

/// The literals of an enumeration; none of other domains.
fn literals(kind: &DomainKind) -> impl Iterator<Item = Atom> + use<> {
    let (first, count) = match kind {
        DomainKind::Enum { first, count } => (first.0, *count),
        DomainKind::Any
        | DomainKind::Basic
        | DomainKind::Abstract
        | DomainKind::Concrete { .. } => (0, 0),
    };
    (first..first + count).map(Atom)
}

struct LiteralSearch<'m> {
    model: &'m Model,
    /// Literals that some term yields.
    reached: BTreeSet<Atom>,
    /// The first comparison with each literal.
    compared: BTreeMap<Atom, Span>,
}

impl LiteralSearch<'_> {
    /// Adds the literals that inputs and the arguments of locations range over.
    fn functions(&mut self, inputs: &dyn Fn(FunctionId) -> Option<BTreeSet<Atom>>) {
        for (id, function) in self.model.own_functions() {
            if !matches!(function.meaning, Meaning::State) {
                continue;
            }
            for parameter in &function.parameters {
                self.all_of(*parameter);
            }
            if matches!(
                function.kind,
                FunctionKind::Monitored | FunctionKind::Shared
            ) {
                match inputs(id) {
                    Some(literals) => self.reached.extend(literals),
                    None => self.all_of(function.codomain),
                }
            }
        }
    }

    /// Adds the literals of all enumerations in a type; of any enumeration, if it is a type variable.
    fn all_of(&mut self, ty: TypeId) {
        let model = self.model;
        for part in model.types.reachable_types(ty, &model.domains) {
            if let Some(domain) = model.types.get(part).as_domain() {
                self.domain(domain);
            }
        }
    }

    fn domain(&mut self, domain: DomainId) {
        let domains = &self.model.domains;
        let kind = &self.model.domain(domain).kind;
        if *kind == DomainKind::Any {
            let all = domains.iter().flat_map(|it| literals(&it.kind));
            self.reached.extend(all);
        } else {
            self.reached.extend(literals(kind));
        }
    }

    fn rule(&mut self, rule: &RuleTerm) {
        match &*rule.kind {
            RuleKind::Switch(subject, cases, _) => {
                self.term(subject);
                cases.iter().for_each(|(case, _)| self.comparison(case));
            }
            // the environment updates the locations that are arguments of a message rule
            RuleKind::Call(callee, arguments) if self.model.rule(*callee).library => {
                for argument in arguments {
                    if matches!(&*argument.kind, TermKind::Value(_)) {
                        self.term(argument);
                    } else {
                        self.all_of(argument.ty);
                    }
                }
            }
            RuleKind::Skip
            | RuleKind::Update(..)
            | RuleKind::Assign(..)
            | RuleKind::Call(..)
            | RuleKind::Run(..)
            | RuleKind::Par(_)
            | RuleKind::Seq(_)
            | RuleKind::If(..)
            | RuleKind::Choose(..)
            | RuleKind::Forall(..)
            | RuleKind::Let(..)
            | RuleKind::Extend(..)
            | RuleKind::While(..)
            | RuleKind::WhileRec(..)
            | RuleKind::Iterate(_)
            | RuleKind::Local(_)
            | RuleKind::Invalid => each_term(rule, &mut |term| self.term(term)),
        }
    }

    /// Adds the literals that a term yields.
    fn term(&mut self, term: &Term) {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || match &*term.kind {
            TermKind::Value(Value::Atom(atom)) => {
                self.reached.insert(*atom);
            }
            TermKind::Extent(ty) => self.all_of(*ty),
            TermKind::Switch(subject, cases, otherwise) => {
                self.term(subject);
                for (case, value) in cases {
                    self.comparison(case);
                    self.term(value);
                }
                otherwise.iter().for_each(|term| self.term(term));
            }
            TermKind::Apply(function, arguments) if self.compares(*function) => {
                arguments.iter().for_each(|term| self.comparison(term));
            }
            TermKind::Value(_)
            | TermKind::Variable(_)
            | TermKind::Apply(..)
            | TermKind::Spread(..)
            | TermKind::Tuple(_)
            | TermKind::If(..)
            | TermKind::Let(..)
            | TermKind::Quantified(..)
            | TermKind::Listed(..)
            | TermKind::Interval(..)
            | TermKind::Comprehension(..)
            | TermKind::Map(_)
            | TermKind::MapComprehension(..)
            | TermKind::Rule(_)
            | TermKind::Element(..)
            | TermKind::Unbound
            | TermKind::Invalid => {
                if let Some(function) = term.kind.function() {
                    self.result(function, term);
                }
                subterms(term, &mut |term| self.term(term));
            }
        });
    }

    /// Adds the literals that a function of a library may make of other values, such as an element of its name.
    fn result(&mut self, function: FunctionId, term: &Term) {
        let model = self.model;
        let is_defined = matches!(model.function(function).meaning, Meaning::Builtin(_));
        if !is_defined {
            return;
        }
        let mut known: BTreeSet<TypeId> = BTreeSet::new();
        subterms(term, &mut |argument| {
            known.extend(model.types.reachable_types(argument.ty, &model.domains));
        });
        let parts = model.types.reachable_types(term.ty, &model.domains);
        for part in parts.filter(|part| !known.contains(part)) {
            self.all_of(part);
        }
    }

    /// Notes a literal with which a value is compared.
    fn comparison(&mut self, term: &Term) {
        if let TermKind::Value(Value::Atom(atom)) = &*term.kind {
            self.compared.entry(*atom).or_insert(term.span);
        } else {
            self.term(term);
        }
    }

    fn compares(&self, function: FunctionId) -> bool {
        let function = self.model.function(function);
        function.library && matches!(&*function.name, "eq" | "neq")
    }
}
