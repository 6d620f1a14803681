//! Assigns components to processes.

use std::collections::{BTreeMap, BTreeSet};

use crate::plan::{Plan, Process};
use asmotion_composite::model::{Composite, Scheduler};
use asmotion_composite::table::Resolver;

/// Resolves processes, restarts and recording. `nested` maps nested composites to their prefix; all components of a
/// nested composite belong to its process.
pub(super) fn place(
    composite: &Composite,
    nested: &BTreeMap<&str, String>,
    to: &mut Resolver<'_>,
    plan: &mut Plan,
) {
    let Some(deploy) = &composite.deploy else {
        plan.processes = vec![Process {
            name: composite.name().value,
            host: None,
            components: plan.components.iter().map(|it| it.name.clone()).collect(),
            scheduler: Scheduler::default(),
            priority: None,
            cpu: Vec::new(),
        }];
        return;
    };
    for process in &deploy.processes {
        let Some(mut process) = to.of(process) else {
            continue;
        };
        process.components = placed(&process.components, nested, plan);
        for component in &process.components {
            let position = plan.process_positions.entry(component.clone());
            position.or_insert(plan.processes.len());
        }
        plan.processes.push(process);
    }
    plan.restart = deploy.restart.as_ref().and_then(|it| to.of(it));
    plan.record = deploy.record.as_ref().and_then(|it| to.of(it));
    if let Some(record) = &mut plan.record
        && record.topics.is_empty()
    {
        record.topics.push("*".to_owned());
    }
}

/// Returns the components of a plan selected by these names.
fn placed(names: &[String], nested: &BTreeMap<&str, String>, plan: &Plan) -> Vec<String> {
    let (mut single, mut prefixes) = (BTreeSet::new(), Vec::new());
    for name in names {
        match nested.get(name.as_str()) {
            Some(prefix) => prefixes.push(prefix),
            None => {
                single.insert(name.as_str());
            }
        }
    }
    let is_placed = |component: &str| {
        single.contains(component) || prefixes.iter().any(|it| component.starts_with(*it))
    };
    let components = plan.components.iter().map(|it| it.name.clone());
    components
        .filter(|component| is_placed(component))
        .collect()
}
