//! Signatures of `.asm` files, as the language crates read them.

use asm_lang::hir::{self, DomainKind, Model, Type, TypeId};
use asm_lang::ir::{Role, message_uses};
use asm_lang::stdlib;
use asm_lang::value::{Atom, Value};
use source::{Loader, Report, Sources, Span};

use crate::signature::{Codomain, FunctionInfo, FunctionKind, Signature, Specifications};

/// Opens `.asm` files with the language crates.
#[derive(Clone, Copy)]
pub struct AsmFiles<'a> {
    loader: &'a dyn Loader,
}

impl<'a> AsmFiles<'a> {
    /// Files of this loader.
    pub fn new(loader: &'a dyn Loader) -> Self {
        Self { loader }
    }
}

impl Specifications for AsmFiles<'_> {
    /// Its errors become findings of the composite; its warnings belong to those who check the
    /// specification alone.
    fn open(
        &self,
        path: &str,
        sources: &mut Sources,
    ) -> Result<Option<Box<dyn Signature>>, Report> {
        let loaded = hir::load(path, self.loader, sources);
        let (model, found) = hir::analyse(&loaded, sources);
        let mut report = loaded.report;
        report.extend(found);
        match model.filter(|_| !report.has_errors()) {
            Some(model) => Ok(Some(Box::new(ModelSignature(model)))),
            None => Err(report.finish()),
        }
    }
}

struct ModelSignature(Model);

impl Signature for ModelSignature {
    fn functions(&self) -> Vec<FunctionInfo> {
        let own = self.0.own_functions();
        // what partners can be asked is no output
        let own = own.filter(|(_, function)| !self.0.is_operation(function));
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
        let uses = message_uses(&self.0);
        let awaited = uses.iter().find(|used| {
            let asks = used.role == Role::Ask && used.reply.is_some();
            asks && self.element(used.partner) == Some(partner)
        });
        awaited.map(|used| (stdlib::operation(used.operation).to_owned(), used.at))
    }

    fn main_rule(&self) -> Option<(String, Span)> {
        let main = self.0.main?;
        let rule = self.0.rules.get(main.0 as usize)?;
        Some((rule.name.to_string(), rule.span))
    }
}

impl ModelSignature {
    /// The name of the element that a term is.
    fn element(&self, term: &hir::Term) -> Option<&str> {
        let hir::TermKind::Value(Value::Atom(Atom(index))) = &*term.kind else {
            return None;
        };
        self.0.atoms.get(*index as usize).map(|atom| &*atom.name)
    }

    fn domain(&self, parameters: &[TypeId]) -> String {
        let shown = parameters
            .iter()
            .map(|parameter| self.0.show_type(*parameter));
        shown.collect::<Vec<_>>().join(", ")
    }

    fn codomain(&self, written: TypeId) -> Codomain {
        let root = self.0.types.root(written, &self.0.domains);
        match self.0.types.get(root) {
            Type::Boolean => Codomain::Boolean,
            Type::Integer | Type::Natural => Codomain::Integer,
            Type::Real => Codomain::Real,
            Type::String => Codomain::Text,
            Type::Domain(id) => {
                let domain = self.0.domain(*id);
                match domain.kind {
                    DomainKind::Enum { first, count } => Codomain::Enum {
                        name: domain.name.to_string(),
                        literals: self.literals(first.0, count),
                        declared: Some(domain.span),
                    },
                    DomainKind::Any
                    | DomainKind::Basic
                    | DomainKind::Abstract
                    | DomainKind::Concrete { .. } => Codomain::Other(self.0.show_type(written)),
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
            | Type::Map(_, _) => Codomain::Other(self.0.show_type(written)),
        }
    }

    fn literals(&self, first: u32, count: u32) -> Vec<String> {
        let atoms = self
            .0
            .atoms
            .iter()
            .skip(first as usize)
            .take(count as usize);
        atoms.map(|atom| atom.name.to_string()).collect()
    }
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
