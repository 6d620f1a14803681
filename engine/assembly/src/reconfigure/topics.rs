//! Topics on which components publish, and to which they subscribe.

use asmotion_bus::PublishOptions;
use asmotion_component::{Declaration, Policy};
use asmotion_network::has_same_queue;
use asmotion_plan::{Component, Plan, Terminal};
use asmotion_runtime::{Change, OuterEnd};

use super::difference::{Difference, outer_name};
use super::fixed_part::FixedPart;
use super::version::Version;
use crate::start;

/// How a component uses topics.
#[derive(Default)]
pub(super) struct TopicUse {
    /// Outputs with their topics.
    pub published: Vec<(String, String)>,
    pub subscribed: Vec<Subscription>,
}

/// An input that subscribes to a topic.
#[derive(PartialEq)]
pub(super) struct Subscription {
    pub topic: String,
    pub input: String,
    pub policy: Policy,
}

impl TopicUse {
    /// Returns how a component with this declaration uses topics from its start on.
    pub(super) fn of(component: &Component, declared: &Declaration, plan: &Plan) -> Self {
        let mut found = Self::default();
        for port in &component.outputs {
            if let (Some(topic), Some(_)) = (&port.topic, declared.output(&port.name)) {
                found.published.push((port.name.clone(), topic.clone()));
            }
        }
        for port in &component.inputs {
            if let (Some(topic), Some(_)) = (&port.topic, declared.input(&port.name)) {
                found.subscribed.push(Subscription {
                    policy: start::subscription_policy(plan, component, &port.name, topic),
                    topic: topic.clone(),
                    input: port.name.clone(),
                });
            }
        }
        for connection in &plan.connections {
            match (&connection.from, &connection.to) {
                (Terminal::Port(from), Terminal::Topic(topic))
                    if from.component == component.name =>
                {
                    found.published.push((from.name.clone(), topic.clone()));
                }
                (Terminal::Topic(topic), Terminal::Port(to)) if to.component == component.name => {
                    found.subscribed.push(Subscription {
                        topic: topic.clone(),
                        input: to.name.clone(),
                        policy: start::policy(connection),
                    });
                }
                // the others are of other components, or connected as ports
                (Terminal::Port(_) | Terminal::Topic(_) | Terminal::Mqueue(_), _) => {}
            }
        }
        found
    }

    fn subscription(&self, topic: &str, input: &str) -> Option<&Subscription> {
        let mut subscribed = self.subscribed.iter();
        subscribed.find(|it| it.topic == topic && it.input == input)
    }
}

/// Returns how messages of a topic are sent over a bus.
pub(super) fn topic_options(version: &Version, topic: &str) -> PublishOptions {
    let mut options = start::topic_sending(&version.plan, &version.part);
    let options = options.find(|(known, _)| *known == topic);
    options.map(|(_, options)| options).unwrap_or_default()
}

impl Difference<'_> {
    /// Compares the topics of a component that is kept. What its outputs send over a bus is compared with all that leaves.
    pub(super) fn topics(&mut self, before: &Component, after: &Component) {
        let name = &after.name;
        let (running, wanted) = self.versions;
        let declared = self.run.declaration(name).unwrap_or_default();
        let had = TopicUse::of(before, &declared, &running.plan);
        let has = TopicUse::of(after, &self.declaration(name), &wanted.plan);
        for it in had
            .published
            .iter()
            .filter(|it| !has.published.contains(it))
        {
            let (output, topic) = (format!("{name}.{}", it.0), it.1.clone());
            self.ends.push(Change::Unpublish { output, topic });
        }
        for it in has
            .published
            .iter()
            .filter(|it| !had.published.contains(it))
        {
            let (output, topic) = (format!("{name}.{}", it.0), it.1.clone());
            self.begins.push(Change::Publish { output, topic });
        }
        for it in had
            .subscribed
            .iter()
            .filter(|it| !has.subscribed.contains(it))
        {
            let (input, topic) = (format!("{name}.{}", it.input), it.topic.clone());
            let parted = self.outer_subscription(running, name, it);
            let next = has.subscription(&it.topic, &it.input);
            let has_other_queue =
                next.is_some_and(|next| !has_same_queue(it.policy.kind, next.policy.kind));
            if parted.is_some() && has_other_queue {
                // the queue on the bus has a name that the new one would have, too
                let (from, to) = (Terminal::Topic(topic).to_string(), input);
                self.fixed.push(FixedPart::Policy { from, to });
                continue;
            }
            self.ends.extend(parted.map(Change::Part));
            self.ends.push(Change::Unsubscribe { input, topic });
        }
        for it in has
            .subscribed
            .iter()
            .filter(|it| !had.subscribed.contains(it))
        {
            self.begins.push(Change::Subscribe {
                input: format!("{name}.{}", it.input),
                topic: it.topic.clone(),
                policy: it.policy.clone(),
            });
            let joined = self.outer_subscription(wanted, name, it);
            self.begins.extend(joined.map(Change::Join));
        }
    }

    /// Returns how an input subscribes to a topic over a bus, if its component uses one.
    fn outer_subscription(
        &self,
        version: &Version,
        component: &str,
        subscription: &Subscription,
    ) -> Option<OuterEnd> {
        let Subscription {
            topic,
            input,
            policy,
        } = subscription;
        let name = outer_name(&version.plan, component)?;
        let network = &self.versions.1.network;
        network.subscribe(name, topic, &format!("{component}.{input}"), policy.clone())
    }
}
