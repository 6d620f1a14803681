//! Checks components against the declarations of their implementations.

use crate::codes::c018::DuplicatePort;
use crate::codes::c020::UnknownName;
use crate::codes::c023::DuplicateId;
use crate::codes::c024::UnknownImplementation;
use crate::codes::c025::ImplementationNotInBuild;
use crate::codes::c028::UnknownProperty;
use crate::codes::c076::UnsupportedKey;
use crate::codes::c128::NothingToVerify;
use crate::codes::c153::ProgramWithoutDeclaration;
use crate::codes::c154::ProgramElsewhere;
use crate::codes::c158::RobotWithoutDeclaration;
use crate::codes::c159::RobotNotAsked;
use crate::codes::c200::{InvalidWatch, WatchedPart};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use asmotion_component::Declaration;
use asmotion_diagnostics::{Report, Span};

use super::declared::declared;
use super::endpoints::{EndpointPort, EndpointService, Endpoints, NamedAt, PortDirection, TypeAt};
use super::operations::operations;
use super::scene::{CheckedComponent, CheckedComposite};
use super::schedule;
use crate::at::At;
use crate::finding::Findings;
use crate::model::{BuiltinComponent, Component, Implementation, Listed, Setting, Wanted};
use crate::named_list::NamedList;
use crate::nearest::{Nearest, nearest_name};
use crate::programs::{command_of, robot_component};
use crate::signature::{Codomain, Signature};
use asmotion_datum::Word;

/// Returns the active components with their ports, services and properties.
pub(crate) fn parts<'s>(
    scene: &CheckedComposite<'s>,
    nested: &BTreeMap<String, Rc<Endpoints>>,
    report: &mut Report,
) -> NamedList<CheckedComponent<'s>> {
    let mut ids: BTreeMap<String, Span> = BTreeMap::new();
    types(scene, report);
    let mut parts = NamedList::default();
    for component in &scene.composite.components {
        if !scene.active(&component.profiles) {
            continue;
        }
        id(component, &mut ids, report);
        schedule::check(scene, component, report);
        verify(scene, component, report);
        watch(scene, component, report);
        let face = face(scene, component, nested, report);
        safe(scene, component, &face, report);
        let bind = scene.family.bind(scene.member, component);
        parts.push(CheckedComponent {
            component,
            face,
            bind,
        });
    }
    parts
}

/// Reports undeclared types at their first occurrence.
fn types(scene: &CheckedComposite<'_>, report: &mut Report) {
    let components = scene.composite.components.iter();
    let active = components.filter(|component| scene.active(&component.profiles));
    let listed = active.flat_map(|it| {
        let ports = &it.ports;
        [&ports.inputs, &ports.outputs, &it.subscribe, &it.publish]
    });
    let mut seen = BTreeSet::new();
    for Listed { kind, .. } in listed.flatten() {
        if seen.insert(kind.value.as_str()) {
            scene.types.known(kind, kind.span, report);
        }
    }
}

/// Checks that component identifiers, which name queues, logs and metrics, are unique.
fn id(component: &Component, ids: &mut BTreeMap<String, Span>, report: &mut Report) {
    let id = component.pace().and_then(|pace| pace.id.as_ref());
    let id = id.unwrap_or(&component.name);
    if let Some(first) = ids.insert(id.value.clone(), id.span) {
        report.found(DuplicateId {
            id: id.value.clone(),
            at: id.span,
            first,
        });
    }
}

/// Reports keys of `verify` that name kinds of properties which the specification does not state.
fn verify(scene: &CheckedComposite<'_>, component: &Component, report: &mut Report) {
    let Some(verify) = &component.special.verify else {
        return;
    };
    super::verify::idle_keys(verify, report);
    let Some(Implementation::Asm { file, .. }) = &component.implementation else {
        return;
    };
    let Some(stated) = scene
        .family
        .specification(scene.member, &file.value)
        .and_then(Signature::stated_properties)
    else {
        return;
    };
    for (key, is_stated, kind) in [
        (&verify.ctl, stated.ctl, "CTL property"),
        (&verify.ltl, stated.ltl, "LTL property"),
        (&verify.invariants, stated.invariants, "invariant"),
    ] {
        if let Some(key) = key.as_ref().filter(|key| key.value && !is_stated) {
            report.found(NothingToVerify {
                component: component.name.value.clone(),
                kind,
                at: key.span,
            });
        }
    }
}

/// Checks that the safe rule and the properties of `watch` are a rule and conditions of the specification.
fn watch(scene: &CheckedComposite<'_>, component: &Component, report: &mut Report) {
    let Some(watch) = &component.special.watch else {
        return;
    };
    let Some(Implementation::Asm { file, .. }) = &component.implementation else {
        return;
    };
    let specification = scene.family.specification(scene.member, &file.value);
    let Some(specification) = specification else {
        return;
    };
    let rule = watch.safe_rule.as_ref();
    let rule = rule.map(|rule| (rule, WatchedPart::SafeRule, specification.rule(&rule.value)));
    let is_off = watch.temporal.as_ref().is_some_and(|it| !it.value);
    let properties = watch.properties.iter().map(|it| {
        if is_off {
            let reason = "no property is watched with `temporal = false`".to_owned();
            return (&it.property, WatchedPart::Unwatched, Err(reason));
        }
        let found = match specification.term(&it.property.value) {
            Ok(Some(Codomain::Boolean) | None) => Ok(()),
            Ok(Some(found)) => Err(format!("a property is Boolean, not {}", found.name())),
            Err(reason) => Err(reason),
        };
        (&it.property, WatchedPart::Property, found)
    });
    for (text, part, found) in rule.into_iter().chain(properties) {
        if let Err(reason) = found {
            report.found(InvalidWatch {
                part,
                text: text.value.clone(),
                reason,
                at: text.span,
            });
        }
    }
}

/// Checks that `lifecycle.safe` names outputs and has samples of their types.
fn safe(
    scene: &CheckedComposite<'_>,
    component: &Component,
    face: &Endpoints,
    report: &mut Report,
) {
    let lifecycle = component.lifecycle.iter();
    for Setting { name, value } in lifecycle.flat_map(|lifecycle| &lifecycle.safe) {
        let outputs = face.outputs.iter();
        match outputs.clone().find(|port| port.name.text == name.value) {
            Some(port) => {
                let kind = port.kind.as_ref();
                let schema = kind.and_then(|kind| scene.types.schema(&kind.text));
                if let Some(schema) = schema {
                    super::literal::check(scene.types, name, value, &schema, report);
                }
            }
            None if face.blank => {}
            None => {
                let outputs = outputs.map(|port| port.name.text.as_str());
                report.found(unknown("output", name, nearest_name(name, outputs)));
            }
        }
    }
}

fn face(
    scene: &CheckedComposite<'_>,
    component: &Component,
    nested: &BTreeMap<String, Rc<Endpoints>>,
    report: &mut Report,
) -> Endpoints {
    let Some(implementation) = &component.implementation else {
        return Endpoints {
            blank: true,
            ..listed(component, report)
        };
    };
    match implementation {
        Implementation::Composite(file) => match nested.get(&file.value) {
            Some(face) => {
                let face = Endpoints::clone(face);
                properties(component, &face, implementation.span(), report);
                face
            }
            None => Endpoints {
                blank: true,
                ..Endpoints::default()
            },
        },
        Implementation::Rust(name) => match scene.catalogue.declaration(name) {
            Some(declaration) => known(scene, component, name, &declaration, report),
            None => {
                let face = listed(component, report);
                absent(scene, name, report);
                face
            }
        },
        Implementation::Builtin { name, .. } => {
            builtin(scene, name, implementation.builtin(), report);
            if let Some(target) = robot_component(implementation) {
                return robot(scene, component, target, report);
            }
            let face = without_properties(component, implementation, report);
            operations(scene, component, name, &face, report);
            face
        }
        Implementation::Process { command, .. } => {
            let words = command.iter().map(|word| word.value.as_str());
            let words = words.collect::<Vec<_>>().join(" ");
            let at = command.first().map_or(component.name.span, |it| it.span);
            program(scene, component, &At::new(words, at), report)
        }
        Implementation::Ros {
            package,
            executable,
        } => {
            outside("ROS node", package, report);
            unsupported("executable", executable.as_ref(), report);
            listed(component, report)
        }
        Implementation::Orocos {
            component: name,
            name_service,
        } => {
            outside("Orocos component", name, report);
            unsupported("name_service", name_service.as_ref(), report);
            listed(component, report)
        }
        Implementation::Asm { file, .. } => {
            let face = without_properties(component, implementation, report);
            operations(scene, component, file, &face, report);
            face
        }
    }
}

/// Returns the ports and services of a component whose implementation has no properties.
fn without_properties(
    component: &Component,
    implementation: &Implementation,
    report: &mut Report,
) -> Endpoints {
    let face = Endpoints {
        properties: Some(Vec::new()),
        ..listed(component, report)
    };
    properties(component, &face, implementation.span(), report);
    face
}

/// Returns the ports, services and properties of a component whose declaration is known.
fn known(
    scene: &CheckedComposite<'_>,
    component: &Component,
    implementation: &At<String>,
    declaration: &Declaration,
    report: &mut Report,
) -> Endpoints {
    let face = listed(component, report);
    let face = declared(scene, face, implementation, declaration, report);
    properties(component, &face, implementation.span, report);
    operations(scene, component, implementation, &face, report);
    face
}

/// Returns the ports, services and properties of a component that a program implements.
fn program(
    scene: &CheckedComposite<'_>,
    component: &Component,
    command: &At<String>,
    report: &mut Report,
) -> Endpoints {
    match scene.member.program(&component.name.value) {
        Some(Ok(program)) => known(scene, component, command, &program.declaration, report),
        Some(Err(reason)) if scene.member.is_elsewhere(&component.name.value) => {
            report.found(ProgramElsewhere {
                command: command.value.clone(),
                at: command.span,
                unverified: members(component),
                reason: reason.clone(),
            });
            Endpoints {
                blank: true,
                ..listed(component, report)
            }
        }
        Some(Err(reason)) => {
            let directory = component.implementation.as_ref();
            let directory = directory.and_then(|it| command_of(it, scene.path));
            let directory = directory.map(|it| it.directory.display().to_string());
            report.found(ProgramWithoutDeclaration {
                command: command.value.clone(),
                at: command.span,
                directory: directory
                    .filter(|it| !it.is_empty())
                    .unwrap_or(".".to_owned()),
                reason: reason.clone(),
            });
            Endpoints {
                blank: true,
                ..listed(component, report)
            }
        }
        None => {
            report.found(ImplementationNotInBuild {
                what: "program",
                name: command.value.clone(),
                at: command.span,
                instead: Some(NOT_ASKED.to_owned()),
            });
            listed(component, report)
        }
    }
}

/// Returns the ports and services that another robot announces for one of its components.
fn robot(
    scene: &CheckedComposite<'_>,
    component: &Component,
    target: &At<String>,
    report: &mut Report,
) -> Endpoints {
    match scene.member.program(&component.name.value) {
        Some(Ok(announced)) => {
            return known(scene, component, target, &announced.declaration, report);
        }
        Some(Err(reason)) => report.found(RobotWithoutDeclaration {
            target: target.value.clone(),
            at: target.span,
            reason: reason.clone(),
        }),
        None => report.found(RobotNotAsked {
            target: target.value.clone(),
            at: target.span,
            unverified: members(component),
        }),
    }
    Endpoints {
        blank: true,
        ..listed(component, report)
    }
}

/// The ports, services, references and properties that the composite lists for a component, as words of a text.
fn members(component: &Component) -> Vec<String> {
    let listed = [
        ("input", &component.ports.inputs),
        ("input", &component.subscribe),
        ("output", &component.ports.outputs),
        ("output", &component.publish),
        ("service", &component.services),
    ];
    let listed = listed
        .into_iter()
        .flat_map(|(what, list)| list.iter().map(move |it| (what, &it.name)));
    let references = component
        .references
        .iter()
        .map(|it| ("reference", &it.name));
    let properties = component.properties.iter().map(|it| ("property", &it.name));
    let all = listed.chain(references).chain(properties);
    all.map(|(what, name)| format!("{what} `{}`", name.value))
        .collect()
}

/// Way out where a program was not asked for its declaration.
const NOT_ASKED: &str =
    "`asmotion check` without `--no-programs` starts it and asks for its ports and services";

/// Way out where an implementation is a program that this version does not start.
const OUTSIDE: &str = "start the program yourself; it takes part over the broker (docs/wire.md)";

/// Reports an implementation that is a program of its own, which this version does not start.
fn outside(what: &'static str, name: &At<String>, report: &mut Report) {
    report.found(ImplementationNotInBuild {
        what,
        name: name.value.clone(),
        at: name.span,
        instead: Some(OUTSIDE.to_owned()),
    });
}

/// Reports a key for a program outside.
fn unsupported(key: &'static str, value: Option<&At<String>>, report: &mut Report) {
    if let Some(value) = value {
        report.found(UnsupportedKey {
            key,
            at: value.span,
            instead: OUTSIDE.into(),
        });
    }
}

/// Reports an implementation missing from the catalogue, either misspelled or not part of this executable.
fn absent(scene: &CheckedComposite<'_>, name: &At<String>, report: &mut Report) {
    let known = scene.catalogue.components();
    let (what, at) = ("component", name.span);
    match nearest_name(name, known.iter().map(String::as_str)) {
        nearest @ Some(_) => report.found(UnknownImplementation {
            what,
            name: name.value.clone(),
            at,
            nearest,
        }),
        None => report.found(ImplementationNotInBuild {
            what,
            name: name.value.clone(),
            at,
            instead: Some(format!(
                "add `.component(\"{}\", …)` to the `App` of a program of your own (docs/extending.md), or run the \
                 program that contains it",
                name.value
            )),
        }),
    }
}

fn builtin(
    scene: &CheckedComposite<'_>,
    name: &At<String>,
    kind: Option<BuiltinComponent>,
    report: &mut Report,
) {
    match kind {
        Some(kind) if scene.catalogue.has(kind) => {}
        Some(_) => report.found(ImplementationNotInBuild {
            what: "built-in",
            name: name.value.clone(),
            at: name.span,
            instead: None,
        }),
        None => report.found(UnknownImplementation {
            what: "built-in",
            name: name.value.clone(),
            at: name.span,
            nearest: nearest_name(name, BuiltinComponent::words()),
        }),
    }
}

/// Returns the ports, services and properties listed in the composite.
fn listed(component: &Component, report: &mut Report) -> Endpoints {
    let mut face = Endpoints::default();
    let mut first: BTreeMap<(&str, &str), Span> = BTreeMap::new();
    let lists = [
        (PortDirection::In, &component.ports.inputs, false),
        (PortDirection::In, &component.subscribe, true),
        (PortDirection::Out, &component.ports.outputs, false),
        (PortDirection::Out, &component.publish, true),
    ];
    for (way, list, on_topic) in lists {
        for entry in list {
            let key = (way.word(), entry.name.as_str());
            if let Some(first) = first.insert(key, entry.name.span) {
                report.found(DuplicatePort {
                    way: way.word(),
                    component: component.name.value.clone(),
                    name: entry.name.value.clone(),
                    at: entry.name.span,
                    first,
                });
                let ports = match way {
                    PortDirection::In => &mut face.inputs,
                    PortDirection::Out => &mut face.outputs,
                };
                let known = ports
                    .iter_mut()
                    .find(|port| port.name.text == entry.name.value);
                if let Some(port) = known.filter(|_| on_topic) {
                    port.topic = Some(topic(component, &entry.name));
                }
                continue;
            }
            let port = EndpointPort {
                name: NamedAt::new(&entry.name.value, Some(entry.name.span)),
                kind: TypeAt::new(&entry.kind.value, Some(entry.kind.span)),
                topic: on_topic.then(|| topic(component, &entry.name)),
                listed: true,
                optional: false,
            };
            match way {
                PortDirection::In => face.inputs.push(port),
                PortDirection::Out => face.outputs.push(port),
            }
        }
    }
    face.services = component.services.iter().map(provided).collect();
    face.references = component.references.iter().map(wanted).collect();
    face
}

/// Returns the topic of a port: its own name or the renamed one.
pub fn topic(component: &Component, name: &str) -> String {
    let rename = component
        .rename
        .iter()
        .find(|rename| rename.from.value == name);
    rename.map_or_else(|| name.to_owned(), |rename| rename.to.value.clone())
}

fn provided(listed: &Listed) -> EndpointService {
    EndpointService {
        name: NamedAt::new(&listed.name.value, Some(listed.name.span)),
        interface: TypeAt {
            text: listed.kind.value.clone(),
            at: Some(listed.kind.span),
        },
        optional: false,
    }
}

fn wanted(wanted: &Wanted) -> EndpointService {
    EndpointService {
        name: NamedAt::new(&wanted.name.value, Some(wanted.name.span)),
        interface: TypeAt {
            text: wanted.interface.value.clone(),
            at: Some(wanted.interface.span),
        },
        optional: wanted.optional,
    }
}

/// Checks that properties set in the composite exist.
fn properties(component: &Component, face: &Endpoints, made_of: Span, report: &mut Report) {
    let Some(known) = &face.properties else {
        return;
    };
    for setting in &component.properties {
        if !known
            .iter()
            .any(|property| property.text == setting.name.value)
        {
            report.found(UnknownProperty::OfComponent {
                component: component.name.value.clone(),
                name: setting.name.value.clone(),
                at: setting.name.span,
                made_of,
                known: known.clone(),
            });
        }
    }
}

/// Reports an unknown name referenced by a built-in component.
pub(crate) fn unknown(
    what: &'static str,
    name: &At<String>,
    nearest: Option<Nearest>,
) -> UnknownName {
    UnknownName {
        what,
        name: name.value.clone(),
        at: name.span,
        nearest,
        left_out: None,
    }
}
