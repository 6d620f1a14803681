//! Signatures of `.asm` files, read with the language crates.

use asmotion_diagnostics::{Loader, Report, Sources, Span};
use asmotion_lang::hir::{self, DomainKind, Model, Type, TypeId};
use asmotion_lang::ir::{MessageRole, message_uses};
use asmotion_lang::stdlib;
use asmotion_lang::syntax::ast::File;
use asmotion_lang::value::{Atom, Value};

use crate::signature::{
    Annotated, Annotations, Codomain, FunctionInfo, FunctionKind, Signature, Specifications,
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
                Ok(Some(Box::new(ModelSignature { model, annotations })))
            }
            None => Err(report.finish()),
        }
    }
}

struct ModelSignature {
    model: Model,
    annotations: Annotations,
}

impl Signature for ModelSignature {
    fn warnings(&self) -> Report {
        asmotion_lang::unverified_properties(&self.model)
            .into_iter()
            .collect()
    }

    fn functions(&self) -> Vec<FunctionInfo> {
        let own = self.model.own_functions();
        // operations of partners are not outputs
        let own = own.filter(|(_, function)| !self.model.is_operation(function));
        own.map(|(_, function)| FunctionInfo {
            name: function.name.to_string(),
            kind: kind(function.kind),
            domain: self.domain(&function.parameters),
            codomain: self.codomain(function.codomain),
            declared: function.span,
        })
        .collect()
    }

    fn awaits(&self, partner: &str) -> Option<(String, Span)> {
        let uses = message_uses(&self.model);
        let awaited = uses.iter().find(|used| {
            let asks = used.role == MessageRole::Ask && used.reply.is_some();
            asks && self.element(used.partner) == Some(partner)
        });
        awaited.map(|used| (stdlib::operation(used.operation).to_owned(), used.at))
    }

    fn annotations(&self) -> Annotations {
        self.annotations.clone()
    }

    fn main_rule(&self) -> Option<(String, Span)> {
        let main = self.model.main?;
        let rule = self.model.rules.get(main.0 as usize)?;
        Some((rule.name.to_string(), rule.span))
    }
}

impl ModelSignature {
    /// Returns the name of the element denoted by a term.
    fn element(&self, term: &hir::Term) -> Option<&str> {
        let hir::TermKind::Value(Value::Atom(Atom(index))) = &*term.kind else {
            return None;
        };
        self.model
            .atoms
            .get(*index as usize)
            .map(|atom| &*atom.name)
    }

    fn domain(&self, parameters: &[TypeId]) -> String {
        let shown = parameters
            .iter()
            .map(|parameter| self.model.show_type(*parameter));
        shown.collect::<Vec<_>>().join(", ")
    }

    fn codomain(&self, written: TypeId) -> Codomain {
        let root = self.model.types.root(written, &self.model.domains);
        match self.model.types.get(root) {
            Type::Boolean => Codomain::Boolean,
            Type::Integer | Type::Natural => Codomain::Integer,
            Type::Real => Codomain::Real,
            Type::String => Codomain::Text,
            Type::Domain(id) => {
                let domain = self.model.domain(*id);
                match domain.kind {
                    DomainKind::Enum { first, count } => Codomain::Enum {
                        name: domain.name.to_string(),
                        literals: self.literals(first.0, count),
                        declared: Some(domain.span),
                    },
                    DomainKind::Any
                    | DomainKind::Basic
                    | DomainKind::Abstract
                    | DomainKind::Concrete { .. } => Codomain::Other(self.model.show_type(written)),
                }
            }
            Type::Invalid
            | Type::Undef
            | Type::Complex
            | Type::Char
            | Type::Rule
            | Type::Prod(_)
            | Type::Seq(_)
            | Type::Powerset(_)
            | Type::Bag(_)
            | Type::Map(_, _) => Codomain::Other(self.model.show_type(written)),
        }
    }

    fn literals(&self, first: u32, count: u32) -> Vec<String> {
        let atoms = self
            .model
            .atoms
            .iter()
            .skip(first as usize)
            .take(count as usize);
        atoms.map(|atom| atom.name.to_string()).collect()
    }
}

/// Collects the annotations; each belongs to the import or function that follows it.
fn annotations(tree: &File, model: &Model) -> Annotations {
    let mut found = Annotations::default();
    let functions = tree.functions.iter().map(|it| (&it.name, true));
    let imports = tree.imports.iter().map(|it| (&it.path, false));
    let declared: Vec<_> = functions.chain(imports).collect();
    for annotation in &tree.annotations {
        let at = annotation.name.span;
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
