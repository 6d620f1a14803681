//! Schedules of components, combining their own settings with those of their process.

use std::time::Duration;

use asmotion_component::{Activity, ThreadUse};

use asmotion_composite::model;
use asmotion_plan::{Plan, Process};

/// Returns the activity of a component.
pub(crate) fn of(component: &asmotion_plan::Component, plan: &Plan) -> Activity {
    let pace = &component.pace;
    let process = plan.process_of(&component.name);
    let period_ms = match pace.period_ms {
        0 => polls(component, plan).unwrap_or(0),
        period_ms => period_ms,
    };
    let activity = Activity::periodic(Duration::from_millis(period_ms))
        .delay(Duration::from_millis(pace.delay_ms))
        .configure_on_startup(component.lifecycle.autoconf)
        .run_on_startup(pace.run_on_startup && component.lifecycle.autostart)
        .may_interrupt(pace.may_interrupt_if_running)
        .overrun(pace.overrun)
        .on_exception(component.lifecycle.on_exception)
        .max_resets(u32::try_from(component.lifecycle.max_resets).ok())
        .scheduler(plan.scheduler_of(component))
        .priority(priority(pace, process))
        .cpus(processors(plan.processors_of(component)))
        .thread(thread(component, plan));
    match pace.deadline_ms {
        Some(ms) => activity.deadline(Duration::from_millis(ms), pace.on_deadline),
        None => activity,
    }
}

/// Returns the shortest polling interval of the connections to an event-driven component, in milliseconds.
fn polls(component: &asmotion_plan::Component, plan: &Plan) -> Option<u64> {
    let connections = plan.connections.to_component(&component.name);
    let connections = connections.filter(|it| it.policy.delivery == model::Delivery::Poll);
    connections
        .filter_map(|connection| connection.policy.poll_ms)
        .min()
}

/// Default priority: the lowest of a real-time class.
const LOWEST_PRIORITY: u8 = 1;

/// Returns the thread of a component. A slave follows its master, and can bring a deadline into the thread.
fn thread(component: &asmotion_plan::Component, plan: &Plan) -> Option<ThreadUse> {
    match &component.pace.master {
        Some(_) => plan.last_master(component).pace.thread,
        None if plan.own_thread(component).is_some() => Some(ThreadUse::Own),
        None => component.pace.thread,
    }
}

/// Returns the scheduling priority of the component or, by default, of its process.
fn priority(pace: &asmotion_plan::Pace, process: Option<&Process>) -> u8 {
    let priority = pace.priority.or(process.and_then(|it| it.priority));
    let priority = priority.and_then(|given| u8::try_from(given).ok());
    priority.unwrap_or(LOWEST_PRIORITY)
}

fn processors(cpus: &[u64]) -> Vec<usize> {
    let cpus = cpus.iter();
    cpus.filter_map(|cpu| usize::try_from(*cpu).ok()).collect()
}
