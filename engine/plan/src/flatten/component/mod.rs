//! Resolves a component: defaults, substitutions and qualified names.

mod binding;
mod properties;
mod proxy;

use crate::component::{Asm, BuiltinSettings, Component, Implementation, Port, Service};
use crate::plan::Pace;
use asmotion_composite::Catalogue;
use asmotion_composite::check::endpoints::{self, Endpoints};
use asmotion_composite::family::Member;
use asmotion_composite::model::{self, MapEntry};
use asmotion_composite::scope::{OutsideSettings, PropertyScope, SubstitutionNotes};
use asmotion_composite::table::Resolver;
use asmotion_composite::types::Types;

/// Inputs for the resolution of a component.
pub(super) struct PartSource<'p> {
    pub member: &'p Member,
    pub component: &'p model::Component,
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
    let binding = binding::binding(source, notes);
    let to = &mut Resolver::new(source.scope, source.prefix, notes);
    let map = component.map.iter();
    let proxy = map.clone().filter_map(|entry| match entry {
        MapEntry::Proxy(entry) => to.of(entry),
        MapEntry::Ros(_) => None,
    });
    let proxy = proxy.collect();
    let ros = map.filter_map(|entry| match entry {
        MapEntry::Ros(entry) => to.of(entry),
        MapEntry::Proxy(_) => None,
    });
    let ros = ros.collect();
    Component {
        name,
        id,
        implementation: implementation(source),
        pace: pace(source, to),
        lifecycle: to.or_default(component.lifecycle.as_ref()),
        inputs: source.face.inputs.iter().map(port).collect(),
        outputs: source.face.outputs.iter().map(port).collect(),
        services: source.face.services.iter().map(service).collect(),
        references: source.face.references.iter().map(service).collect(),
        properties,
        binding,
        verify: component.verify.as_ref().and_then(|it| to.of(it)),
        proxy,
        notify: component.notify.as_ref().and_then(|it| to.of(it)),
        bridge: proxy::settings(source),
        ros,
        plots: component.plots.iter().filter_map(|it| to.of(it)).collect(),
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

fn implementation(source: &PartSource<'_>) -> Implementation {
    use model::Implementation as Written;
    let list = |first: &str, rest: Vec<String>| {
        let mut all = vec![first.to_owned()];
        all.extend(rest);
        all
    };
    match &source.component.implementation {
        Some(Written::Rust(name)) => Implementation::Rust(name.value.clone()),
        Some(Written::Asm { file, main }) => Implementation::Asm(Asm {
            path: source.member.path(file).unwrap_or(file).to_owned(),
            main: main.as_ref().map(|main| main.value.clone()),
        }),
        Some(
            written @ Written::Builtin {
                name,
                target,
                bridge,
                port,
            },
        ) => {
            let local =
                |name: &asmotion_composite::At<String>| format!("{}{}", source.prefix, name.value);
            match written.builtin() {
                Some(kind) => Implementation::Builtin(BuiltinSettings {
                    kind,
                    target: target.as_ref().map(local),
                    bridge: bridge.as_ref().map(local),
                    port: port.as_ref().map(|port| port.value),
                }),
                None => Implementation::Rust(name.value.clone()),
            }
        }
        Some(Written::Process { command, arguments }) => {
            let arguments = arguments.iter().map(|it| it.value.clone()).collect();
            Implementation::Process(list(command, arguments))
        }
        Some(Written::Ros {
            package,
            executable,
        }) => {
            let executable = executable.iter().map(|it| it.value.clone()).collect();
            Implementation::Ros(list(package, executable))
        }
        Some(Written::Orocos {
            component,
            name_service,
        }) => {
            let name_service = name_service.iter().map(|it| it.value.clone()).collect();
            Implementation::Orocos(list(component, name_service))
        }
        // the error has been reported, so this plan is never started
        Some(Written::Composite(name)) => Implementation::Rust(name.value.clone()),
        None => Implementation::Rust(String::new()),
    }
}

/// Resolves the schedule, including the broker, which defaults to the composite's only one.
fn pace(source: &PartSource<'_>, to: &mut Resolver<'_>) -> Pace {
    let broker = source.member.composite.broker_of(source.component);
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
