//! What this build offers to composites: components, messages, specifications, variables.

use asm_lang::hir::{DomainKind, Function, Type};
use asm_lang::{Loader, Model, Report, Sources, Span, hir};
use assembly::signature::{Codomain, FunctionInfo, FunctionKind};
use assembly::{Catalogue, Context, Environment, Signature, Specifications};
use component::{Component, Interface};
use component::declaration::{Declaration, OperationDeclaration};
use datum::Schema;

use crate::files::Disk;

/// What this build offers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Build;

impl Build {
    /// Everything a composite needs from outside its files.
    pub fn context<'a>(
        &'a self,
        loader: &'a dyn Loader,
        environment: &'a dyn Environment,
        settings: &'a [(String, String)],
    ) -> Context<'a> {
        Context { loader, environment, catalogue: self, specifications: self, settings }
    }
}

impl Catalogue for Build {
    fn components(&self) -> Vec<String> {
        components::COMPONENTS.iter().map(|(name, _)| (*name).to_owned()).collect()
    }

    fn constructor(&self, component: &str) -> Option<fn(&mut Interface) -> Box<dyn Component>> {
        components::component(component)
    }

    fn declaration(&self, component: &str) -> Option<Declaration> {
        let new = components::component(component)?;
        let mut interface = Interface::new();
        new(&mut interface);
        Some(interface.declaration().clone())
    }

    fn has(&self, _: assembly::model::Builtin) -> bool {
        false
    }

    fn messages(&self) -> Vec<String> {
        messages::MESSAGES.iter().map(|(name, _)| (*name).to_owned()).collect()
    }

    fn schema(&self, message: &str) -> Option<Schema> {
        components::message(message).cloned()
    }

    fn operations(&self, interface: &str) -> Option<Vec<OperationDeclaration>> {
        components::interface(interface)
    }
}

impl Specifications for Build {
    fn open(
        &self,
        path: &str,
        sources: &mut Sources,
    ) -> Result<Option<Box<dyn Signature>>, Report> {
        let loaded = hir::load(path, &Disk, sources);
        let (model, found) = hir::analyse(&loaded, sources);
        match model {
            Some(model) => Ok(Some(Box::new(ModelSignature::of(&model)))),
            None => {
                let mut report = loaded.report;
                report.extend(found);
                Err(report.finish())
            }
        }
    }
}

/// The functions of a model, as composites see them.
struct ModelSignature {
    functions: Vec<FunctionInfo>,
    main: Option<(String, Span)>,
}

impl ModelSignature {
    fn of(model: &Model) -> Self {
        let functions = model.own_functions().map(|(_, function)| info(model, function)).collect();
        let main = model.main.map(|main| {
            let rule = model.rule(main);
            (rule.name.to_string(), rule.span)
        });
        Self { functions, main }
    }
}

impl Signature for ModelSignature {
    fn functions(&self) -> Vec<FunctionInfo> {
        self.functions.clone()
    }

    fn main_rule(&self) -> Option<(String, Span)> {
        self.main.clone()
    }
}

fn info(model: &Model, function: &Function) -> FunctionInfo {
    let domain: Vec<String> = function.parameters.iter().map(|&ty| model.show_type(ty)).collect();
    FunctionInfo {
        name: function.name.to_string(),
        kind: match function.kind {
            asm_lang::FunctionKind::Monitored => FunctionKind::Monitored,
            asm_lang::FunctionKind::Shared => FunctionKind::Shared,
            asm_lang::FunctionKind::Out => FunctionKind::Out,
            asm_lang::FunctionKind::Controlled => FunctionKind::Controlled,
            asm_lang::FunctionKind::Static => FunctionKind::Static,
            asm_lang::FunctionKind::Derived => FunctionKind::Derived,
            asm_lang::FunctionKind::Local => FunctionKind::Local,
        },
        domain: domain.join(", "),
        codomain: codomain(model, function),
        declared: function.span,
    }
}

fn codomain(model: &Model, function: &Function) -> Codomain {
    let root = model.types.root(function.codomain, &model.domains);
    match model.types.get(root) {
        Type::Boolean => Codomain::Boolean,
        Type::Integer | Type::Natural => Codomain::Integer,
        Type::Real => Codomain::Real,
        Type::String => Codomain::Text,
        Type::Domain(id) => {
            let domain = model.domain(*id);
            match domain.kind {
                DomainKind::Enum { first, count } => {
                    let literals = &model.atoms[first.0 as usize..(first.0 + count) as usize];
                    Codomain::Enum {
                        name: domain.name.to_string(),
                        literals: literals.iter().map(|atom| atom.name.to_string()).collect(),
                        declared: Some(domain.span),
                    }
                }
                _ => Codomain::Other(domain.name.to_string()),
            }
        }
        _ => Codomain::Other(model.show_type(function.codomain)),
    }
}

/// The variables and secret files of the process.
#[derive(Clone, Copy, Debug, Default)]
pub struct Variables;

impl Environment for Variables {
    fn variable(&self, name: &str) -> Option<String> {
        std::env::var(name).ok()
    }

    fn secret(&self, path: &str) -> Result<String, String> {
        let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
        Ok(text.trim_end_matches(['\r', '\n']).to_owned())
    }
}
