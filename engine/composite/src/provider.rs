//! Wires that name the interface of their provider: each is resolved to the component that provides a service with this
//! interface.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use asmotion_component::Declaration;
use asmotion_diagnostics::Report;

use crate::at::At;
use crate::codes::c010::ExclusiveKeys;
use crate::codes::c151::NoSingleProvider;
use crate::codes::c185::NoSingleRosService;
use crate::finding::Findings;
use crate::model::{
    Component, Composite, Direction, End, Implementation, MapEntry, Promoted, ROS, Wire,
};
use crate::nearest::nearest_name;

/// Names and interfaces of services.
pub(crate) type NamedInterfaces = Vec<(String, String)>;

/// The services known to a composite.
pub(crate) struct ServiceScope<'s> {
    /// Returns the services that a nested composite promotes, by its file as written.
    pub promoted: &'s dyn Fn(&str) -> NamedInterfaces,
    /// Returns the declaration of a component; `None` if it is not known.
    pub declared: &'s dyn Fn(&Component) -> Option<Arc<Declaration>>,
}

/// A service that a component of the composite provides.
struct ProvidedService<'c> {
    component: &'c Component,
    name: String,
    interface: String,
}

/// Returns a wire to each provider; the wire as it is if there is no provider, or several in one profile.
fn resolved(
    wire: Wire,
    interface: &At<String>,
    services: &[ProvidedService<'_>],
    report: &mut Report,
) -> Vec<Wire> {
    let caller = &wire.reference.component.value;
    let providers: Vec<&ProvidedService<'_>> = services
        .iter()
        .filter(|it| it.interface == interface.value && it.component.name.value != *caller)
        .filter(|it| profiles(&wire, it.component).is_some())
        .collect();
    let mut pairs = providers
        .iter()
        .enumerate()
        .flat_map(|(at, one)| providers.iter().skip(at + 1).map(move |other| (one, other)));
    if providers.is_empty() || pairs.any(|(one, other)| share_a_profile(one, other)) {
        report.found(NoSingleProvider {
            interface: interface.value.clone(),
            reference: wire.reference.to_string(),
            providers: providers.iter().map(|it| it.to_string()).collect(),
            at: interface.span,
        });
        return vec![wire];
    }
    let wires = providers.iter().map(|provider| Wire {
        services: vec![End {
            component: At::new(provider.component.name.value.clone(), interface.span),
            name: At::new(provider.name.clone(), interface.span),
        }],
        profiles: profiles(&wire, provider.component).unwrap_or_default(),
        ..wire.clone()
    });
    wires.collect()
}

/// Replaces services of ROS, such as `ros:/make_plan`, by the services of the bridges that map them. A service that no bridge
/// maps, or several, is reported, and its wire then leads nowhere.
fn resolve_ros(composite: &mut Composite, report: &mut Report) {
    let Composite {
        components, wires, ..
    } = composite;
    for wire in wires {
        for end in &mut wire.services {
            if end.component.value != ROS {
                continue;
            }
            let name = end.name.clone();
            let mapped = components.iter().flat_map(mapped_services);
            let found: BTreeSet<(String, String)> = mapped
                .filter(|(ros, ..)| *ros == name.value)
                .map(|(_, component, service)| (component.to_owned(), service.to_owned()))
                .collect();
            let mut services = found.iter();
            if let (Some((component, service)), None) = (services.next(), services.next()) {
                end.component.value.clone_from(component);
                end.name.value.clone_from(service);
                continue;
            }
            let bridges = found.iter();
            let bridges = bridges.map(|(component, service)| format!("{component}.{service}"));
            let known: Vec<&str> = components
                .iter()
                .flat_map(mapped_services)
                .map(|(ros, ..)| ros)
                .collect();
            report.found(NoSingleRosService {
                ros: name.value.clone(),
                services: bridges.collect(),
                nearest: nearest_name(&name, known),
                at: name.span,
            });
            wire.interface = Some(At::new(format!("{ROS}{}", name.value), name.span));
        }
        wire.services.retain(|end| end.component.value != ROS);
    }
}

/// The services and actions of ROS that a bridge calls, each with the bridge and its service.
fn mapped_services(component: &Component) -> impl Iterator<Item = (&str, &str, &str)> {
    component.special.map.iter().filter_map(|entry| {
        let MapEntry::Ros(entry) = entry else {
            return None;
        };
        let (service, _) = entry.from.value.split_once('.')?;
        let is_called = entry.direction.value == Direction::ToRos;
        is_called.then_some((
            entry.ros.value.as_str(),
            component.name.value.as_str(),
            service,
        ))
    })
}

impl std::fmt::Display for ProvidedService<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.component.name.value, self.name)
    }
}

/// Returns the profiles that include both the wire and the component, empty for all; `None` if no profile does.
fn profiles(wire: &Wire, component: &Component) -> Option<Vec<At<String>>> {
    match (wire.profiles.as_slice(), component.profiles.as_slice()) {
        ([], all) | (all, []) => Some(all.to_vec()),
        (of_wire, of_component) => {
            let names: BTreeSet<&str> = of_component.iter().map(|it| it.value.as_str()).collect();
            let both = of_wire
                .iter()
                .filter(|it| names.contains(it.value.as_str()));
            let both: Vec<_> = both.cloned().collect();
            (!both.is_empty()).then_some(both)
        }
    }
}

fn share_a_profile(one: &ProvidedService<'_>, other: &ProvidedService<'_>) -> bool {
    let (one, other) = (&one.component.profiles, &other.component.profiles);
    let shares = |name: &At<String>| other.iter().any(|it| it.value == name.value);
    one.is_empty() || other.is_empty() || one.iter().any(shares)
}

impl ServiceScope<'_> {
    /// Replaces the interfaces that wires name by services; reports interfaces with no provider or several. Providers of
    /// different profiles get a wire each.
    pub(crate) fn resolve(&self, composite: &mut Composite, report: &mut Report) {
        resolve_ros(composite, report);
        if composite.wires.iter().all(|it| it.interface.is_none()) {
            return;
        }
        let components = composite.components.iter();
        let services: Vec<_> = components.flat_map(|it| self.provided(it)).collect();
        let mut wires = Vec::new();
        for wire in std::mem::take(&mut composite.wires) {
            match (wire.interface.clone(), wire.services.first()) {
                (None, _) => wires.push(wire),
                // reported as a service of ROS
                (Some(interface), None) if interface.value.starts_with(ROS) => wires.push(wire),
                (Some(interface), None) => match &wire.url {
                    Some(url) => {
                        report.found(ExclusiveKeys {
                            first: "url".to_owned(),
                            first_at: url.span,
                            second: "interface".to_owned(),
                            at: interface.span,
                            reason: "finds a component of this composite, but the `url` leads out of it",
                        });
                        wires.push(wire);
                    }
                    None => wires.extend(resolved(wire, &interface, &services, report)),
                },
                (Some(interface), Some(service)) => {
                    report.found(ExclusiveKeys {
                        first: "service".to_owned(),
                        first_at: service.span(),
                        second: "interface".to_owned(),
                        at: interface.span,
                        reason: "the service determines the interface",
                    });
                    wires.push(wire);
                }
            }
        }
        composite.wires = wires;
    }

    /// Returns the services that a composite promotes.
    pub(crate) fn promoted_by(&self, composite: &Composite) -> NamedInterfaces {
        let services = composite.promotions.iter().filter_map(|promotion| {
            let Promoted::Service(end) = &promotion.what else {
                return None;
            };
            let component = composite.component(&end.component)?;
            let mut provided = self.provided(component).into_iter();
            let service = provided.find(|it| it.name == end.name.value)?;
            Some((promotion.name.value.clone(), service.interface))
        });
        services.collect()
    }

    /// Returns the services of a component: those that it lists, those that its implementation declares, and those
    /// that its composite promotes.
    fn provided<'c>(&self, component: &'c Component) -> Vec<ProvidedService<'c>> {
        let mut services: BTreeMap<String, String> = BTreeMap::new();
        match &component.implementation {
            Some(
                Implementation::Rust(_)
                | Implementation::Process { .. }
                | Implementation::Builtin { .. },
            ) => {
                let declared = (self.declared)(component);
                let declared = declared.iter().flat_map(|it| &it.services);
                services.extend(declared.map(|it| (it.name.clone(), it.interface.clone())));
            }
            Some(Implementation::Composite(file)) => services.extend((self.promoted)(file)),
            Some(
                Implementation::Asm { .. }
                | Implementation::Ros { .. }
                | Implementation::Orocos { .. },
            )
            | None => {}
        }
        let listed = component.services.iter();
        services.extend(listed.map(|it| (it.name.value.clone(), it.kind.value.clone())));
        let services = services.into_iter();
        let services = services.map(|(name, interface)| ProvidedService {
            component,
            name,
            interface,
        });
        services.collect()
    }
}
