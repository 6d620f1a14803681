//! Changes of a running system to another plan.
//!
//! Two versions are compared by subject: components, topics, connections, what leaves the process, services, wires. Each
//! difference becomes a [`Change`] of the run, or is a [`FixedPart`].

mod addition;
mod component_difference;
mod components;
mod connections;
mod difference;
mod fixed_part;
mod senders;
mod services;
mod topics;
mod version;
mod wires;

use std::collections::BTreeSet;

use asmotion_plan::{Plan, Process, Promoted};
use asmotion_runtime::{Change, Run};

use difference::Difference;
pub use fixed_part::FixedPart;
pub use version::{Clients, Version};

/// Returns the changes that turn a running system into another version: removed connections and wires, removed and added
/// components, then everything else.
///
/// # Errors
///
/// All differences that require a restart.
pub fn changes(
    running: &Version,
    wanted: &Version,
    run: &dyn Run,
) -> Result<Vec<Change>, Vec<FixedPart>> {
    let mut difference = Difference::new((running, wanted), run);
    let (running, wanted) = (&running.plan, &wanted.plan);
    difference.fixed = tables(running, wanted);
    difference.fixed.extend(definitions(running, wanted));
    difference.components(running, wanted);
    difference.connections(&running.connections, &wanted.connections);
    difference.senders(running, wanted);
    difference.offers(running, wanted);
    difference.wires(running, wanted);
    if difference.fixed.is_empty() {
        Ok([difference.ends, difference.members, difference.begins].concat())
    } else {
        Err(difference.fixed)
    }
}

/// Returns the tables that differ but cannot be changed at run time.
fn tables(running: &Plan, wanted: &Plan) -> Vec<FixedPart> {
    let names = |plan: &Plan| -> BTreeSet<String> {
        let names = plan.components.iter().map(|it| it.name.clone());
        names.collect()
    };
    let kept: BTreeSet<String> = &names(running) & &names(wanted);
    let placed = |plan: &Plan| (processes(plan, &kept), plan.restart.clone());
    let same = [
        ("the name", running.name == wanted.name),
        ("the profile", running.profile == wanted.profile),
        ("`brokers`", running.brokers == wanted.brokers),
        ("`bridges`", running.bridges == wanted.bridges),
        ("`gateways`", running.gateways == wanted.gateways),
        ("`promote`", promoted(running) == promoted(wanted)),
        ("`deploy`", placed(running) == placed(wanted)),
    ];
    let differs = same.into_iter().filter(|(_, same)| !same);
    differs.map(|(table, _)| FixedPart::Table(table)).collect()
}

/// Returns the message types and service interfaces that both plans know by different definitions: those of folders, which can change
/// while the system runs.
fn definitions(running: &Plan, wanted: &Plan) -> Vec<FixedPart> {
    let types = running.types.iter();
    let types = types.filter(|(name, schema)| {
        let other = wanted.types.get(*name);
        other.is_some_and(|other| other != *schema)
    });
    let interfaces = running.interfaces.iter();
    let interfaces = interfaces.filter(|(name, operations)| {
        let other = wanted.interfaces.get(*name);
        other.is_some_and(|other| other != *operations)
    });
    let names = types.map(|it| it.0).chain(interfaces.map(|it| it.0));
    names.cloned().map(FixedPart::Definition).collect()
}

/// The processes of a plan with those of their components that are kept.
fn processes(plan: &Plan, kept: &BTreeSet<String>) -> Vec<Process> {
    let mut processes = plan.processes.clone();
    for process in &mut processes {
        process.components.retain(|name| kept.contains(name));
    }
    processes
}

/// The promotions of a plan other than those of topics, which are open to everyone anyway.
fn promoted(plan: &Plan) -> Vec<&Promoted> {
    let promoted = plan.promoted.iter();
    promoted.filter(|it| it.what != "topic").collect()
}
