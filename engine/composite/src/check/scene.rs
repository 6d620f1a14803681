//! A composite in one profile: which components take part, and what they show.

use crate::codes::c020::UnknownName;
use crate::codes::c021::UnknownMember;
use crate::codes::c022::MissingBroker;
use crate::codes::c025::ImplementationNotInBuild;
use asmotion_diagnostics::Report;

use super::endpoints::{
    EndpointPort, EndpointService, Endpoints, NamedAt, PortDirection, find, nearest_service,
};
use super::profile::takes_part;
use crate::at::At;
use crate::catalogue::Catalogue;
use crate::family::{Family, Member};
use crate::finding::Findings;
use crate::model::{Component, Composite, End, Implementation, Transport};
use crate::nearest::{Nearest, nearest};
use crate::types::Types;

/// A composite in one profile.
pub(crate) struct CheckedComposite<'s> {
    pub family: &'s Family,
    pub member: &'s Member,
    pub composite: &'s Composite,
    pub profile: Option<&'s str>,
    pub types: &'s Types<'s>,
    pub catalogue: &'s dyn Catalogue,
    /// The components that take part, in the order of the file.
    pub parts: Vec<CheckedComponent<'s>>,
}

/// A component that takes part.
pub(crate) struct CheckedComponent<'s> {
    pub component: &'s Component,
    pub face: Endpoints,
}

/// The file of a nested composite.
pub fn nested(component: &Component) -> Option<&str> {
    match &component.implementation {
        Some(Implementation::Composite(file)) => Some(file),
        _ => None,
    }
}

fn names<'n>(named: impl Iterator<Item = &'n NamedAt>) -> Vec<String> {
    named.map(|named| named.text.clone()).collect()
}

impl<'s> CheckedComposite<'s> {
    /// Whether something with these profiles takes part.
    pub(crate) fn active(&self, profiles: &[At<String>]) -> bool {
        takes_part(profiles, self.profile)
    }

    /// The component of this name, if it takes part; reports a name that no component has.
    pub(crate) fn part(
        &self,
        name: &At<String>,
        report: &mut Report,
    ) -> Option<&CheckedComponent<'s>> {
        let found = self
            .parts
            .iter()
            .find(|part| part.component.name.value == name.value);
        if found.is_none() && self.composite.component(name).is_none() {
            self.unknown_component(name, report);
        }
        found
    }

    /// Reports a name that no component has.
    pub(crate) fn unknown_component(&self, name: &At<String>, report: &mut Report) {
        let components = self.composite.components.iter();
        let known = components.map(|it| (it.name.value.as_str(), Some(it.name.span)));
        report.found(UnknownName {
            what: "component",
            name: name.value.clone(),
            at: name.span,
            nearest: nearest(name, known),
        });
    }

    /// The port an end names, if its component takes part; reports a port that is not there.
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

    /// The service an end names.
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

    /// The reference an end names.
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

    /// Reports something that a component does not have.
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

    /// Checks that this build has what something goes out over.
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
            }),
        }
    }

    /// Checks that there is a broker for something that goes over one.
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
