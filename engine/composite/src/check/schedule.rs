//! Checks when components cycle and are reset, and in which thread they run.

use crate::codes::c035::MasterCycle;
use crate::codes::c048::IdleKey;

use asmotion_diagnostics::Report;

use super::scene::CheckedComposite;
use crate::finding::Findings;
use crate::model::{Component, OnException, Pace};

/// Checks the schedule of a component and its limit of resets.
pub(crate) fn check(scene: &CheckedComposite<'_>, component: &Component, report: &mut Report) {
    pace(scene, component, report);
    resets(component, report);
}

/// Iterates over the master of a component, the master of that master and so on; stops at the first repetition.
pub(crate) fn masters<'s>(
    scene: &CheckedComposite<'s>,
    name: &'s str,
) -> impl Iterator<Item = &'s str> {
    let master = |name: &&str| {
        let component = scene.composite.component(name)?;
        let master = component.pace()?.master.as_ref()?;
        Some(master.value.as_str())
    };
    let most = scene.composite.components.len();
    std::iter::successors(master(&name), master).take(most)
}

/// Checks the schedule of a component: the names it refers to, and keys without effect.
fn pace(scene: &CheckedComposite<'_>, component: &Component, report: &mut Report) {
    let Some(pace) = component.pace() else {
        return;
    };
    scene.broker(None, pace.broker.as_ref(), report);
    if let (Some(on_deadline), None) = (&pace.on_deadline, &pace.deadline_ms) {
        report.found(IdleKey {
            key: "on_deadline",
            at: on_deadline.span,
            reason: "no cycle is late without `deadline_ms`",
        });
    }
    if let Some(master) = &pace.master {
        slave(pace, report);
        if scene.composite.component(master).is_none() {
            scene.unknown_component(master, report);
        } else if masters(scene, &component.name.value).any(|one| one == component.name.value) {
            report.found(MasterCycle {
                component: component.name.value.clone(),
                at: master.span,
            });
        }
    }
}

/// Reports the schedule of a component that cycles after its master, in the thread of that.
fn slave(pace: &Pace, report: &mut Report) {
    let after = "the component cycles after its `master`, whenever that does";
    let within = "the component runs in the thread of its `master`";
    let keys = [
        (
            "period_ms",
            pace.period_ms.as_ref().map(|it| it.span),
            after,
        ),
        ("delay_ms", pace.delay_ms.as_ref().map(|it| it.span), after),
        ("overrun", pace.overrun.as_ref().map(|it| it.span), after),
        (
            "scheduler",
            pace.scheduler.as_ref().map(|it| it.span),
            within,
        ),
        ("priority", pace.priority.as_ref().map(|it| it.span), within),
        ("cpu", pace.cpu.first().map(|it| it.span), within),
    ];
    for (key, at, reason) in keys {
        if let Some(at) = at {
            report.found(IdleKey { key, at, reason });
        }
    }
}

/// Reports a limit of resets where there are none.
fn resets(component: &Component, report: &mut Report) {
    let Some(lifecycle) = &component.lifecycle else {
        return;
    };
    let on_exception = lifecycle.on_exception.as_ref();
    let resets = on_exception.is_some_and(|it| it.value == OnException::Reset);
    if let (Some(max_resets), false) = (&lifecycle.max_resets, resets) {
        report.found(IdleKey {
            key: "max_resets",
            at: max_resets.span,
            reason: "a component that fails is reset only with `on_exception = \"reset\"`",
        });
    }
}
