//! Components whose behaviour is given by a specification: coordinators, and components with a protocol.

use crate::error::{ModelError, failed};
use crate::own_messages::OwnMessages;
use crate::rename::{label, qualified, renamed};
use asmotion_coordinator::{Action, Argument, PublishWhen, Receive};
use asmotion_diagnostics::{Loader, Sources};
use asmotion_lang::hir::{self, LoadedFiles};
use asmotion_lang::syntax::ast;
use std::collections::BTreeMap;

/// A component whose behaviour is given by a specification.
#[derive(Debug)]
pub(crate) struct Actor {
    /// Name of the component in the plan.
    pub component: String,
    /// `true` if the specification is a protocol.
    pub is_protocol: bool,
    /// Its own files, the main one last; without those of the specification that is verified.
    pub trees: Vec<ast::File>,
    /// Name of the main rule.
    pub main: String,
    /// Its names as declared, with those in the specification of the whole.
    pub names: BTreeMap<String, String>,
    /// Its functions by the names that they have in the specification of the whole.
    pub functions: BTreeMap<String, FunctionFacts>,
    pub inputs: Vec<ActorInput>,
    pub outputs: Vec<ActorOutput>,
    pub echoes: Vec<Echo>,
    /// Contents of its messages, as its binding describes them, if its specification is a protocol.
    pub own_messages: OwnMessages,
    /// Least and greatest number of its steps between two steps of the specification that is verified.
    pub steps: (u32, u32),
    /// Paths of its files with their texts, for readers of the environment.
    pub texts: Vec<(String, String)>,
}

impl Actor {
    /// Returns `true` if its specification says what it sends through a port or a reference.
    pub fn covers(&self, end: &str) -> bool {
        !self.is_protocol || covers(&self.outputs, end)
    }
}

/// Returns `true` if one of the outputs of a protocol is sent through a port or a reference.
pub(crate) fn covers(outputs: &[ActorOutput], end: &str) -> bool {
    outputs.iter().any(|it| match &it.effect {
        OutputEffect::Publish { port, .. } => port == end,
        OutputEffect::Send { reference, .. } => reference == end,
        OutputEffect::Reply { .. } | OutputEffect::Cases(_) => false,
    })
}

/// The properties of a function that the environment needs.
#[derive(Clone, Debug)]
pub(crate) struct FunctionFacts {
    pub kind: ast::FunctionKind,
    /// Text of the domain; empty without arguments.
    pub domain: String,
    /// Names of the elements of each parameter's domain; `None` if they are not listed.
    pub elements: Vec<Option<Vec<ElementName>>>,
    pub codomain: Codomain,
}

/// An element of a domain: its name as declared, and in the specification of the whole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ElementName {
    pub declared: String,
    pub name: String,
}

/// The values of a function.
#[derive(Clone, Debug)]
pub(crate) struct Codomain {
    /// Its name in the specification of the whole.
    pub text: String,
    /// Its elements, unless they are truth values or not listed.
    pub elements: Option<Vec<ElementName>>,
}

impl Codomain {
    pub fn is_boolean(&self) -> bool {
        self.text == "Boolean"
    }

    /// The element with the name that a message carries: the exact one, or one that differs in case only.
    pub fn named(&self, text: &str) -> Option<&ElementName> {
        let elements = self.elements.as_deref().unwrap_or_default();
        let exact = elements.iter().find(|it| it.declared == text);
        exact.or_else(|| {
            let mut elements = elements.iter();
            elements.find(|it| it.declared.eq_ignore_ascii_case(text))
        })
    }
}

/// The origin of the values of an input.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum InputOrigin {
    Port(String),
    Request {
        service: String,
        operation: String,
    },
    /// Outcomes of calls only.
    Calls,
    /// The condition, a term.
    Timer(String),
    Losses,
    /// The value, a term.
    Value(String),
}

/// A location of a monitored function.
#[derive(Clone, Debug)]
pub(crate) struct ActorInput {
    /// The location, as in `wants(ROB1)`.
    pub location: String,
    /// The same as part of a name, as in `wants_ROB1`.
    pub word: String,
    pub function: String,
    pub codomain: Codomain,
    pub origin: InputOrigin,
    pub receive: Receive,
    pub field: Option<String>,
    /// The texts for which it is true.
    pub is: Vec<String>,
    /// The value without a message; `None` for undef.
    pub none: Option<String>,
    /// The value if the last message is too old, if it can be.
    pub stale: Option<String>,
    pub matching: Vec<(String, Argument)>,
    /// Fields of a message with the elements, as declared, that select this location.
    pub key: Vec<(String, String)>,
}

/// A location of an out function.
#[derive(Clone, Debug)]
pub(crate) struct ActorOutput {
    pub location: String,
    pub word: String,
    pub function: String,
    pub codomain: Codomain,
    pub effect: OutputEffect,
}

/// The effect of an update.
#[derive(Clone, Debug)]
pub(crate) enum OutputEffect {
    Publish {
        port: String,
        field: Option<String>,
        key: Vec<(String, String)>,
        when: PublishWhen,
    },
    /// A request without a reply, with the value in a field.
    Send {
        reference: String,
        operation: String,
        field: Option<String>,
    },
    /// The reply to a request.
    Reply { service: String, operation: String },
    /// Actions for literals.
    Cases(Vec<(ElementName, Vec<Action>)>),
}

/// A field of a message that repeats a field of the newest message of an input.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Echo {
    pub output: String,
    pub field: String,
    pub input: String,
    pub input_field: String,
}

/// The files of a specification and the names in them.
pub(crate) struct ReadFiles {
    /// All files as written, with those that are imported.
    pub loaded: LoadedFiles,
    pub trees: Vec<ast::File>,
    pub names: BTreeMap<String, String>,
    pub functions: BTreeMap<String, FunctionFacts>,
    pub main: String,
    pub texts: Vec<(String, String)>,
}

/// Reads the files of a component's specification. With a component, all names get it as a prefix.
pub(crate) fn read(
    path: &str,
    loader: &dyn Loader,
    sources: &mut Sources,
    component: Option<&str>,
) -> Result<ReadFiles, ModelError> {
    let mut loaded = hir::load(path, loader, sources);
    let (model, found) = hir::analyse(&mut loaded, sources);
    let Some(model) = model else {
        let mut report = loaded.report;
        report.extend(found);
        return Err(failed(sources, report));
    };
    if !asmotion_lang::ir::message_uses(&model).is_empty() {
        return Err(ModelError::Messages(path.to_owned()));
    }
    let own: Vec<&hir::SourceUnit> = loaded.units.iter().filter(|unit| !unit.library).collect();
    let declared: Vec<&ast::File> = own.iter().map(|unit| &unit.tree).collect();
    let names: BTreeMap<String, String> = match component {
        Some(component) => {
            let label = label(component);
            let names = declared_names(&declared).into_iter();
            names
                .map(|name| (name.clone(), qualified(&label, &name)))
                .collect()
        }
        None => BTreeMap::new(),
    };
    let mut trees = Vec::new();
    let mut texts = Vec::new();
    if let Some(component) = component {
        for unit in &own {
            let text = renamed(sources.text(unit.file), &names);
            let file = sources.add(&format!("{} ({component})", unit.path), text.clone());
            let parsed = asmotion_lang::syntax::parse(file, &text);
            if parsed.report.has_errors() {
                return Err(failed(sources, parsed.report));
            }
            trees.push(parsed.file);
            texts.push((unit.path.clone(), text));
        }
    }
    let functions = facts(&declared, &names);
    let main = declared.last().and_then(|tree| tree.main.as_ref());
    let Some(main) = main.map(|main| main.name.text.to_string()) else {
        return Err(ModelError::NoMainRule(path.to_owned()));
    };
    let main = names.get(&main).cloned().unwrap_or(main);
    Ok(ReadFiles {
        loaded,
        trees,
        names,
        functions,
        main,
        texts,
    })
}

/// The names that files declare.
pub(crate) fn declared_names(trees: &[&ast::File]) -> Vec<String> {
    let mut names = Vec::new();
    for tree in trees {
        for domain in &tree.domains {
            if !matches!(domain.kind, ast::DomainKind::Structured(_)) {
                names.push(domain.name.text.to_string());
            }
            if let ast::DomainKind::Enum(literals) = &domain.kind {
                names.extend(literals.iter().map(|it| it.text.to_string()));
            }
        }
        names.extend(tree.functions.iter().map(|it| it.name.text.to_string()));
        let rules = tree.rules.iter().chain(&tree.main);
        names.extend(rules.map(|it| it.name.text.to_string()));
    }
    names
}

/// The functions that files declare.
fn facts(
    trees: &[&ast::File],
    names: &BTreeMap<String, String>,
) -> BTreeMap<String, FunctionFacts> {
    let own = |name: &str| names.get(name).cloned().unwrap_or_else(|| name.to_owned());
    let enums: BTreeMap<&str, Vec<ElementName>> = trees
        .iter()
        .flat_map(|tree| &tree.domains)
        .filter_map(|domain| {
            let ast::DomainKind::Enum(literals) = &domain.kind else {
                return None;
            };
            let literals = literals.iter().map(|literal| ElementName {
                declared: literal.text.to_string(),
                name: own(&literal.text),
            });
            Some((&*domain.name.text, literals.collect()))
        })
        .collect();
    let elements = |kind: &ast::Type| match &kind.kind {
        ast::TypeKind::Named(name) if &**name == "Boolean" => {
            let truths = ["false", "true"].map(|it| ElementName {
                declared: it.to_owned(),
                name: it.to_owned(),
            });
            Some(truths.to_vec())
        }
        ast::TypeKind::Named(name) => enums.get(&**name).cloned(),
        ast::TypeKind::Rule(_)
        | ast::TypeKind::Prod(_)
        | ast::TypeKind::Seq(_)
        | ast::TypeKind::Powerset(_)
        | ast::TypeKind::Bag(_)
        | ast::TypeKind::Map(..) => None,
    };
    let functions = trees.iter().flat_map(|tree| &tree.functions);
    functions
        .map(|function| {
            let parameters = function
                .domain
                .iter()
                .flat_map(|domain| match &domain.kind {
                    ast::TypeKind::Prod(parts) => parts.iter().map(elements).collect::<Vec<_>>(),
                    ast::TypeKind::Named(_)
                    | ast::TypeKind::Rule(_)
                    | ast::TypeKind::Seq(_)
                    | ast::TypeKind::Powerset(_)
                    | ast::TypeKind::Bag(_)
                    | ast::TypeKind::Map(..) => vec![elements(domain)],
                });
            let domain = function.domain.as_ref();
            let codomain = Codomain {
                text: type_text(&function.codomain, &own),
                elements: match &function.codomain.kind {
                    ast::TypeKind::Named(name) => enums.get(&**name).cloned(),
                    ast::TypeKind::Rule(_)
                    | ast::TypeKind::Prod(_)
                    | ast::TypeKind::Seq(_)
                    | ast::TypeKind::Powerset(_)
                    | ast::TypeKind::Bag(_)
                    | ast::TypeKind::Map(..) => None,
                },
            };
            let facts = FunctionFacts {
                kind: function.kind,
                domain: domain.map_or_else(String::new, |it| type_text(it, &own)),
                elements: parameters.collect(),
                codomain,
            };
            (own(&function.name.text), facts)
        })
        .collect()
}

/// The text of a domain.
fn type_text(kind: &ast::Type, own: &dyn Fn(&str) -> String) -> String {
    let list = |parts: &[ast::Type]| {
        let parts = parts.iter().map(|part| type_text(part, own));
        parts.collect::<Vec<_>>().join(", ")
    };
    match &kind.kind {
        ast::TypeKind::Named(name) => own(name),
        ast::TypeKind::Rule(parts) if parts.is_empty() => "Rule".to_owned(),
        ast::TypeKind::Rule(parts) => format!("Rule({})", list(parts)),
        ast::TypeKind::Prod(parts) => format!("Prod({})", list(parts)),
        ast::TypeKind::Seq(part) => format!("Seq({})", type_text(part, own)),
        ast::TypeKind::Powerset(part) => format!("Powerset({})", type_text(part, own)),
        ast::TypeKind::Bag(part) => format!("Bag({})", type_text(part, own)),
        ast::TypeKind::Map(from, to) => {
            format!("Map({}, {})", type_text(from, own), type_text(to, own))
        }
    }
}

/// The name of an input or output as part of other names.
pub(crate) fn word(actor: &Actor, input: &ActorInput) -> String {
    qualified_word(actor, &input.word)
}

pub(crate) fn qualified_word(actor: &Actor, word: &str) -> String {
    if actor.names.is_empty() {
        word.to_owned()
    } else {
        format!("{}_{word}", label(&actor.component))
    }
}
