//! Keys of bindings that have no effect in combination.

use std::borrow::Cow;

use asmotion_coordinator::Receive;
use asmotion_diagnostics::Report;

use crate::codes::c048::IdleKey;
use crate::finding::Findings;
use crate::model::binding::{Monitored, Source};

/// Reports values and age limits of messages that the mode of their receipt does not use.
pub(super) fn check(monitored: &Monitored, report: &mut Report) {
    match &monitored.from {
        Source::Port(_) | Source::Request(_) => {}
        // reported where the file is read
        Source::Timer { .. } | Source::Losses(_) | Source::Value(_) => return,
    }
    let none = monitored.none.as_ref().map(|it| ("none", it.span));
    let stale = monitored.stale_ms.as_ref().map(|it| ("stale_ms", it.span));
    let (keys, reason) = match monitored.received().value {
        Receive::Last => return,
        Receive::Edge => (
            [none, stale],
            "an edge is true in the step in which a message arrives, and otherwise false",
        ),
        Receive::All => (
            [None, stale],
            "a step takes each message once, however old it is; `max_age_ms` of its connection limits its age",
        ),
    };
    for (key, at) in keys.into_iter().flatten() {
        report.found(IdleKey {
            key: Cow::Borrowed(key),
            at,
            reason,
        });
    }
}
