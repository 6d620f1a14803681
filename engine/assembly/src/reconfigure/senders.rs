//! Outputs whose samples leave a part of a system.

use std::collections::BTreeMap;

use asmotion_bus::PublishOptions;
use asmotion_network::port_topic;
use asmotion_plan::{End, Part, Plan, Terminal};
use asmotion_runtime::{Change, OuterEnd};

use super::difference::{Difference, outer_name};
use crate::start;

impl Difference<'_> {
    /// Compares what leaves the part: outputs read by other processes, and topics.
    pub(super) fn senders(&mut self, running: &Plan, wanted: &Plan) {
        let (before, after) = self.versions;
        let parts = (&before.part, &after.part);
        let (before, after) = (senders(running, parts.0), senders(wanted, parts.1));
        for (sender, options) in &before {
            if after.get(sender) != Some(options) && self.is_kept(&sender.output.component) {
                let parted = self.sender(running, sender, *options);
                self.ends.extend(parted.map(Change::Part));
            }
        }
        for (sender, options) in &after {
            let is_new = !self.is_kept(&sender.output.component);
            // the topics of a new component are part of it
            if before.get(sender) != Some(options) && (!is_new || sender.is_of_port) {
                let joined = self.sender(wanted, sender, *options);
                self.begins.extend(joined.map(Change::Join));
            }
        }
    }

    fn sender(&self, plan: &Plan, sender: &Sender, options: PublishOptions) -> Option<OuterEnd> {
        let output = &sender.output;
        let name = outer_name(plan, &output.component)?;
        let network = &self.versions.1.network;
        network.publish(name, &output.to_string(), &sender.topic, options)
    }
}

/// An output whose samples leave the part.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Sender {
    output: End,
    topic: String,
    /// The topic is that of the port, for ports of other processes.
    is_of_port: bool,
}

/// Returns the outputs of a part whose samples leave it, and how.
fn senders(plan: &Plan, part: &Part) -> BTreeMap<Sender, PublishOptions> {
    let mut senders = BTreeMap::new();
    for connection in &plan.connections {
        if let (Terminal::Port(from), Terminal::Port(to)) = (&connection.from, &connection.to)
            && part.has(&from.component)
            && !part.has(&to.component)
        {
            let sender = Sender {
                output: from.clone(),
                topic: port_topic(&from.to_string()),
                is_of_port: true,
            };
            senders.insert(sender, start::port_sending(plan, from));
        }
    }
    for (topic, options) in start::topic_sending(plan, part) {
        let known = plan.topics.iter().find(|it| it.name == topic);
        let publishers = known.map_or(&[][..], |it| &it.publishers);
        for output in publishers.iter().filter(|it| part.has(&it.component)) {
            let sender = Sender {
                output: output.clone(),
                topic: topic.to_owned(),
                is_of_port: false,
            };
            senders.insert(sender, options);
        }
    }
    senders
}
