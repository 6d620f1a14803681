//! Checks that the messages on topics and brokers configured for CDR have types CDR can encode.

use crate::codes::c057::Uncarried;
use asmotion_datum::Schema;
use asmotion_diagnostics::{Report, Span};

use asmotion_component::HEALTH_TOPIC;

use super::endpoints::{PortDirection, TypeAt};
use super::scene::CheckedComposite;
use super::topic::Topics;
use crate::at::At;
use crate::finding::Findings;
use crate::model::{Broker, Codec, End};

/// Checks all topics.
pub(super) fn topics(scene: &CheckedComposite<'_>, topics: &Topics, report: &mut Report) {
    for (name, roles) in topics.iter().filter(|(name, _)| *name != HEALTH_TOPIC) {
        let mut written = scene.composite.topics.iter();
        let written = written.find(|topic| topic.name.value == *name);
        let own = written.and_then(|topic| topic.codec.as_ref());
        let mut typed = roles.iter();
        let typed = typed.find_map(|role| Some((role, role.kind.as_ref()?)));
        let Some((role, kind)) = typed else {
            continue;
        };
        let of_broker = || Some(broker(scene, role.component())?.1);
        let Some(codec) = own.or_else(of_broker) else {
            continue;
        };
        let (what, place) = (format!("topic `{name}`"), format!("topics.{name}"));
        carries(scene, kind, role.at, codec, (what, place), report);
    }
}

/// Checks a connection between two processes, which uses a broker.
pub(super) fn connection(scene: &CheckedComposite<'_>, from: &End, to: &End, report: &mut Report) {
    let part = scene.parts.named(&from.component);
    let port = part.and_then(|part| part.face.port(&from.name.value, PortDirection::Out));
    let kind = port.and_then(|(_, port)| port.kind.as_ref());
    let broker = broker(scene, Some(&from.component.value));
    if let (Some(kind), Some((broker, codec))) = (kind, broker) {
        let what = format!("the connection from `{from}` to `{to}`");
        let place = format!("brokers.{}", broker.name.value);
        carries(scene, kind, from.span(), codec, (what, place), report);
    }
}

/// Returns the broker configured for CDR that transports messages of the component: its own broker or, if it names
/// none, any broker.
fn broker<'s>(
    scene: &CheckedComposite<'s>,
    component: Option<&str>,
) -> Option<(&'s Broker, &'s At<Codec>)> {
    let composite = scene.composite;
    if composite.brokers.iter().all(|it| it.codec.is_none()) {
        return None;
    }
    let component = component.and_then(|name| scene.member.component(name));
    let home = component.and_then(|component| scene.member.broker_of(component));
    let is_home = |it: &&Broker| home.is_none_or(|home| home.value == it.name.value);
    let codec = |it: &'s Broker| Some((it, it.codec.as_ref()?));
    let mut said = composite.brokers.iter().filter(is_home).filter_map(codec);
    said.find(|(_, codec)| codec.value == Codec::Cdr)
}

fn carries(
    scene: &CheckedComposite<'_>,
    kind: &TypeAt,
    at: Span,
    codec: &At<Codec>,
    (what, place): (String, String),
    report: &mut Report,
) {
    if codec.value != Codec::Cdr {
        return;
    }
    let schema = scene.types.schema(&kind.text);
    let schema = schema.unwrap_or_else(|| Schema::opaque(kind.text.clone()));
    if let Err(reason) = asmotion_datum::Codec::Cdr.carries(&schema) {
        report.found(Uncarried {
            what,
            place,
            reason,
            codec: codec.span,
            at: kind.at.unwrap_or(at),
        });
    }
}
