//! Checks brokers: that something chooses among several, and that their keys agree.

use asmotion_diagnostics::Report;

use super::scene::CheckedComposite;
use crate::codes::c010::ExclusiveKeys;
use crate::codes::c048::IdleKey;
use crate::finding::Findings;
use crate::model::{Broker, Piece, Tls};

/// Reports several brokers of which nothing names one, because a run does not choose among them, and contradictory keys of
/// brokers.
pub(super) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    let composite = scene.composite;
    for broker in &composite.brokers {
        encryption(broker, report);
    }
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

/// Reports `tls = "off"` beside a URL that requires TLS.
fn encryption(broker: &Broker, report: &mut Report) {
    let begin = match broker.url.pieces.first() {
        Some(Piece::Text(text)) => text,
        Some(Piece::Variable {
            default: Some(text),
            ..
        }) => text,
        Some(Piece::Variable { default: None, .. } | Piece::Property { .. }) | None => return,
    };
    if let Some(tls) = broker.tls.as_ref().filter(|it| it.value == Tls::Off)
        && begin.starts_with("amqps://")
    {
        report.found(ExclusiveKeys {
            first: "amqps://".to_owned(),
            first_at: broker.url.span,
            second: "tls = \"off\"".to_owned(),
            at: tls.span,
            reason: "never encrypts, but the URL requires it: write `amqp://`, or remove this key",
        });
    }
}
