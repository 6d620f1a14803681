//! Signatures: assigns ids to domains, functions and rule heads, and gives each file its scope.

use crate::codes::a004::UnknownDomain;
use crate::codes::a009::DuplicateDeclaration;
use crate::codes::a033::DomainCycle;
use crate::codes::w026::LocalInSignature;
use crate::hidden::{ImportClause, NameKind};
use crate::load::SourceUnit;
use crate::lost::{FailedImport, LostImport};
use crate::model::{
    AtomInfo, Domain, DomainId, DomainKind, Function, FunctionId, FunctionKind, Meaning, Rule,
    VarId,
};
use crate::scope::Scope;
use crate::types::{Type, TypeId, TypeTable};
use asmotion_diagnostics::{Finding, Report, Span};
use asmotion_syntax::ast;
use asmotion_value::{Atom, RuleId};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The declarations of all files processed so far.
pub(crate) struct SignatureTables {
    pub types: TypeTable,
    pub domains: Vec<Domain>,
    pub functions: Vec<Function>,
    pub rules: Vec<Rule>,
    pub atoms: Vec<AtomInfo>,
    /// Indexed by the position of the unit in `LoadedFiles::units`.
    pub scopes: Vec<Scope>,
    /// Indexed as `scopes`; empty for parts from outside.
    pub import_clauses: Vec<Vec<ImportClause>>,
    /// Names after `asm` and `module`, indexed as `scopes`; empty for parts from outside.
    pub headings: Vec<Option<Span>>,
    /// Indexed as `scopes`; empty for parts from outside.
    pub lost_imports: Vec<Vec<LostImport>>,
    /// The imports that could not be loaded, of all units.
    pub failed_imports: Vec<FailedImport>,
    pub report: Report,
    /// `true` if any rule contains `choose`.
    pub chooses: bool,
    /// Pairs of a unit and a library that it needs but does not import; each is reported once.
    pub missed: BTreeSet<(usize, &'static str)>,
    /// `true` to use the variants of library functions for `--compat asmeta`.
    pub compatible: bool,
}

/// Declares the domains, functions and rule heads of all units.
pub(crate) fn declare(units: &[SourceUnit], compatible: bool) -> SignatureTables {
    let mut declared = SignatureTables {
        types: TypeTable::default(),
        domains: Vec::new(),
        functions: Vec::new(),
        rules: Vec::new(),
        atoms: Vec::new(),
        missed: BTreeSet::new(),
        scopes: Vec::new(),
        import_clauses: Vec::new(),
        headings: units
            .iter()
            .map(|unit| unit.tree.name.as_ref().map(|name| name.span))
            .collect(),
        lost_imports: Vec::new(),
        failed_imports: Vec::new(),
        report: Report::new(),
        chooses: false,
        compatible,
    };
    let mut functions = Vec::new();
    for (index, unit) in units.iter().enumerate() {
        declared.scopes.push(Scope::default());
        declared.record_imports(units, index);
        declared.record_failed_imports(units, index);
        declared.imports(units, index);
        declared.unit_domains(index, &unit.tree);
    }
    // Literals first, so that the atoms of one domain have consecutive numbers.
    for (index, unit) in units.iter().enumerate() {
        declared.literals(index, &unit.tree);
        declared.imported_literals(units, index);
    }
    for index in 0..units.len() {
        declared.imported_functions(units, index);
        functions.extend(declared.unit_functions(index, units));
    }
    declared.constants(&functions);
    for (index, unit) in units.iter().enumerate() {
        declared.imported_rules(units, index);
        declared.unit_rules(index, unit);
    }
    declared
}

impl SignatureTables {
    fn unit_domains(&mut self, index: usize, tree: &ast::File) {
        let mut concrete = Vec::new();
        for domain in &tree.domains {
            if matches!(domain.kind, ast::DomainKind::Structured(_)) {
                continue;
            }
            let name = &domain.name;
            if let Some(&first) = self.scopes[index].domains.get(&name.text) {
                let first = &self.domains[first.0 as usize];
                // Old models repeat declarations of the library; an identical one is accepted.
                let same = matches!(domain.kind, ast::DomainKind::Basic | ast::DomainKind::Any)
                    || (&*name.text == "Agent" || &*name.text == "Reserve");
                // A model may use the names of the library's type variables for its own domains.
                if same || first.kind != DomainKind::Any {
                    if !same {
                        let error = DuplicateDeclaration {
                            name: name.text.clone(),
                            at: name.span,
                            first: first.span,
                        };
                        self.report.push(error.diagnostic());
                    }
                    continue;
                }
            }
            let id = DomainId(self.domains.len() as u32);
            let kind = match &domain.kind {
                ast::DomainKind::Any => DomainKind::Any,
                ast::DomainKind::Basic => DomainKind::Basic,
                ast::DomainKind::Abstract | ast::DomainKind::Structured(_) => DomainKind::Abstract,
                ast::DomainKind::Enum(_) => DomainKind::Enum {
                    first: Atom(0),
                    count: 0,
                },
                ast::DomainKind::Concrete(base) => {
                    concrete.push((id, base));
                    DomainKind::Concrete {
                        base: self.types.id(Type::Invalid),
                    }
                }
            };
            self.domains.push(Domain {
                name: name.text.clone(),
                kind,
                dynamic: domain.dynamic,
                definition: None,
                span: name.span,
            });
            self.scopes[index].domains.insert(name.text.clone(), id);
        }
        for (id, base) in concrete {
            let base = self.resolve_type(index, base);
            self.domains[id.0 as usize].kind = DomainKind::Concrete { base };
            if self.contains(base, id) {
                let domain = &self.domains[id.0 as usize];
                let (domain, at) = (domain.name.clone(), domain.span);
                self.report.push(DomainCycle { domain, at }.diagnostic());
                let base = self.types.id(Type::Invalid);
                self.domains[id.0 as usize].kind = DomainKind::Concrete { base };
            }
        }
    }

    /// Returns `true` if a domain occurs in a type, or in the base of a concrete domain in it.
    fn contains(&self, ty: TypeId, domain: DomainId) -> bool {
        self.types
            .reachable_types(ty, &self.domains)
            .any(|ty| *self.types.get(ty) == Type::Domain(domain))
    }

    fn literals(&mut self, index: usize, tree: &ast::File) {
        for domain in &tree.domains {
            let ast::DomainKind::Enum(literals) = &domain.kind else {
                continue;
            };
            let Some(&id) = self.scopes[index].domains.get(&domain.name.text) else {
                continue;
            };
            if self.domains[id.0 as usize].span != domain.name.span {
                continue;
            }
            let first = Atom(self.atoms.len() as u32);
            for literal in literals {
                let atom = Atom(self.atoms.len() as u32);
                let twice = self.scopes[index]
                    .literals
                    .get(&literal.text)
                    .and_then(|known| known.first());
                if let Some(&twice) = twice {
                    let first = self.atoms[twice.0 as usize].span;
                    let name = literal.text.clone();
                    self.report.push(
                        DuplicateDeclaration {
                            name,
                            at: literal.span,
                            first,
                        }
                        .diagnostic(),
                    );
                }
                self.atoms.push(AtomInfo {
                    name: literal.text.clone(),
                    domain: id,
                    span: literal.span,
                });
                self.scopes[index]
                    .literals
                    .entry(literal.text.clone())
                    .or_default()
                    .push(atom);
            }
            let count = self.atoms.len() as u32 - first.0;
            self.domains[id.0 as usize].kind = DomainKind::Enum { first, count };
        }
    }

    /// Declares the functions of a unit. Returns those without a definition that may be constants.
    fn unit_functions(&mut self, index: usize, units: &[SourceUnit]) -> Vec<FunctionId> {
        let unit = &units[index];
        let defined: BTreeSet<&str> = unit
            .tree
            .function_definitions
            .iter()
            .filter(|definition| !definition.is_circular())
            .map(|definition| &*definition.name.text)
            .collect();
        let mut undefined = Vec::new();
        let mut annotations = FunctionAnnotations::of(&unit.tree);
        for function in &unit.tree.functions {
            let annotation = annotations.before(function);
            if function.kind == FunctionKind::Local {
                let (name, at) = (function.name.text.clone(), function.name.span);
                self.report.push(LocalInSignature { name, at }.diagnostic());
            }
            let codomain = self.resolve_type(index, &function.codomain);
            let parameters = match &function.domain {
                None => Vec::new(),
                Some(domain) => self.parameters(index, domain),
            };
            let name = &function.name;
            let twice = self.overload(index, &name.text, &parameters);
            if let Some(first) = twice {
                let library = self.functions[first.0 as usize].library;
                if !library || unit.library {
                    let first = self.functions[first.0 as usize].span;
                    let error = DuplicateDeclaration {
                        name: name.text.clone(),
                        at: name.span,
                        first,
                    };
                    self.report.push(error.diagnostic());
                    continue;
                }
                // a model may redeclare a library function; within its own file, its declaration
                // prevails
                if let Some(known) = self.scopes[index].functions.get_mut(&name.text) {
                    known.retain(|&id| id != first);
                }
            }
            let id = FunctionId(self.functions.len() as u32);
            let is_defined = defined.contains(&*name.text);
            let meaning = self.classify(
                function.kind,
                &name.text,
                &parameters,
                unit.library,
                is_defined,
            );
            let is_element = matches!(meaning, Meaning::Missing) && parameters.is_empty();
            // the target of a reference is wired by the assembly: an element stands for it
            let is_reference =
                annotation == Some("Reference") && !has_initial_definition(units, &name.text);
            if !is_defined && (is_element || is_reference) {
                undefined.push(id);
            }
            self.functions.push(Function {
                name: name.text.clone(),
                kind: match function.kind {
                    FunctionKind::Local => FunctionKind::Controlled,
                    kind @ (FunctionKind::Static
                    | FunctionKind::Derived
                    | FunctionKind::Monitored
                    | FunctionKind::Controlled
                    | FunctionKind::Shared
                    | FunctionKind::Out) => kind,
                },
                parameters,
                codomain,
                meaning,
                initial: None,
                span: name.span,
                declaration: function.span,
                library: unit.library,
                run: None,
                is_client: annotation == Some("Backref"),
            });
            self.scopes[index]
                .functions
                .entry(name.text.clone())
                .or_default()
                .push(id);
        }
        undefined
    }

    /// Declares the functions of a library, for parts from outside, unless their names are visible. Returns `true` if any is declared.
    pub fn offer_functions(&mut self, library: &ast::File) -> bool {
        let unit = 0;
        let visible: BTreeSet<Arc<str>> = self.scopes[unit].functions.keys().cloned().collect();
        let functions = library.functions.iter();
        let offered = functions.filter(|it| !visible.contains(&it.name.text));
        let mut is_any = false;
        for function in offered {
            let name = &function.name;
            let codomain = self.resolve_type(unit, &function.codomain);
            let domain = function.domain.as_ref();
            let parameters = domain.map_or_else(Vec::new, |it| self.parameters(unit, it));
            let mut definitions = library.function_definitions.iter();
            let is_defined = definitions.any(|it| it.name.text == name.text);
            let kind = FunctionKind::Static;
            let meaning = self.classify(kind, &name.text, &parameters, true, is_defined);
            let id = FunctionId(self.functions.len() as u32);
            self.functions.push(Function {
                name: name.text.clone(),
                kind,
                parameters,
                codomain,
                meaning,
                initial: None,
                span: name.span,
                declaration: function.span,
                library: true,
                run: None,
                is_client: false,
            });
            let known = self.scopes[unit].functions.entry(name.text.clone());
            known.or_default().push(id);
            is_any = true;
        }
        is_any
    }

    /// Declares a `local` function, which hides others of its name until the scope is restored.
    pub fn local_function(&mut self, unit: usize, function: &ast::Function, run: VarId) {
        let codomain = self.resolve_type(unit, &function.codomain);
        let mut parameters = vec![self.types.id(Type::Integer)];
        if let Some(domain) = &function.domain {
            parameters.extend(self.parameters(unit, domain));
        }
        let id = FunctionId(self.functions.len() as u32);
        self.functions.push(Function {
            name: function.name.text.clone(),
            kind: FunctionKind::Local,
            parameters,
            codomain,
            meaning: Meaning::State,
            initial: None,
            span: function.name.span,
            declaration: function.span,
            library: false,
            run: Some(run),
            is_client: false,
        });
        let known = &mut self.scopes[unit].functions;
        known.insert(function.name.text.clone(), vec![id]);
    }

    /// Declares the function whose locations hold the variables that rules assign.
    pub fn variables(&mut self) -> FunctionId {
        let integer = self.types.id(Type::Integer);
        let codomain = self.types.id(Type::Undef);
        self.functions.push(Function {
            name: "$".into(),
            kind: FunctionKind::Local,
            parameters: vec![integer, integer],
            codomain,
            meaning: Meaning::State,
            initial: None,
            span: Span::default(),
            declaration: Span::default(),
            library: true,
            run: None,
            is_client: false,
        });
        FunctionId(self.functions.len() as u32 - 1)
    }

    fn classify(
        &self,
        kind: FunctionKind,
        name: &str,
        parameters: &[TypeId],
        library: bool,
        defined: bool,
    ) -> Meaning {
        match kind {
            FunctionKind::Static | FunctionKind::Derived => {
                if library && asmotion_stdlib::RESERVED.contains(&name) {
                    return Meaning::Machine;
                }
                if defined {
                    return Meaning::Missing;
                }
                let domain: Vec<String> = parameters
                    .iter()
                    .map(|&ty| self.types.show(ty, &self.domains))
                    .collect();
                let domain = match domain.as_slice() {
                    [] => String::new(),
                    [one] => one.clone(),
                    several => format!("Prod({})", several.join(",")),
                };
                let builtin = if self.compatible {
                    asmotion_stdlib::compatible(name, &domain)
                } else {
                    asmotion_stdlib::builtin(name, &domain)
                };
                builtin.map_or(Meaning::Missing, Meaning::Builtin)
            }
            FunctionKind::Controlled if library && asmotion_stdlib::RESERVED.contains(&name) => {
                Meaning::Machine
            }
            FunctionKind::Monitored
            | FunctionKind::Controlled
            | FunctionKind::Shared
            | FunctionKind::Out
            | FunctionKind::Local => Meaning::State,
        }
    }

    /// Turns static functions without arguments and definition, whose codomain is abstract, into
    /// elements of that codomain. Atoms are numbered domain by domain, the elements of a domain
    /// before those of its subsets, so that the elements of each domain have consecutive numbers.
    fn constants(&mut self, undefined: &[FunctionId]) {
        let mut by_domain: BTreeMap<DomainId, Vec<FunctionId>> = BTreeMap::new();
        for &id in undefined {
            let codomain = self.functions[id.0 as usize].codomain;
            let root = self.types.root(codomain, &self.domains);
            let (Type::Domain(domain), Type::Domain(root)) =
                (self.types.get(codomain), self.types.get(root))
            else {
                continue;
            };
            if self.domains[root.0 as usize].kind == DomainKind::Abstract {
                by_domain.entry(*domain).or_default().push(id);
            }
        }
        let roots: Vec<DomainId> = (0..self.domains.len() as u32)
            .map(DomainId)
            .filter(|id| self.domains[id.0 as usize].kind == DomainKind::Abstract)
            .collect();
        let mut order = Vec::new();
        let mut open: Vec<DomainId> = roots.into_iter().rev().collect();
        let mut contained: BTreeMap<DomainId, Vec<DomainId>> = BTreeMap::new();
        for (id, domain) in self.domains.iter().enumerate().rev() {
            let base = domain.kind.base().map(|base| self.types.get(base));
            if let Some(base) = base.and_then(Type::as_domain) {
                contained.entry(base).or_default().push(DomainId(id as u32));
            }
        }
        while let Some(domain) = open.pop() {
            order.push(domain);
            open.extend(contained.remove(&domain).unwrap_or_default());
        }
        for domain in order {
            for &id in by_domain.get(&domain).into_iter().flatten() {
                let function = &mut self.functions[id.0 as usize];
                let atom = Atom(self.atoms.len() as u32);
                function.meaning = Meaning::Constant(atom);
                self.atoms.push(AtomInfo {
                    name: function.name.clone(),
                    domain,
                    span: function.span,
                });
            }
        }
    }

    fn unit_rules(&mut self, index: usize, unit: &SourceUnit) {
        for rule in unit.tree.rules.iter().chain(&unit.tree.main) {
            let parameters: Vec<TypeId> = rule
                .parameters
                .iter()
                .map(|parameter| self.resolve_type(index, &parameter.domain))
                .collect();
            let result = rule.result.as_ref().map(|ty| self.resolve_type(index, ty));
            let name = &rule.name;
            let known = self.scopes[index]
                .rules
                .get(&name.text)
                .into_iter()
                .flatten();
            let twice = known
                .copied()
                .find(|id| self.rules[id.0 as usize].parameters == parameters);
            if let Some(twice) = twice {
                let first = self.rules[twice.0 as usize].span;
                if self.rules[twice.0 as usize].library && !unit.library {
                    if let Some(known) = self.scopes[index].rules.get_mut(&name.text) {
                        known.retain(|&id| id != twice);
                    }
                } else {
                    let error = DuplicateDeclaration {
                        name: name.text.clone(),
                        at: name.span,
                        first,
                    };
                    self.report.push(error.diagnostic());
                }
            }
            let id = RuleId(self.rules.len() as u32);
            self.rules.push(Rule {
                name: name.text.clone(),
                turbo: rule.turbo,
                parameters,
                result,
                body: None,
                span: name.span,
                library: unit.library,
                act: asmotion_stdlib::MessageAction::named(&name.text).filter(|_| unit.library),
            });
            self.scopes[index]
                .rules
                .entry(name.text.clone())
                .or_default()
                .push(id);
        }
    }

    /// Returns the function of this name with exactly these parameters, if it is visible in the
    /// unit.
    pub fn overload(&self, unit: usize, name: &str, parameters: &[TypeId]) -> Option<FunctionId> {
        let known = self.scopes[unit].functions.get(name)?;
        known
            .iter()
            .copied()
            .find(|id| self.functions[id.0 as usize].parameters == parameters)
    }

    /// Returns the types of a function's arguments: the components of a product, or the one domain.
    pub fn parameters(&mut self, unit: usize, domain: &ast::Type) -> Vec<TypeId> {
        match &domain.kind {
            ast::TypeKind::Prod(items) => items
                .iter()
                .map(|item| self.resolve_type(unit, item))
                .collect(),
            ast::TypeKind::Named(_)
            | ast::TypeKind::Rule(_)
            | ast::TypeKind::Seq(_)
            | ast::TypeKind::Powerset(_)
            | ast::TypeKind::Bag(_)
            | ast::TypeKind::Map(..) => vec![self.resolve_type(unit, domain)],
        }
    }

    /// Resolves a domain in the text to its type.
    pub fn resolve_type(&mut self, unit: usize, ty: &ast::Type) -> TypeId {
        let resolved = match &ty.kind {
            ast::TypeKind::Named(name) => return self.named_type(unit, name, ty.span),
            ast::TypeKind::Rule(_) => Type::Rule,
            ast::TypeKind::Prod(items) => Type::Prod(
                items
                    .iter()
                    .map(|item| self.resolve_type(unit, item))
                    .collect(),
            ),
            ast::TypeKind::Seq(item) => Type::Seq(self.resolve_type(unit, item)),
            ast::TypeKind::Powerset(item) => Type::Powerset(self.resolve_type(unit, item)),
            ast::TypeKind::Bag(item) => Type::Bag(self.resolve_type(unit, item)),
            ast::TypeKind::Map(key, item) => {
                let key = self.resolve_type(unit, key);
                Type::Map(key, self.resolve_type(unit, item))
            }
        };
        self.types.id(resolved)
    }

    fn named_type(&mut self, unit: usize, name: &Arc<str>, at: Span) -> TypeId {
        let known = self.scopes[unit].domains.get(name).copied();
        let declared = known.filter(|id| self.domains[id.0 as usize].kind != DomainKind::Basic);
        let ty = match (declared, Type::basic(name)) {
            (Some(domain), _) => Type::Domain(domain),
            (None, Some(basic)) => basic,
            (None, None) => {
                self.unknown_domain(unit, name, at);
                Type::Invalid
            }
        };
        self.types.id(ty)
    }

    pub fn unknown_domain(&mut self, unit: usize, name: &Arc<str>, at: Span) {
        let hidden = self.hidden(unit, name, NameKind::Domain);
        if hidden.is_none() && self.is_lost(unit, name, NameKind::Domain) {
            return;
        }
        let error = UnknownDomain {
            name: name.clone(),
            at,
            similar: self.scopes[unit].similar_domain(name),
            hidden,
        };
        self.report.push(error.diagnostic());
    }
}

/// The annotations of a file, for its functions in source order.
struct FunctionAnnotations<'a> {
    all: &'a [ast::Annotation],
    /// The end of the function before.
    end: u32,
}

impl<'a> FunctionAnnotations<'a> {
    fn of(tree: &'a ast::File) -> Self {
        Self {
            all: &tree.annotations,
            end: 0,
        }
    }

    /// Returns the name of the last annotation between the function before and this one.
    fn before(&mut self, function: &ast::Function) -> Option<&'a str> {
        let begin = std::mem::replace(&mut self.end, function.span.end);
        let count = self
            .all
            .partition_point(|it| it.name.span.start < function.span.start);
        let last = self.all.get(..count)?.last()?;
        (last.name.span.start >= begin).then_some(&*last.name.text)
    }
}

/// Returns `true` if an initial state defines the function.
fn has_initial_definition(units: &[SourceUnit], function: &str) -> bool {
    let mut inits = units.iter().flat_map(|unit| &unit.tree.inits);
    inits.any(|init| {
        let mut functions = init.functions.iter();
        functions.any(|definition| &*definition.name.text == function)
    })
}
