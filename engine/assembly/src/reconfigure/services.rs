//! Names under which services are offered to other processes.

use std::collections::BTreeSet;

use asmotion_plan::{Part, Plan};
use asmotion_runtime::Change;

use super::difference::Difference;

impl Difference<'_> {
    /// Compares the names under which the services of kept components are offered to other processes.
    pub(super) fn offers(&mut self, running: &Plan, wanted: &Plan) {
        let (before, after) = self.versions;
        let network = &after.network;
        for component in &wanted.components {
            if !after.part.has(&component.name) || !self.is_kept(&component.name) {
                continue;
            }
            let declared = self.run.declaration(&component.name).unwrap_or_default();
            let services = component.services.iter().map(|it| it.name.as_str());
            for service in services.filter(|it| declared.service(it).is_some()) {
                let doors =
                    |plan, part| network.distinct(doors(plan, part, &component.name, service));
                let (before, after) = (doors(running, &before.part), doors(wanted, &after.part));
                let end = format!("{}.{service}", component.name);
                for (name, broker) in before.difference(&after) {
                    let parted = network.offer(&end, name, broker.as_deref());
                    self.ends.extend(parted.map(Change::Part));
                }
                for (name, broker) in after.difference(&before) {
                    let joined = network.offer(&end, name, broker.as_deref());
                    self.begins.extend(joined.map(Change::Join));
                }
            }
        }
    }
}

/// The names under which a service is offered to other processes, with their brokers.
pub(super) fn doors(
    plan: &Plan,
    part: &Part,
    component: &str,
    service: &str,
) -> BTreeSet<(String, Option<String>)> {
    if part.is_alone() {
        return BTreeSet::new();
    }
    let doors = plan.doors(component, service, part).into_iter();
    let doors = doors.map(|(name, broker)| (name, broker.map(str::to_owned)));
    doors.collect()
}
