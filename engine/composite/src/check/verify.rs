//! Keys of `verify` that have no effect.

use std::borrow::Cow;

use asmotion_diagnostics::Report;

use crate::codes::c048::IdleKey;
use crate::finding::Findings;
use crate::model::Verify;

/// Reports limits without a verification, and kinds that are excluded although all are verified.
///
/// `refuse_start_on_failure` alone demands that all properties hold.
pub(super) fn idle_keys(verify: &Verify, report: &mut Report) {
    let kinds = [
        ("ctl", &verify.ctl),
        ("ltl", &verify.ltl),
        ("invariants", &verify.invariants),
    ];
    if kinds
        .iter()
        .any(|(_, kind)| kind.as_ref().is_some_and(|it| it.value))
    {
        return;
    }
    let mut idle = |key, at, reason| {
        report.found(IdleKey {
            key: Cow::Borrowed(key),
            at,
            reason,
        });
    };
    let refuse = verify.refuse_start_on_failure.as_ref();
    if refuse.is_some_and(|it| it.value) {
        for (key, kind) in kinds {
            if let Some(kind) = kind {
                let reason = "properties of all kinds are verified, because no kind is `true` and the start is to be refused";
                idle(key, kind.span, reason);
            }
        }
        return;
    }
    let reason = "nothing is verified: write `ctl = true`, `ltl = true`, `invariants = true` or, for all of them, \
                  `refuse_start_on_failure = true`";
    let bounds = [("bound", &verify.bound), ("states", &verify.states)];
    for (key, limit) in bounds {
        if let Some(limit) = limit {
            idle(key, limit.span, reason);
        }
    }
    if let Some(time) = &verify.time_s {
        idle("time_s", time.span, reason);
    }
}
