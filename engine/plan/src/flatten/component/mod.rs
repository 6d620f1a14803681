//! Resolves a component: defaults, substitutions and qualified names.

mod binding;
mod properties;
mod proxy;

use std::sync::Arc;

use crate::component::{Component, Port, Service};
use crate::plan::{Implementation, Pace};
use asmotion_composite::Catalogue;
use asmotion_composite::check::endpoints::{self, Endpoints};
use asmotion_composite::family::Member;
use asmotion_composite::model::{self, PlannedMapEntry, PlannedSpecialKeys};
use asmotion_composite::programs::directory_of;
use asmotion_composite::scope::{OutsideSettings, PropertyScope, SubstitutionNotes};
use asmotion_composite::table::Resolver;
use asmotion_composite::types::Types;
use asmotion_coordinator::Binding;
use asmotion_program::ProgramDeclaration;

/// Inputs for the resolution of a component.
pub(super) struct PartSource<'p> {
    pub member: &'p Member,
    /// Path of the file.
    pub path: &'p str,
    pub component: &'p model::Component,
    /// Its bindings, one for each location.
    pub bind: &'p model::binding::Bind,
    /// These bindings, if they have been resolved for another instance.
    pub binding: Option<Arc<Binding>>,
    pub face: &'p Endpoints,
    pub types: &'p Types<'p>,
    /// Name prefix of the enclosing composites.
    pub prefix: &'p str,
    pub scope: &'p PropertyScope<'p>,
    pub catalogue: &'p dyn Catalogue,
}

pub(super) fn component(
    source: &PartSource<'_>,
    set: OutsideSettings,
    notes: &mut SubstitutionNotes,
) -> Component {
    let component = source.component;
    let name = format!("{}{}", source.prefix, component.name.value);
    let id = component.pace().and_then(|pace| pace.id.as_ref());
    let id = id.map_or_else(
        || name.clone(),
        |id| format!("{}{}", source.prefix, id.value),
    );
    let properties = properties::properties(source, set, notes);
    let to = &mut Resolver::new(source.scope, source.prefix, notes);
    let implementation = implementation(source, to);
    Component {
        name,
        id,
        special: special(source, &implementation, to),
        implementation,
        pace: pace(source, to),
        lifecycle: to.or_default(component.lifecycle.as_ref()),
        inputs: source.face.inputs.iter().map(port).collect(),
        outputs: source.face.outputs.iter().map(port).collect(),
        services: source.face.services.iter().map(service).collect(),
        references: source.face.references.iter().map(service).collect(),
        properties,
        binding: match &source.binding {
            Some(binding) => Some(Arc::clone(binding)),
            None => binding::binding(source, to).map(Arc::new),
        },
        bridge: proxy::settings(source),
        program: program(source),
    }
}

fn port(port: &endpoints::EndpointPort) -> Port {
    Port {
        name: port.name.text.clone(),
        kind: port
            .kind
            .as_ref()
            .map_or(String::new(), |kind| kind.text.clone()),
        topic: port.topic.clone(),
    }
}

fn service(service: &endpoints::EndpointService) -> Service {
    Service {
        name: service.name.text.clone(),
        interface: service.interface.text.clone(),
    }
}

/// Returns the declaration of the program that implements the component.
fn program(source: &PartSource<'_>) -> Option<ProgramDeclaration> {
    let answer = source.member.program(&source.component.name.value)?;
    answer.as_ref().ok().cloned()
}

fn implementation(source: &PartSource<'_>, to: &mut Resolver<'_>) -> Implementation {
    let written = source.component.implementation.as_ref();
    match written.and_then(|written| to.of(written)) {
        Some(Implementation::Asm { file, main }) => Implementation::Asm {
            file: source.member.path(&file).unwrap_or(&file).to_owned(),
            main,
        },
        Some(Implementation::Process {
            command,
            directory,
            start_timeout_s,
            timeout_s,
        }) => {
            let directory = directory_of(directory.as_deref(), source.path);
            Implementation::Process {
                command,
                directory: Some(directory.display().to_string()),
                start_timeout_s,
                timeout_s,
            }
        }
        Some(resolved) => resolved,
        // the error has been reported, so this plan is never started
        None => Implementation::Rust(String::new()),
    }
}

fn special(
    source: &PartSource<'_>,
    implementation: &Implementation,
    to: &mut Resolver<'_>,
) -> PlannedSpecialKeys {
    let mut keys = to.or_default(Some(&source.component.special));
    if let Some(file) = &mut keys.protocol {
        *file = source.member.path(file).unwrap_or(file).to_owned();
    }
    for (name, _) in keys.parameters.iter_mut().chain(&mut keys.managed) {
        name.insert_str(0, source.prefix);
    }
    // the ports of a port-proxy are those of its target
    if let Implementation::Builtin {
        target: Some(target),
        ..
    } = implementation
    {
        for entry in &mut keys.map {
            if let PlannedMapEntry::Proxy(entry) = entry {
                entry.port.component.clone_from(target);
            }
        }
    }
    keys
}

/// Resolves the schedule, including the broker, which defaults to the composite's only one.
fn pace(source: &PartSource<'_>, to: &mut Resolver<'_>) -> Pace {
    let broker = source.member.broker_of(source.component);
    let mut pace = Pace {
        broker: broker.map(|name| to.local(name)),
        ..to.or_default(source.component.pace())
    };
    // no cycle is late that has no deadline
    if pace.deadline_ms.is_none() {
        pace.on_deadline = Default::default();
    }
    pace
}
