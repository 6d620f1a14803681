//! Checks promotions: the promoted element exists and the public name is unique.

use crate::codes::c010::ExclusiveKeys;
use crate::codes::c020::UnknownName;
use crate::codes::c048::IdleKey;
use crate::codes::c060::DuplicatePromotion;
use std::borrow::Cow;
use std::collections::BTreeMap;

use asmotion_diagnostics::{Report, Span};

use super::endpoints::{
    EndpointPort, EndpointService, Endpoints, NamedAt, PortDirection, PromotedTopic, TypeAt,
};
use super::scene::CheckedComposite;
use super::topic::Topics;
use crate::finding::Findings;
use crate::model::{End, Promoted, Promotion, Transport};
use crate::nearest::nearest;

/// Checks all promotions; returns the public ports, services and properties of the composite.
pub(crate) fn check(
    scene: &CheckedComposite<'_>,
    topics: &Topics,
    report: &mut Report,
) -> Endpoints {
    let mut face = Endpoints::default();
    let mut names: BTreeMap<(&'static str, &str), Span> = BTreeMap::new();
    let mut properties = Vec::new();
    for property in &scene.composite.properties {
        names.insert(("property", &property.name), property.name.span);
        properties.push(NamedAt::new(&property.name.value, Some(property.name.span)));
    }
    for promotion in &scene.composite.promotions {
        if !scene.active(&promotion.profiles) {
            continue;
        }
        let (what, name) = (promotion.what.kind(), &promotion.name);
        if let Some(first) = names.insert((what, name), name.span) {
            let (name, at) = (name.value.clone(), name.span);
            report.found(DuplicatePromotion {
                what,
                name,
                at,
                first,
            });
        }
        optional(promotion, report);
        idle_transport(promotion, report);
        let over_broker = promotion.over(Transport::Amqp);
        scene.broker(over_broker, promotion.broker.as_ref(), report);
        // HTTP is available for services only
        scene.transport(promotion.over(Transport::Ros), report);
        self::promotion(scene, promotion, topics, &mut face, &mut properties, report);
    }
    face.properties = Some(properties);
    face
}

fn promotion(
    scene: &CheckedComposite<'_>,
    promotion: &Promotion,
    topics: &Topics,
    face: &mut Endpoints,
    properties: &mut Vec<NamedAt>,
    report: &mut Report,
) {
    let name = NamedAt::new(&promotion.name.value, Some(promotion.name.span));
    match &promotion.what {
        Promoted::Service(end) => {
            if let Some((_, service)) = scene.service(end, report) {
                let interface = service.interface.clone();
                face.services.push(EndpointService {
                    name,
                    interface,
                    optional: false,
                });
            }
        }
        Promoted::Reference(end) => {
            if let Some((_, reference)) = scene.reference(end, report) {
                let optional = promotion.optional || reference.optional;
                let interface = reference.interface.clone();
                face.references.push(EndpointService {
                    name,
                    interface,
                    optional,
                });
            }
        }
        Promoted::Port(end) => {
            if let Some((_, way, port)) = scene.port(end, PortDirection::In, report) {
                let port = EndpointPort {
                    name,
                    kind: port.kind.clone(),
                    topic: None,
                    listed: true,
                    optional: false,
                };
                match way {
                    PortDirection::In => face.inputs.push(port),
                    PortDirection::Out => face.outputs.push(port),
                }
            }
        }
        Promoted::Property(end) => {
            if property(scene, end, report) {
                properties.push(name);
            }
        }
        Promoted::Topic(topic) => match topics.get(&topic.value) {
            Some(roles) => face.topics.push(PromotedTopic {
                name,
                kind: roles
                    .iter()
                    .find_map(|role| role.kind.clone())
                    .map(|kind| TypeAt {
                        at: kind.at,
                        text: kind.text,
                    }),
                published: roles.iter().any(|role| role.published),
                subscribed: roles.iter().any(|role| role.subscribed),
            }),
            None => {
                let known = topics
                    .iter()
                    .map(|(name, roles)| (name.as_str(), roles.first().map(|role| role.at)));
                report.found(UnknownName {
                    what: "topic",
                    name: topic.value.clone(),
                    at: topic.span,
                    nearest: nearest(topic, known),
                    left_out: None,
                });
            }
        },
    }
}

/// Reports `optional` on anything but a reference.
fn optional(promotion: &Promotion, report: &mut Report) {
    if promotion.optional && !matches!(promotion.what, Promoted::Reference(_)) {
        report.found(ExclusiveKeys {
            first: promotion.what.kind().to_owned(),
            first_at: promotion.name.span,
            second: "optional".to_owned(),
            at: promotion.span,
            reason: "only a reference can be optional",
        });
    }
}

/// Reports keys of transports on promotions that are not called over them.
fn idle_transport(promotion: &Promotion, report: &mut Report) {
    let is_service = matches!(promotion.what, Promoted::Service(_));
    let over_broker = promotion.over(Transport::Amqp);
    if let Some(binding) = over_broker
        && !is_service
    {
        report.found(IdleKey {
            key: Cow::Borrowed("binding"),
            at: binding.span,
            reason: "only a service is called at its promotion",
        });
    }
    if let Some(broker) = &promotion.broker
        && over_broker.is_none()
    {
        report.found(IdleKey {
            key: Cow::Borrowed("broker"),
            at: broker.span,
            reason: "only a promotion with `binding = \"amqp\"` uses a broker",
        });
    }
}

fn property(scene: &CheckedComposite<'_>, end: &End, report: &mut Report) -> bool {
    let Some(part) = scene.part(&end.component, report) else {
        return false;
    };
    let Some(known) = &part.face.properties else {
        return true;
    };
    let found = known.iter().any(|property| property.text == end.name.value);
    if !found {
        let known = known
            .iter()
            .map(|property| (property.text.as_str(), property.at));
        let nearest = nearest(&end.name, known);
        scene.unknown_part(part, "property", end, nearest, report);
    }
    found
}
