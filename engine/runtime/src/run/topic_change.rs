//! Outputs and inputs of a running system that begin or end to publish on topics and to subscribe to them.

use asmotion_component::HEALTH_TOPIC;
use asmotion_port::Policy;

use super::change::{ChangeError, ChangePlan, DetachStep, UndoStep};
use super::executor::{Act, Executor};
use crate::build_error::BuildError;
use crate::component_end::ComponentEnd;
use crate::injection::InjectionPort;
use crate::topic::SystemTopic;

impl<E: Executor> ChangePlan<'_, E> {
    /// The topics of the system.
    pub(super) fn topics(&mut self) -> &mut [SystemTopic] {
        let (connections, _) = self.run.connections();
        &mut connections.topics
    }

    /// Remembers the topics before a change.
    pub(super) fn save_topics(&mut self) {
        let topics = self.topics().to_vec();
        self.undo_steps.push(UndoStep::Topics(topics));
    }

    /// Position of a topic, which is created if need be.
    fn topic(&mut self, topic: &str) -> usize {
        self.save_topics();
        let (connections, _) = self.run.connections();
        connections.topic_index(topic)
    }

    /// Plans that an output publishes on a topic.
    pub(super) fn publish(&mut self, from: ComponentEnd, topic: &str) -> Result<(), ChangeError> {
        if topic == HEALTH_TOPIC {
            return Err(BuildError::ReservedTopic {
                from: from.name,
                topic: HEALTH_TOPIC,
            }
            .into());
        }
        let mut topics = self.topics().iter();
        if let Some(taken) = topics.find(|it| it.publishers.contains(&from)) {
            let (end, to) = (from.name, format!("topic `{}`", taken.name));
            return Err(BuildError::AlreadyConnected { end, to }.into());
        }
        self.name_topic(&from, Some(topic));
        let index = self.topic(topic);
        let topics = self.topics();
        let subscribers = topics[index].subscribers.clone();
        topics[index].publishers.push(from.clone());
        for (to, policy) in subscribers {
            self.connect_by_topic(&from, &to, &policy)?;
        }
        Ok(())
    }

    /// Plans that an output no longer publishes on a topic.
    pub(super) fn unpublish(&mut self, from: &ComponentEnd, topic: &str) -> Result<(), BuildError> {
        let index = self.topic(topic);
        let publishers = &mut self.topics()[index].publishers;
        let Some(position) = publishers.iter().position(|it| it == from) else {
            return Err(not_connected(from, topic));
        };
        publishers.remove(position);
        self.name_topic(from, None);
        // an output publishes on one topic only
        let (connections, _) = self.run.connections();
        for connection in connections.remove_by_topic(|_, output, _| output == from) {
            self.end_connection(connection);
        }
        Ok(())
    }

    /// Plans the name of the topic with which the samples of an output are reported.
    fn name_topic(&mut self, output: &ComponentEnd, topic: Option<&str>) {
        let (index, topic) = (output.index, topic.map(str::to_owned));
        let act: Act = Box::new(move |unit, _, _| unit.body.topics[index] = topic);
        self.update_steps.push((output.unit, act));
    }

    /// Plans that an input subscribes to a topic.
    pub(super) fn subscribe(
        &mut self,
        topic: &str,
        to: ComponentEnd,
        policy: &Policy,
    ) -> Result<(), ChangeError> {
        if topic == HEALTH_TOPIC {
            return Err(self.health_topic(to));
        }
        let index = self.topic(topic);
        let topics = self.topics();
        if topics[index]
            .subscribers
            .iter()
            .any(|(known, _)| *known == to)
        {
            let (end, to) = (to.name, format!("topic `{topic}`"));
            return Err(BuildError::AlreadyConnected { end, to }.into());
        }
        let publishers = topics[index].publishers.clone();
        topics[index].subscribers.push((to.clone(), policy.clone()));
        for from in publishers {
            self.connect_by_topic(&from, &to, policy)?;
        }
        self.inject_by_topic(topic, &to, policy);
        Ok(())
    }

    /// The error about an input that would read the state of the bus.
    fn health_topic(&mut self, to: ComponentEnd) -> ChangeError {
        if self.staged(to.unit).is_none() {
            return ChangeError::Joining {
                end: to.name,
                outside: format!("topic {HEALTH_TOPIC}"),
                reason: "that needs a new start".to_owned(),
            };
        }
        let component = self.run.descriptors()[to.unit].name.to_string();
        let reason = format!(
            "`{}` reads `{HEALTH_TOPIC}`, which needs a new start",
            to.name
        );
        ChangeError::Addition { component, reason }
    }

    /// Opens a connection from outside into an input that subscribes to a topic.
    fn inject_by_topic(&mut self, topic: &str, to: &ComponentEnd, policy: &Policy) {
        let (connections, _) = self.run.connections();
        let connection = connections.next_id();
        if let Some(staged) = self.staged(to.unit) {
            let port = InjectionPort::open(&mut staged.unit, to.index, policy, connection);
            let port = port.map(|port| (topic.to_owned(), port));
            staged.topic_injections.extend(port);
            return;
        }
        // a policy whose zeros the type does not have is refused for the first publisher, too
        let Ok((port, reading_end)) = self.injection(to, policy) else {
            return;
        };
        let index = to.index;
        let act: Act = Box::new(move |unit, _, _| unit.body.inputs[index].connect(reading_end));
        self.attach_steps.push((to.unit, act));
        self.topic_injections.push((topic.to_owned(), port));
    }

    /// Plans the end of a subscription.
    pub(super) fn unsubscribe(&mut self, to: &ComponentEnd, topic: &str) -> Result<(), BuildError> {
        let index = self.topic(topic);
        let topic_before = self.topics()[index].clone();
        let subscribers = &mut self.topics()[index].subscribers;
        let Some(position) = subscribers.iter().position(|(it, _)| it == to) else {
            return Err(not_connected(to, topic));
        };
        subscribers.remove(position);
        let (connections, _) = self.run.connections();
        let removed = connections.remove_by_topic(|_, output, input| {
            input == to && topic_before.publishers.contains(output)
        });
        for connection in removed {
            self.end_connection(connection);
        }
        for connection in self.run.injections().by_topic(topic, &to.name) {
            let index = to.index;
            self.detach_steps.push(DetachStep {
                reader: to.unit,
                writer: None,
                act: Box::new(move |unit, _, _| unit.body.inputs[index].disconnect(connection)),
            });
        }
        self.unsubscribed.push((topic.to_owned(), to.name.clone()));
        Ok(())
    }

    /// Lets samples from outside reach the new inputs and subscriptions of running components, and no ended ones.
    pub(super) fn follow_injections(&mut self) {
        let (ports, topics) = (
            std::mem::take(&mut self.injections),
            std::mem::take(&mut self.topic_injections),
        );
        let injections = self.run.injections_mut();
        for (topic, input) in &self.unsubscribed {
            injections.close_topic(topic, input);
        }
        injections.add(ports, topics);
    }
}

fn not_connected(end: &ComponentEnd, topic: &str) -> BuildError {
    BuildError::NotConnected {
        from: end.name.clone(),
        to: format!("topic {topic}"),
    }
}
