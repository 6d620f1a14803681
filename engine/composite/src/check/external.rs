//! Checks wires to services of other systems, which are called over HTTP, and of other robots, which are called over a
//! broker.

use asmotion_diagnostics::{Report, Span};

use crate::at::At;
use crate::codes::c004::MissingKey;
use crate::codes::c010::ExclusiveKeys;
use crate::finding::Findings;
use crate::model::{Piece, Template, Transport, Wire};

/// Returns whether the wire is called over HTTP.
pub(super) fn is_over_http(wire: &Wire) -> bool {
    let binding = wire.binding.as_ref();
    binding.is_some_and(|binding| binding.value == Transport::Http)
}

/// Checks that a wire names either services of the composite or the URL of a service outside.
pub(super) fn check(wire: &Wire, report: &mut Report) {
    let url = wire.url.as_ref().map(|url| url.span);
    let Some(binding) = wire.binding.as_ref().filter(|_| is_over_http(wire)) else {
        if let Some(token) = &wire.token {
            only_over_http(wire, "token", token.span, report);
        }
        if let Some(ca) = &wire.ca {
            only_over_http(wire, "ca", ca.span, report);
        }
        if let Some(url) = &wire.url {
            over_a_broker(wire, url, report);
        }
        if url.is_none() && wire.services.is_empty() && wire.interface.is_none() {
            missing(
                "service",
                "a wire",
                wire.span,
                "\"Planner.planning\"",
                report,
            );
        }
        return;
    };
    if url.is_none() {
        let example = "\"http://127.0.0.1:8080/services/maps\"";
        return missing("url", "a wire over HTTP", binding.span, example, report);
    }
    let service = wire.services.first().map(crate::model::End::span);
    let broker = wire.broker.as_ref().map(|broker| broker.span);
    let reason = "a wire over HTTP leads to its `url`";
    for (key, at) in [("service", service), ("broker", broker)] {
        if let Some(at) = at {
            excluded(("binding", binding.span), key, at, reason, report);
        }
    }
}

/// Checks the URL of a wire that is not called over HTTP, which is that of another robot's service.
fn over_a_broker(wire: &Wire, url: &At<Template>, report: &mut Report) {
    let binding = wire.binding.as_ref().map(|binding| binding.value);
    match (binding, wire.services.first()) {
        (Some(Transport::Amqp), None) => {}
        (Some(Transport::Amqp), Some(service)) => {
            let reason = "a wire leads to a service of its composite or to a `url`";
            let service = ("service", service.span());
            excluded(service, "url", url.span, reason, report);
        }
        (None, _) if names_a_robot(&url.value) => {
            let of = "a wire to another robot";
            missing("binding", of, url.span, "\"amqp\"", report);
        }
        (None | Some(Transport::Local | Transport::Ros | Transport::Http), _) => {
            only_over_http(wire, "url", url.span, report);
        }
    }
}

fn names_a_robot(url: &Template) -> bool {
    let first = url.pieces.first();
    matches!(first, Some(Piece::Text(text)) if text.starts_with("robot://"))
}

/// Reports a key that only wires over HTTP have.
fn only_over_http(wire: &Wire, key: &str, at: Span, report: &mut Report) {
    match &wire.binding {
        Some(binding) => {
            let reason = "only a wire over HTTP has this key";
            excluded(("binding", binding.span), key, at, reason, report);
        }
        None => missing("binding", "a wire over HTTP", at, "\"http\"", report),
    }
}

fn missing(key: &'static str, of: &'static str, at: Span, example: &str, report: &mut Report) {
    report.found(MissingKey {
        key,
        of,
        at,
        example: example.to_owned(),
    });
}

fn excluded(
    (first, first_at): (&str, Span),
    key: &str,
    at: Span,
    reason: &'static str,
    report: &mut Report,
) {
    report.found(ExclusiveKeys {
        first: first.to_owned(),
        first_at,
        second: key.to_owned(),
        at,
        reason,
    });
}
