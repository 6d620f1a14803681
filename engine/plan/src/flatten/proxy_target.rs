//! Resolves the target of a port-proxy that is a nested composite.

use std::collections::BTreeSet;

use crate::plan::{Plan, Terminal};

/// Replaces each target that is no component by the components inside it to which the proxy is connected.
pub(super) fn resolve(plan: &mut Plan) {
    let names: BTreeSet<&String> = plan.components.iter().map(|it| &it.name).collect();
    let mut resolved = Vec::new();
    for (index, component) in plan.components.iter().enumerate() {
        let Some(bridge) = &component.bridge else {
            continue;
        };
        let targets = bridge.targets.iter();
        let targets = targets.flat_map(|target| {
            if names.contains(target) {
                vec![target.clone()]
            } else {
                connected(plan, &component.name, &format!("{target}/"))
            }
        });
        resolved.push((index, targets.collect::<Vec<String>>()));
    }
    for (index, targets) in resolved {
        let component = plan.components.at_mut(index);
        if let Some(bridge) = component.and_then(|it| it.bridge.as_mut()) {
            bridge.targets = targets;
        }
    }
}

/// Returns the components with this prefix at the other ends of a proxy's connections.
fn connected(plan: &Plan, proxy: &str, prefix: &str) -> Vec<String> {
    let mut found = Vec::new();
    for connection in &plan.connections {
        let (Terminal::Port(from), Terminal::Port(to)) = (&connection.from, &connection.to) else {
            continue;
        };
        let other = if from.component == proxy {
            &to.component
        } else if to.component == proxy {
            &from.component
        } else {
            continue;
        };
        if other.starts_with(prefix) && !found.contains(other) {
            found.push(other.clone());
        }
    }
    found
}
