//! Checks wires to services of other systems, which are called over HTTP.

use asmotion_diagnostics::{Report, Span};

use crate::codes::c004::MissingKey;
use crate::codes::c010::ExclusiveKeys;
use crate::finding::Findings;
use crate::model::{Transport, Wire};

/// Returns whether the wire is called over HTTP.
pub(super) fn is_over_http(wire: &Wire) -> bool {
    let binding = wire.binding.as_ref();
    binding.is_some_and(|binding| binding.value == Transport::Http)
}

/// Checks that a wire names either services of the composite or, over HTTP, the URL of a service.
pub(super) fn check(wire: &Wire, report: &mut Report) {
    let url = wire.url.as_ref().map(|url| url.span);
    let Some(binding) = wire.binding.as_ref().filter(|_| is_over_http(wire)) else {
        let token = wire.token.as_ref().map(|token| token.span);
        for (key, at) in [("url", url), ("token", token)] {
            if let Some(at) = at {
                only_over_http(wire, key, at, report);
            }
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
            excluded(binding.span, key, at, reason, report);
        }
    }
}

/// Reports a key that only wires over HTTP have.
fn only_over_http(wire: &Wire, key: &str, at: Span, report: &mut Report) {
    match &wire.binding {
        Some(binding) => {
            let reason = "only a wire over HTTP has this key";
            excluded(binding.span, key, at, reason, report);
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

fn excluded(first_at: Span, key: &str, at: Span, reason: &'static str, report: &mut Report) {
    report.found(ExclusiveKeys {
        first: "binding".to_owned(),
        first_at,
        second: key.to_owned(),
        at,
        reason,
    });
}
