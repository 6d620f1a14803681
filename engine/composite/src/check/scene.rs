//! A composite in one profile, with its active components.

use crate::codes::c020::UnknownName;
use crate::codes::c021::UnknownMember;
use crate::codes::c022::MissingBroker;
use crate::codes::c025::ImplementationNotInBuild;
use asmotion_diagnostics::{Report, Span};
use std::borrow::Cow;
use std::collections::BTreeMap;

use super::endpoints::{
    EndpointPort, EndpointService, Endpoints, NamedAt, PortDirection, find, nearest_service,
};
use super::profile::takes_part;
use crate::at::At;
use crate::catalogue::{Catalogue, RosMessages};
use crate::family::{Family, Member};
use crate::finding::Findings;
use crate::model::binding::Bind;
use crate::model::{
    Amount, Bridge, Component, Composite, Delivery, Deploy, End, Implementation, Terminal,
    Transport,
};
use crate::named_list::{HasName, NamedList};
use crate::nearest::{Nearest, nearest};
use crate::types::Types;

/// A composite being checked in one profile.
pub(crate) struct CheckedComposite<'s> {
    pub family: &'s Family,
    /// Path of the file.
    pub path: &'s str,
    pub member: &'s Member,
    pub composite: &'s Composite,
    pub profile: Option<&'s str>,
    pub types: &'s Types<'s>,
    pub catalogue: &'s dyn Catalogue,
    /// Names of processes by component; `None` without a deployment.
    pub processes: Option<BTreeMap<&'s str, &'s str>>,
    /// Active components in file order.
    pub parts: NamedList<CheckedComponent<'s>>,
}

/// An active component.
pub(crate) struct CheckedComponent<'s> {
    pub component: &'s Component,
    pub face: Endpoints,
    /// Its bindings, one for each location.
    pub bind: Cow<'s, Bind>,
}

impl HasName for CheckedComponent<'_> {
    fn name(&self) -> &str {
        &self.component.name
    }
}

/// Returns the file name of a nested composite; `None` for other implementations.
pub fn nested(component: &Component) -> Option<&str> {
    match &component.implementation {
        Some(Implementation::Composite(file)) => Some(file),
        _ => None,
    }
}

/// Process name by component name.
pub(super) fn processes(deploy: &Deploy) -> BTreeMap<&str, &str> {
    let placed = deploy.processes.iter().flat_map(|process| {
        let components = process.components.iter();
        components.map(|component| (component.value.as_str(), process.name.value.as_str()))
    });
    placed.collect()
}

fn names<'n>(named: impl Iterator<Item = &'n NamedAt>) -> Vec<String> {
    named.map(|named| named.text.clone()).collect()
}

impl<'s> CheckedComposite<'s> {
    /// Returns whether the component cycles without messages: by its period, after its master, or to poll a connection.
    pub(crate) fn cycles_by_time(&self, component: &Component) -> bool {
        Self::has_pace(component) || self.composite.connections.iter().any(|connection| {
            let delivery = connection.policy.delivery.as_ref();
            let into = |end: &Terminal| matches!(end, Terminal::Port(end) if end.component.value == component.name.value);
            delivery.is_some_and(|delivery| delivery.value == Delivery::Poll)
                && connection.to.iter().any(into)
        })
    }

    /// Returns the types of ROS of a bridge, with those of its folders; `None` if the executable cannot connect it.
    pub(crate) fn ros(&self, bridge: &Bridge) -> Option<&dyn RosMessages> {
        let of_folders = self.member.ros(&bridge.name);
        of_folders.or_else(|| self.catalogue.ros(bridge.kind.value))
    }

    /// Returns whether the component cycles by its own period or after its master.
    pub(crate) fn has_pace(component: &Component) -> bool {
        let pace = component.pace();
        let period = pace.and_then(|pace| pace.period_ms.as_ref());
        let has_period = period.is_some_and(|it| !matches!(it.value, Amount::Number(0)));
        has_period || pace.is_some_and(|pace| pace.master.is_some())
    }

    /// Returns whether an element with these profiles is active in this profile.
    pub(crate) fn active(&self, profiles: &[At<String>]) -> bool {
        takes_part(profiles, self.profile)
    }

    /// Returns the component if it is active; reports an unknown name.
    pub(crate) fn part(
        &self,
        name: &At<String>,
        report: &mut Report,
    ) -> Option<&CheckedComponent<'s>> {
        let found = self.parts.named(name);
        if found.is_none() && self.member.component(name).is_none() {
            self.unknown_component(name, report);
        }
        found
    }

    /// Returns whether a component is active and its ports are not known, as for one of another robot that was not asked.
    pub(crate) fn has_unknown_ports(&self, name: &At<String>) -> bool {
        self.parts.named(name).is_some_and(|part| part.face.blank)
    }

    /// Reports an unknown component name.
    pub(crate) fn unknown_component(&self, name: &At<String>, report: &mut Report) {
        let components = self.composite.components.iter();
        let known = components.map(|it| (it.name.value.as_str(), Some(it.name.span)));
        report.found(UnknownName {
            what: "component",
            name: name.value.clone(),
            at: name.span,
            nearest: nearest(name, known),
            left_out: self.left_out(&name.value),
        });
    }

    /// Place in the composite that leaves a component of its base out.
    fn left_out(&self, component: &str) -> Option<Span> {
        let mut without = self.composite.without.iter();
        let is_it = |it: &&At<String>| it.value.strip_prefix("components.") == Some(component);
        without.find(is_it).map(|it| it.span)
    }

    /// Returns the port at an end if its component is active; reports an unknown port.
    pub(crate) fn port(
        &self,
        end: &End,
        wanted: PortDirection,
        report: &mut Report,
    ) -> Option<(&CheckedComponent<'s>, PortDirection, &EndpointPort)> {
        let part = self.part(&end.component, report)?;
        match part.face.port(&end.name, wanted) {
            Some((way, port)) => Some((part, way, port)),
            None => {
                let nearest = part.face.nearest_port(&end.name);
                self.unknown_part(part, "port", end, nearest, report);
                None
            }
        }
    }

    /// Returns the service at an end; reports an unknown service.
    pub(crate) fn service(
        &self,
        end: &End,
        report: &mut Report,
    ) -> Option<(&CheckedComponent<'s>, &EndpointService)> {
        let part = self.part(&end.component, report)?;
        let found = find(&part.face.services, &end.name);
        if found.is_none() {
            let nearest = nearest_service(&part.face.services, &end.name);
            self.unknown_part(part, "service", end, nearest, report);
        }
        Some((part, found?))
    }

    /// Returns the reference at an end; reports an unknown reference.
    pub(crate) fn reference(
        &self,
        end: &End,
        report: &mut Report,
    ) -> Option<(&CheckedComponent<'s>, &EndpointService)> {
        let part = self.part(&end.component, report)?;
        let found = find(&part.face.references, &end.name);
        if found.is_none() {
            let nearest = nearest_service(&part.face.references, &end.name);
            self.unknown_part(part, "reference", end, nearest, report);
        }
        Some((part, found?))
    }

    /// Reports an unknown member of a component.
    pub(crate) fn unknown_part(
        &self,
        part: &CheckedComponent<'_>,
        what: &'static str,
        end: &End,
        nearest: Option<Nearest>,
        report: &mut Report,
    ) {
        let face = &part.face;
        if face.blank {
            return;
        }
        let name = end.name.value.as_str();
        let instead = [
            ("a port", face.port(name, PortDirection::In).is_some()),
            ("a service", find(&face.services, name).is_some()),
            ("a reference", find(&face.references, name).is_some()),
        ];
        report.found(UnknownMember {
            what,
            component: end.component.value.clone(),
            name: name.to_owned(),
            at: end.name.span,
            instead: instead
                .into_iter()
                .find(|(_, is)| *is)
                .map(|(what, _)| what),
            nearest,
            known: match what {
                "service" => names(face.services.iter().map(|it| &it.name)),
                "reference" => names(face.references.iter().map(|it| &it.name)),
                "property" => names(face.properties.iter().flatten()),
                _ => names(face.inputs.iter().chain(&face.outputs).map(|it| &it.name)),
            },
        });
    }

    /// Checks that the executable supports the transport.
    pub(crate) fn transport(&self, binding: Option<&At<Transport>>, report: &mut Report) {
        let Some(binding) = binding else {
            return;
        };
        match binding.value {
            Transport::Local | Transport::Amqp => {}
            Transport::Ros | Transport::Http => report.found(ImplementationNotInBuild {
                what: "binding",
                name: binding.value.to_string(),
                at: binding.span,
                instead: None,
            }),
        }
    }

    /// Checks that a broker exists for an AMQP binding.
    pub(crate) fn broker(
        &self,
        binding: Option<&At<Transport>>,
        broker: Option<&At<String>>,
        report: &mut Report,
    ) {
        let brokers = &self.composite.brokers;
        if let Some(name) = broker {
            if !brokers.iter().any(|broker| broker.name.value == name.value) {
                let known = brokers
                    .iter()
                    .map(|it| (it.name.value.as_str(), Some(it.name.span)));
                report.found(UnknownName {
                    what: "broker",
                    name: name.value.clone(),
                    at: name.span,
                    nearest: nearest(name, known),
                    left_out: None,
                });
            }
            return;
        }
        let Some(binding) = binding.filter(|binding| binding.value == Transport::Amqp) else {
            return;
        };
        let reason = match brokers.len() {
            0 => "this composite has none",
            1 => return,
            _ => "this composite has several",
        };
        report.found(MissingBroker {
            at: binding.span,
            reason,
        });
    }
}
