//! Brokers among which nothing chooses.

use asmotion_diagnostics::Report;

use super::scene::CheckedComposite;
use crate::codes::c048::IdleKey;
use crate::finding::Findings;

/// Reports several brokers of which nothing names one: a run does not choose among them.
pub(super) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    let composite = scene.composite;
    let is_root = scene.path == scene.family.root;
    let [_, second, ..] = composite.brokers.as_slice() else {
        return;
    };
    let of_components = composite
        .components
        .iter()
        .filter_map(|it| it.pace()?.broker.as_ref());
    let of_wires = composite.wires.iter().filter_map(|it| it.broker.as_ref());
    let of_promotions = composite
        .promotions
        .iter()
        .filter_map(|it| it.broker.as_ref());
    let mut named = of_components.chain(of_wires).chain(of_promotions);
    if is_root && named.next().is_none() {
        report.found(IdleKey {
            key: "brokers".into(),
            at: second.name.span,
            reason: "one of several brokers, and `run` refuses to choose: name one in `task.broker` of components, or with `--bus`",
        });
    }
}
