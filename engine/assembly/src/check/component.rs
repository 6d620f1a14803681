//! Components: what the composite says of each, against what its implementation declares.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use source::{Diagnostic, Report, Span};

use super::face::{Face, Kind, Named, Port, Service, Way};
use super::scene::{NameError, Part, Scene};
use crate::At;
use crate::choice::Choice;
use component::declaration::{
    Declaration, PortDeclaration, ReferenceDeclaration, ServiceDeclaration,
};
use crate::finding::{Finding, Findings};
use crate::model::{Builtin, Component, Implementation, Listed, Wanted};
use crate::nearest::{Nearest, Suggest, nearest, nearest_name};
use crate::read::error::has;

#[derive(Debug, thiserror::Error)]
pub(crate) enum ComponentError {
    #[error("`{component}` has two {way}s `{name}`")]
    PortTwice { way: &'static str, component: String, name: String, at: Span, first: Span },
    #[error("two components have the id `{id}`")]
    SameId { id: String, at: Span, first: Span },
    #[error("this build has no {what} `{name}`")]
    UnknownImplementation { what: &'static str, name: String, at: Span, nearest: Option<Nearest> },
    #[error("{what} `{name}` is not in this build")]
    NotInBuild { what: &'static str, name: String, at: Span },
    #[error("`{implementation}` has no {what} `{name}`")]
    NotDeclared {
        implementation: String,
        what: &'static str,
        name: String,
        at: Span,
        made_of: Span,
        known: Vec<String>,
    },
    #[error("{what} `{name}` of `{implementation}` is `{declared}`, not `{written}`")]
    DeclaredOtherwise {
        implementation: String,
        what: &'static str,
        name: String,
        declared: String,
        written: String,
        at: Span,
        made_of: Span,
    },
    #[error("`{component}` has no property `{name}`")]
    UnknownProperty {
        component: String,
        name: String,
        at: Span,
        made_of: Span,
        known: Vec<Named>,
    },
    #[error("`{implementation}` has no input `{name}`, so nobody reads what comes there")]
    NeverRead {
        implementation: String,
        name: String,
        at: Span,
        made_of: Span,
        known: Vec<String>,
    },
}

impl Finding for ComponentError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::PortTwice { at, first, .. } => Diagnostic::error("C018", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help("`ports.in` and `subscribe` share one set of names, and so do `ports.out` and `publish`"),
            Self::SameId { at, first, .. } => Diagnostic::error("C023", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help("the id names the component's queue, log and metrics; without `task.id` it is the component's name"),
            Self::UnknownImplementation { at, nearest, .. } => Diagnostic::error("C024", self)
                .label(*at, "not known")
                .suggest(*at, nearest),
            Self::NotInBuild { at, .. } => Diagnostic::warning("C025", self)
                .label(*at, "what the composite says of it is believed")
                .note("the composite can be checked, but not started here"),
            Self::NotDeclared { name, what, at, made_of, known, .. } => {
                Diagnostic::error("C026", self)
                    .label(*at, "not declared by the component")
                    .label(*made_of, "the component")
                    .suggest_or(
                        *at,
                        &nearest_name(name, known.iter().map(String::as_str)),
                        has(what, known.iter().map(String::as_str)),
                    )
            }
            Self::DeclaredOtherwise { declared, at, made_of, .. } => {
                Diagnostic::error("C027", self)
                    .label(*at, "written here")
                    .label(*made_of, format!("the component declares `{declared}`"))
                    .fix("write what the component declares", *at, declared)
            }
            Self::UnknownProperty { name, at, made_of, known, .. } => {
                let names = known.iter().map(|it| it.text.as_str());
                let all = known.iter().map(|it| (it.text.as_str(), it.at));
                Diagnostic::error("C028", self)
                    .label(*at, "no such property")
                    .label(*made_of, "the component")
                    .suggest_or(*at, &nearest(name, all), has("property", names))
            }
            Self::NeverRead { at, made_of, known, .. } => Diagnostic::warning("C029", self)
                .label(*at, "never read")
                .label(*made_of, "the component")
                .help(has("input", known.iter().map(String::as_str))),
        }
    }
}

/// The components that take part, with what they show.
pub(crate) fn parts<'s>(
    scene: &Scene<'s>,
    nested: &BTreeMap<String, Rc<Face>>,
    report: &mut Report,
) -> Vec<Part<'s>> {
    let mut ids: BTreeMap<String, Span> = BTreeMap::new();
    types(scene, report);
    let mut parts = Vec::new();
    for component in &scene.composite.components {
        if !scene.active(&component.profiles) {
            continue;
        }
        id(component, &mut ids, report);
        names(scene, component, report);
        let face = face(scene, component, nested, report);
        parts.push(Part { component, face });
    }
    parts
}

/// Types that nobody describes, each where it is named first.
fn types(scene: &Scene<'_>, report: &mut Report) {
    let components = scene.composite.components.iter();
    let active = components.filter(|component| scene.active(&component.profiles));
    let listed = active.flat_map(|it| [&it.inputs, &it.outputs, &it.subscribe, &it.publish]);
    let mut seen = BTreeSet::new();
    for Listed { kind, .. } in listed.flatten() {
        if seen.insert(kind.value.as_str()) {
            scene.types.known(kind, kind.span, report);
        }
    }
}

/// The id names the queue, the log and the metrics of a component.
fn id(component: &Component, ids: &mut BTreeMap<String, Span>, report: &mut Report) {
    let id = component.pace.as_ref().and_then(|pace| pace.id.as_ref());
    let id = id.unwrap_or(&component.name);
    if let Some(first) = ids.insert(id.value.clone(), id.span) {
        report.found(ComponentError::SameId { id: id.value.clone(), at: id.span, first });
    }
}

/// The names of other things that a component refers to.
fn names(scene: &Scene<'_>, component: &Component, report: &mut Report) {
    let Some(pace) = &component.pace else {
        return;
    };
    scene.broker(None, pace.broker.as_ref(), report);
    if let Some(master) = &pace.master
        && scene.composite.component(master).is_none()
    {
        scene.unknown_component(master, report);
    }
}

fn face(
    scene: &Scene<'_>,
    component: &Component,
    nested: &BTreeMap<String, Rc<Face>>,
    report: &mut Report,
) -> Face {
    let Some(implementation) = &component.implementation else {
        return Face { blank: true, ..listed(component, report) };
    };
    match implementation {
        Implementation::Composite(file) => match nested.get(&file.value) {
            Some(face) => {
                let face = Face::clone(face);
                properties(component, &face, implementation.span(), report);
                face
            }
            None => Face { blank: true, ..Face::default() },
        },
        Implementation::Rust(name) => {
            let face = listed(component, report);
            match scene.catalogue.declaration(name) {
                Some(declaration) => {
                    let face = declared(scene, face, name, &declaration, report);
                    properties(component, &face, name.span, report);
                    face
                }
                None => {
                    absent(scene, name, report);
                    face
                }
            }
        }
        Implementation::Builtin { name, kind, .. } => {
            builtin(scene, name, *kind, report);
            listed(component, report)
        }
        Implementation::Asm { .. }
        | Implementation::Process { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => listed(component, report),
    }
}

/// A name that the catalogue does not have: misspelt, or from another build.
fn absent(scene: &Scene<'_>, name: &At<String>, report: &mut Report) {
    let known = scene.catalogue.components();
    let (what, at) = ("component", name.span);
    match nearest_name(name, known.iter().map(String::as_str)) {
        nearest @ Some(_) => report.found(ComponentError::UnknownImplementation {
            what,
            name: name.value.clone(),
            at,
            nearest,
        }),
        None => report.found(ComponentError::NotInBuild { what, name: name.value.clone(), at }),
    }
}

fn builtin(
    scene: &Scene<'_>,
    name: &At<String>,
    kind: Option<Builtin>,
    report: &mut Report,
) {
    match kind {
        Some(kind) if scene.catalogue.has(kind) => {}
        Some(_) => report.found(ComponentError::NotInBuild {
            what: "built-in",
            name: name.value.clone(),
            at: name.span,
        }),
        None => report.found(ComponentError::UnknownImplementation {
            what: "built-in",
            name: name.value.clone(),
            at: name.span,
            nearest: nearest_name(name, Builtin::WORDS.iter().map(|(word, _)| *word)),
        }),
    }
}

/// What the composite lists of a component.
fn listed(component: &Component, report: &mut Report) -> Face {
    let mut face = Face::default();
    let mut first: BTreeMap<(&str, &str), Span> = BTreeMap::new();
    let lists = [
        (Way::In, &component.inputs, false),
        (Way::In, &component.subscribe, true),
        (Way::Out, &component.outputs, false),
        (Way::Out, &component.publish, true),
    ];
    for (way, list, on_topic) in lists {
        for entry in list {
            let key = (way.word(), entry.name.as_str());
            if let Some(first) = first.insert(key, entry.name.span) {
                report.found(ComponentError::PortTwice {
                    way: way.word(),
                    component: component.name.value.clone(),
                    name: entry.name.value.clone(),
                    at: entry.name.span,
                    first,
                });
                let ports = match way {
                    Way::In => &mut face.inputs,
                    Way::Out => &mut face.outputs,
                };
                let known = ports.iter_mut().find(|port| port.name.text == entry.name.value);
                if let Some(port) = known.filter(|_| on_topic) {
                    port.topic = Some(topic(component, &entry.name));
                }
                continue;
            }
            let port = Port {
                name: Named::new(&entry.name.value, Some(entry.name.span)),
                kind: Kind::new(&entry.kind.value, Some(entry.kind.span)),
                topic: on_topic.then(|| topic(component, &entry.name)),
                listed: true,
            };
            match way {
                Way::In => face.inputs.push(port),
                Way::Out => face.outputs.push(port),
            }
        }
    }
    face.services = component.services.iter().map(provided).collect();
    face.references = component.references.iter().map(wanted).collect();
    face
}

/// The topic that a name of a component is on: the name itself, or what it is renamed to.
pub(crate) fn topic(component: &Component, name: &str) -> String {
    let rename = component.rename.iter().find(|rename| rename.from.value == name);
    rename.map_or_else(|| name.to_owned(), |rename| rename.to.value.clone())
}

fn provided(listed: &Listed) -> Service {
    Service {
        name: Named::new(&listed.name.value, Some(listed.name.span)),
        interface: Kind { text: listed.kind.value.clone(), at: Some(listed.kind.span) },
        optional: false,
    }
}

fn wanted(wanted: &Wanted) -> Service {
    Service {
        name: Named::new(&wanted.name.value, Some(wanted.name.span)),
        interface: Kind { text: wanted.interface.value.clone(), at: Some(wanted.interface.span) },
        optional: wanted.optional,
    }
}

/// Holds what the composite lists against what the component declares, and adds what is not listed.
fn declared(
    scene: &Scene<'_>,
    listed: Face,
    implementation: &At<String>,
    declaration: &Declaration,
    report: &mut Report,
) -> Face {
    let mut compare = Compare { scene, implementation, report };
    let services: Vec<Declared> = declaration.services.iter().map(Declared::service).collect();
    let references: Vec<Declared> =
        declaration.references.iter().map(Declared::reference).collect();
    let properties = &declaration.properties;
    Face {
        inputs: compare.ports(listed.inputs, Way::In, &declaration.inputs),
        outputs: compare.ports(listed.outputs, Way::Out, &declaration.outputs),
        services: compare.services(listed.services, "service", &services),
        references: compare.services(listed.references, "reference", &references),
        topics: Vec::new(),
        properties: Some(properties.iter().map(|it| Named::new(&it.name, None)).collect()),
        blank: false,
    }
}

/// What services and references have in common.
struct Declared<'d> {
    name: &'d str,
    interface: &'d str,
    optional: bool,
}

impl<'d> Declared<'d> {
    fn service(declaration: &'d ServiceDeclaration) -> Self {
        let ServiceDeclaration { name, interface, .. } = declaration;
        Self { name, interface, optional: false }
    }

    fn reference(declaration: &'d ReferenceDeclaration) -> Self {
        let ReferenceDeclaration { name, interface, optional, .. } = declaration;
        Self { name, interface, optional: *optional }
    }
}

struct Compare<'c> {
    scene: &'c Scene<'c>,
    implementation: &'c At<String>,
    report: &'c mut Report,
}

impl Compare<'_> {
    fn ports(&mut self, listed: Vec<Port>, way: Way, declared: &[PortDeclaration]) -> Vec<Port> {
        for port in &listed {
            let Some(declared) = declared.iter().find(|it| it.name == port.name.text) else {
                self.undeclared(port, way, declared);
                continue;
            };
            if let Some(kind) = &port.kind
                && !self.scene.types.means(&kind.text, &declared.schema)
            {
                let is = declared.schema.to_string();
                self.otherwise(way.word(), &port.name, is, kind);
            }
        }
        let mut ports = listed;
        for declared in declared {
            if !ports.iter().any(|port| port.name.text == declared.name) {
                ports.push(Port {
                    name: Named::new(&declared.name, None),
                    kind: Kind::declared(&declared.schema),
                    topic: None,
                    listed: false,
                });
            }
        }
        ports
    }

    /// An output that is not there leaves its readers waiting for ever; an input that is not there
    /// merely is not read, unless its name was meant to be another one.
    fn undeclared(&mut self, port: &Port, way: Way, declared: &[PortDeclaration]) {
        let known: Vec<String> = declared.iter().map(|port| port.name.clone()).collect();
        let resembles = nearest_name(&port.name.text, known.iter().map(String::as_str)).is_some();
        if way == Way::In && !resembles {
            self.report.found(ComponentError::NeverRead {
                implementation: self.implementation.value.clone(),
                name: port.name.text.clone(),
                at: port.name.at.unwrap_or(self.implementation.span),
                made_of: self.implementation.span,
                known,
            });
            return;
        }
        self.not_declared(way.word(), &port.name, known);
    }

    fn services(
        &mut self,
        listed: Vec<Service>,
        what: &'static str,
        declared: &[Declared<'_>],
    ) -> Vec<Service> {
        let mut services = listed;
        for service in &mut services {
            let Some(declared) = declared.iter().find(|it| it.name == service.name.text) else {
                let known = declared.iter().map(|it| it.name.to_owned()).collect();
                self.not_declared(what, &service.name, known);
                continue;
            };
            service.optional |= declared.optional;
            if service.interface.text != declared.interface {
                let is = declared.interface.to_owned();
                self.otherwise(what, &service.name, is, &service.interface);
            }
        }
        for declared in declared {
            if !services.iter().any(|service| service.name.text == declared.name) {
                services.push(Service {
                    name: Named::new(declared.name, None),
                    interface: Kind { text: declared.interface.to_owned(), at: None },
                    optional: declared.optional,
                });
            }
        }
        services
    }

    fn not_declared(&mut self, what: &'static str, name: &Named, known: Vec<String>) {
        self.report.found(ComponentError::NotDeclared {
            implementation: self.implementation.value.clone(),
            what,
            name: name.text.clone(),
            at: name.at.unwrap_or(self.implementation.span),
            made_of: self.implementation.span,
            known,
        });
    }

    fn otherwise(&mut self, what: &'static str, name: &Named, declared: String, written: &Kind) {
        self.report.found(ComponentError::DeclaredOtherwise {
            implementation: self.implementation.value.clone(),
            what,
            name: name.text.clone(),
            declared,
            written: written.text.clone(),
            at: written.at.unwrap_or(self.implementation.span),
            made_of: self.implementation.span,
        });
    }
}

/// Properties that are set are there.
fn properties(component: &Component, face: &Face, made_of: Span, report: &mut Report) {
    let Some(known) = &face.properties else {
        return;
    };
    for setting in &component.properties {
        if !known.iter().any(|property| property.text == setting.name.value) {
            report.found(ComponentError::UnknownProperty {
                component: component.name.value.clone(),
                name: setting.name.value.clone(),
                at: setting.name.span,
                made_of,
                known: known.clone(),
            });
        }
    }
}

/// A thing that a built-in refers to.
pub(crate) fn unknown(
    what: &'static str,
    name: &At<String>,
    nearest: Option<Nearest>,
) -> NameError {
    NameError::Unknown { what, name: name.value.clone(), at: name.span, nearest }
}
