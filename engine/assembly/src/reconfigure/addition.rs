//! Addition of a component: how it is created, and joined to topics and callers.

use asmotion_component::{Declaration, Interface};
use asmotion_plan::{Component, Implementation};
use asmotion_runtime::{Change, ComponentAddition};

use super::difference::{Difference, outer_name};
use super::fixed_part::FixedPart;
use super::services::doors;
use super::topics::{Subscription, TopicUse, topic_options};
use super::version::Version;
use crate::start;

impl Difference<'_> {
    pub(super) fn add(&mut self, component: &Component) {
        let wanted = self.versions.1;
        self.builtin(component, "new");
        if let Some(master) = &component.pace.master {
            self.fixed.push(FixedPart::Slave {
                component: component.name.clone(),
                master: master.clone(),
            });
        }
        let construct = wanted.constructor(component);
        let mut interface = Interface::new();
        // a component that cannot be created is refused by the run
        let declared = construct(&mut interface).map(|_| interface.declaration().clone());
        let declared = declared.unwrap_or_default();
        let activity = start::activity(component, &wanted.plan);
        let mut by = ComponentAddition::new(implementation(component), activity, construct);
        for (name, value) in &component.properties.0 {
            by = by.property(name, value.datum());
        }
        for (output, sample) in &component.lifecycle.safe {
            by = by.safe_sample(output, sample.datum());
        }
        by = on_topics(by, component, &declared, wanted);
        by = offered(by, component, &declared, wanted);
        self.declared.insert(component.name.clone(), declared);
        self.members.push(Change::Add {
            component: component.name.clone(),
            by,
        });
    }
}

/// Adds the topics of a component, as at its start.
fn on_topics(
    mut by: ComponentAddition,
    component: &Component,
    declared: &Declaration,
    version: &Version,
) -> ComponentAddition {
    let name = outer_name(&version.plan, &component.name);
    let TopicUse {
        published,
        subscribed,
    } = TopicUse::of(component, declared, &version.plan);
    for (output, topic) in &published {
        by = by.publish(output, topic);
        let options = topic_options(version, topic);
        let outer = name.and_then(|name| {
            let output = format!("{}.{output}", component.name);
            version.network.publish(name, &output, topic, options)
        });
        by = outer.into_iter().fold(by, ComponentAddition::joined);
    }
    for Subscription {
        topic,
        input,
        policy,
    } in subscribed
    {
        by = by.subscribe(&topic, &input, policy.clone());
        let outer = name.and_then(|name| {
            let input = format!("{}.{input}", component.name);
            version.network.subscribe(name, &topic, &input, policy)
        });
        by = outer.into_iter().fold(by, ComponentAddition::joined);
    }
    by
}

/// Offers the services of a component to other processes, as at its start.
fn offered(
    mut by: ComponentAddition,
    component: &Component,
    declared: &Declaration,
    version: &Version,
) -> ComponentAddition {
    let services = component.services.iter().map(|it| it.name.as_str());
    for service in services.filter(|it| declared.service(it).is_some()) {
        let end = format!("{}.{service}", component.name);
        let doors = doors(&version.plan, &version.part, &component.name, service);
        for (name, broker) in version.network.distinct(doors) {
            let outer = version.network.offer(&end, &name, broker.as_deref());
            by = outer.into_iter().fold(by, ComponentAddition::joined);
        }
    }
    by
}

/// Names the implementation of a component for the operator.
fn implementation(component: &Component) -> String {
    match &component.implementation {
        Implementation::Asm { file, .. } => {
            let (_, shown) = file.rsplit_once('/').unwrap_or(("", file));
            format!("`{shown}`")
        }
        Implementation::Rust(name) | Implementation::Builtin { name, .. } => format!("`{name}`"),
        Implementation::Process { command, .. } => format!("the program `{}`", command.join(" ")),
        Implementation::Ros { .. } => "a ROS node".to_owned(),
        Implementation::Orocos { .. } => "an Orocos component".to_owned(),
    }
}
