//! Checks when components cycle and are reset, and in which thread they run.

use std::borrow::Cow;

use crate::codes::c035::MasterCycle;
use crate::codes::c048::IdleKey;

use asmotion_diagnostics::Report;

use super::scene::CheckedComposite;
use crate::finding::Findings;
use crate::model::{Component, Implementation, OnException, Pace, Process, Scheduler, ThreadUse};

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
        let component = scene.member.component(name)?;
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
            key: Cow::Borrowed("on_deadline"),
            at: on_deadline.span,
            reason: "no cycle is late without `deadline_ms`",
        });
    }
    if let (Some(overrun), false) = (&pace.overrun, CheckedComposite::has_pace(component)) {
        report.found(IdleKey {
            key: Cow::Borrowed("overrun"),
            at: overrun.span,
            reason: "a component without a period cycles when messages arrive, and misses no cycle",
        });
    }
    if pace.master.is_none() {
        priority(scene, component, pace, report);
        thread(scene, component, pace, report);
    }
    if let Some(master) = &pace.master {
        slave(pace, report);
        if scene.member.component(master).is_none() {
            scene.unknown_component(master, report);
        } else if masters(scene, &component.name.value).any(|one| one == component.name.value) {
            report.found(MasterCycle {
                component: component.name.value.clone(),
                at: master.span,
            });
        }
    }
}

/// Reason why a priority has no effect.
pub(super) const NO_PRIORITIES: &str =
    "only threads with `scheduler = \"fifo\"` or `\"rr\"` have a priority";

/// Returns whether threads of a scheduling class have priorities.
pub(super) fn has_priorities(class: Scheduler) -> bool {
    match class {
        Scheduler::Other => false,
        Scheduler::Fifo | Scheduler::RoundRobin => true,
    }
}

/// Reports a priority in a class without priorities. A component of a nested composite can have the class of a process in
/// another file.
fn priority(scene: &CheckedComposite<'_>, component: &Component, pace: &Pace, report: &mut Report) {
    let Some(priority) = &pace.priority else {
        return;
    };
    let of_process = process(scene, component).and_then(|it| it.scheduler.as_ref());
    let class = pace.scheduler.as_ref().or(of_process);
    let is_known = class.is_some() || scene.path == scene.family.root;
    if is_known && !class.is_some_and(|it| has_priorities(it.value)) {
        report.found(IdleKey {
            key: Cow::Borrowed("priority"),
            at: priority.span,
            reason: NO_PRIORITIES,
        });
    }
}

/// The process of a component in this composite.
fn process<'s>(scene: &CheckedComposite<'s>, component: &Component) -> Option<&'s Process> {
    let name = &component.name.value;
    let deploy = scene.composite.deploy.as_ref();
    let mut processes = deploy.into_iter().flat_map(|it| &it.processes);
    processes.find(|it| it.components.iter().any(|it| it.value == *name))
}

/// Reports a component that asks to share the executor threads, but cannot.
fn thread(scene: &CheckedComposite<'_>, component: &Component, pace: &Pace, report: &mut Report) {
    let Some(thread) = pace
        .thread
        .as_ref()
        .filter(|it| it.value == ThreadUse::Shared)
    else {
        return;
    };
    let process = process(scene, component);
    let class = pace.scheduler.as_ref();
    let class = class.or(process.and_then(|it| it.scheduler.as_ref()));
    let has_class = class.is_some_and(|it| has_priorities(it.value));
    let has_processors = !pace.cpu.is_empty() || process.is_some_and(|it| !it.cpu.is_empty());
    let implementation = component.implementation.as_ref();
    let reason = if implementation.is_some_and(Implementation::waits_outside) {
        "a component that waits for another program or for the network has a thread of its own"
    } else if has_class {
        "only a thread of its own has a scheduling class"
    } else if has_processors {
        "only a thread of its own can be held to processors"
    } else {
        return;
    };
    report.found(IdleKey {
        key: Cow::Borrowed("thread"),
        at: thread.span,
        reason,
    });
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
        ("thread", pace.thread.as_ref().map(|it| it.span), within),
    ];
    for (key, at, reason) in keys {
        if let Some(at) = at {
            report.found(IdleKey {
                key: Cow::Borrowed(key),
                at,
                reason,
            });
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
            key: Cow::Borrowed("max_resets"),
            at: max_resets.span,
            reason: "a component that fails is reset only with `on_exception = \"reset\"`",
        });
    }
}
