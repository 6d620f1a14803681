//! Checks wires: every reference is connected exactly once, to a service with the same interface.

use std::borrow::Cow;

use crate::codes::c030::WireMismatch;
use crate::codes::c031::DanglingReference;
use crate::codes::c032::{ReferenceWiredTwice, WIRED_TWICE};
use crate::codes::c033::NoTimeout;
use crate::codes::c048::IdleKey;
use crate::codes::c189::TimeoutWithinPeriod;
use std::collections::{BTreeMap, BTreeSet};

use asmotion_diagnostics::{Report, Span};

use super::endpoints::EndpointService;
use super::meant::meant;
use super::scene::{CheckedComponent, CheckedComposite};
use super::{external, fan_out};
use crate::finding::Findings;
use crate::model::{Amount, DEFAULT_TIMEOUT_MS, End, Promoted, Transport, Wire};

pub(crate) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    let mut joined = Joined::default();
    for wire in &scene.composite.wires {
        if scene.active(&wire.profiles) {
            self::wire(scene, wire, &mut joined, report);
        }
    }
    for promotion in &scene.composite.promotions {
        if let Promoted::Reference(end) = &promotion.what
            && scene.active(&promotion.profiles)
        {
            let key = (end.component.value.clone(), end.name.value.clone());
            joined.take(key, end.span(), None, report);
        }
    }
    for part in &scene.parts {
        for reference in &part.face.references {
            dangling(part, reference, &joined, report);
        }
    }
}

/// Connected references with the location of their connections, and the wires among them; the others are promotions.
#[derive(Default)]
struct Joined<'w> {
    places: BTreeMap<(String, String), Vec<JoinedAt<'w>>>,
    /// References presumably meant by wires with a misspelled name; not reported as unconnected.
    meant: BTreeSet<(String, String)>,
}

/// A connection of a reference.
struct JoinedAt<'w> {
    at: Span,
    /// `None` for a promotion.
    wire: Option<&'w Wire>,
}

impl<'w> Joined<'w> {
    fn take(
        &mut self,
        key: (String, String),
        at: Span,
        wire: Option<&'w Wire>,
        report: &mut Report,
    ) {
        let reference = format!("{}.{}", key.0, key.1);
        let places = self.places.entry(key).or_default();
        let mut others = places.iter();
        let other = others.find(|other| !are_alternatives(other.wire, wire));
        if let Some(other) = other {
            let how = match (other.wire, wire) {
                (Some(_), Some(_)) => WIRED_TWICE,
                (None, None) => "promoted twice",
                (Some(_), None) | (None, Some(_)) => "wired and promoted",
            };
            report.found(ReferenceWiredTwice {
                reference,
                how,
                at,
                first: other.at,
            });
        }
        places.push(JoinedAt { at, wire });
    }
}

/// Returns whether a call can go to either of two wires: each has one service, and a binding of its own.
fn are_alternatives(one: Option<&Wire>, other: Option<&Wire>) -> bool {
    let (Some(one), Some(other)) = (one, other) else {
        return false;
    };
    let binding = |wire: &Wire| {
        wire.binding
            .as_ref()
            .map_or(Transport::Local, |it| it.value)
    };
    let has_one = |wire: &Wire| wire.services.len() < 2;
    has_one(one) && has_one(other) && binding(one) != binding(other)
}

fn wire<'w>(
    scene: &CheckedComposite<'_>,
    wire: &'w Wire,
    joined: &mut Joined<'w>,
    report: &mut Report,
) {
    let found = scene.reference(&wire.reference, report);
    let reference = found.map(|(_, reference)| reference);
    let mut answered = false;
    for end in &wire.services {
        let absent = scene.member.component(&end.component).is_some()
            && scene.parts.named(&end.component).is_none();
        answered |= !absent;
        let Some((_, service)) = scene.service(end, report) else {
            continue;
        };
        let Some(reference) = reference else {
            continue;
        };
        if reference.interface.text != service.interface.text {
            report.found(WireMismatch {
                reference: wire.reference.to_string(),
                wanted: reference.interface.clone(),
                service: end.to_string(),
                found: service.interface.clone(),
                at: end.span(),
                reference_at: wire.reference.span(),
            });
        }
    }
    external::check(wire, report);
    idle_keys(wire, report);
    idle_within_process(scene, wire, report);
    short_timeout(scene, wire, report);
    if !answered && !wire.services.is_empty() {
        return;
    }
    let end = &wire.reference;
    let key = (end.component.value.clone(), end.name.value.clone());
    joined.take(key, end.span(), Some(wire), report);
    if reference.is_none() {
        joined.meant.extend(meant(scene, end, |part| {
            let references = part.face.references.iter();
            references.map(|it| it.name.text.as_str()).collect()
        }));
    }
    let over_http = external::is_over_http(wire);
    if !over_http {
        scene.broker(wire.binding.as_ref(), wire.broker.as_ref(), report);
        scene.transport(wire.binding.as_ref(), report);
    }
    if let Some((part, reference)) = found {
        if waits(wire) || wire.services.len() > 1 {
            fan_out::check(scene, wire, part, reference, report);
        } else {
            fan_out::without_reply(part, &wire.reference.name.value, report);
        }
    }
    if reference.is_some() && waits(wire) && wire.timeout_ms.is_none() {
        let (reference, at) = (wire.reference.to_string(), wire.reference.span());
        report.found(NoTimeout {
            reference,
            default_ms: DEFAULT_TIMEOUT_MS,
            at,
        });
    }
}

/// Reports a timeout within which a periodic provider may have no cycle.
fn short_timeout(scene: &CheckedComposite<'_>, wire: &Wire, report: &mut Report) {
    let Some(timeout) = wire.timeout_ms.as_ref().filter(|_| waits(wire)) else {
        return;
    };
    for end in &wire.services {
        let provider = scene.parts.named(&end.component);
        let pace = provider.and_then(|part| part.component.pace());
        let Some(period) = pace.and_then(|pace| pace.period_ms.as_ref()) else {
            continue;
        };
        if let Amount::Number(period_ms) = period.value
            && period_ms > timeout.value
        {
            report.found(TimeoutWithinPeriod {
                reference: wire.reference.to_string(),
                timeout_ms: timeout.value,
                provider: end.component.value.clone(),
                period_ms,
                at: timeout.span,
                period_at: period.span,
            });
        }
    }
}

/// Reports keys of retries and cancellations where there are none.
fn idle_keys(wire: &Wire, report: &mut Report) {
    let mut idle = |key, at, reason| {
        report.found(IdleKey {
            key: Cow::Borrowed(key),
            at,
            reason,
        })
    };
    let retry = wire.retry.as_ref();
    let attempts = retry.and_then(|it| it.attempts.as_ref());
    let attempts = attempts.filter(|it| it.value > 0);
    let backoff = retry.and_then(|it| it.backoff_ms.as_ref());
    if let (Some(backoff), None) = (backoff, attempts) {
        let reason = "no call is repeated without `attempts`";
        idle("backoff_ms", backoff.span, reason);
    }
    if waits(wire) {
        return;
    }
    if let Some(attempts) = attempts {
        let reason = "a call without a reply does not fail, and is not repeated";
        idle("attempts", attempts.span, reason);
    }
    if let Some(cancel) = &wire.cancel {
        let reason = "a call without a reply does not time out";
        idle("cancel", cancel.span, reason);
    }
}

/// Reports keys of the way over a broker or a network on a wire within a process.
fn idle_within_process(scene: &CheckedComposite<'_>, wire: &Wire, report: &mut Report) {
    let binding = wire.binding.as_ref();
    let is_local = binding.is_none_or(|it| it.value == Transport::Local);
    if !is_local || wire.url.is_some() || is_across(scene, wire) {
        return;
    }
    let mut idle = |key, at, reason| {
        report.found(IdleKey {
            key: Cow::Borrowed(key),
            at,
            reason,
        });
    };
    if let Some(broker) = &wire.broker {
        let reason = "the wire is within a process; `binding = \"amqp\"` leads over a broker";
        idle("broker", broker.span, reason);
    }
    // over a broker or HTTP, this is the time in which a request without a reply finds its service
    if let Some(timeout_ms) = wire.timeout_ms.as_ref().filter(|_| !waits(wire)) {
        let reason = "within a process, a call without a reply takes no time";
        idle("timeout_ms", timeout_ms.span, reason);
    }
}

/// Returns whether a service of the wire is in another process than its caller. Components of a nested composite are in one
/// process.
fn is_across(scene: &CheckedComposite<'_>, wire: &Wire) -> bool {
    let Some(processes) = &scene.processes else {
        return false;
    };
    let process = |end: &End| processes.get(end.component.value.as_str());
    let mut services = wire.services.iter();
    services.any(|service| process(service) != process(&wire.reference))
}

/// Returns whether the caller waits for a reply. Calls to several services are one-way.
pub fn waits(wire: &Wire) -> bool {
    let oneway = wire.oneway.as_ref().is_some_and(|oneway| oneway.value);
    !oneway && wire.services.len() < 2
}

fn dangling(
    part: &CheckedComponent<'_>,
    reference: &EndpointService,
    joined: &Joined<'_>,
    report: &mut Report,
) {
    let component = part.component.name.value.clone();
    let key = (component, reference.name.text.clone());
    if reference.optional || joined.places.contains_key(&key) || joined.meant.contains(&key) {
        return;
    }
    report.found(DanglingReference {
        component: key.0,
        reference: key.1,
        interface: reference.interface.text.clone(),
        at: own_place(part, reference.name.at),
    });
}

/// Returns the location of a member of a component: its declaration if it is in the same file, otherwise the name of
/// the component. Members of a nested composite are declared in another file, which may be correct on its own.
pub(crate) fn own_place(part: &CheckedComponent<'_>, at: Option<Span>) -> Span {
    let name = part.component.name.span;
    at.filter(|at| at.file == name.file).unwrap_or(name)
}
