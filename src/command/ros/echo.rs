//! `asmotion ros echo`: prints the messages of a topic.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{Envelope, Notifier, Overflow, QueuePolicy};
use asmotion_datum::Datum;
use clap::Args;
use serde_json::json;

use super::domain::DomainArguments;
use super::generation::Generation;
use super::master::MasterArguments;
use super::printed::Printed;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;

/// Messages that can wait to be printed.
const QUEUE: usize = 1000;

#[derive(Args)]
pub struct RosEcho {
    /// Name of the topic, `/odom`; its type is that of its publisher
    topic: String,

    /// Generation of ROS
    #[arg(long, value_enum, default_value_t = Generation::One)]
    ros: Generation,

    #[command(flatten)]
    master: MasterArguments,

    #[command(flatten)]
    domain: DomainArguments,

    /// ROS 2: folder with further definitions of messages, such as /opt/ros/jazzy/share; may be repeated. Those of ROS 1 come from the
    /// publisher
    #[arg(long, value_name = "DIR")]
    definitions: Vec<PathBuf>,

    #[command(flatten)]
    printed: Printed,
}

impl RosEcho {
    /// Prints each message on a line. Receiving none is a finding; a master that does not answer is a usage error.
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        let folders = &self.definitions;
        if let Err(error) = self.domain.check(self.ros, &self.master, folders, false) {
            terminal.error(error);
            return Exit::Usage;
        }
        if self.ros == Generation::Two {
            let of = (&*self.topic, &self.domain, &**folders);
            return super::ros2_echo::run(of, &self.printed, terminal);
        }
        self.of_master(terminal)
    }

    /// Prints the messages of a topic of ROS 1.
    fn of_master(self, terminal: &mut TerminalOutput) -> Exit {
        let node = match self.master.node() {
            Ok(node) => node,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        let graph = match node.graph() {
            Ok(graph) => graph,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        let queue = QueuePolicy::All {
            size: QUEUE,
            overflow: Overflow::DropOldest,
        };
        let subscribed = node.subscribe(&self.topic, None, queue, Arc::new(Notifier::new()));
        let subscription = match subscribed {
            Ok(subscription) => subscription,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        let name = self.topic.trim_start_matches('/');
        let known = graph.topics.iter();
        let mut known = known.filter(|(_, topic)| !topic.publishers.is_empty());
        if !known.any(|(topic, _)| topic.trim_start_matches('/') == name) {
            let limit = self.printed.limit;
            terminal.warn(format_args!(
                "no node publishes `/{name}`; waiting for {limit} s (`asmotion ros list` shows the topics)"
            ));
        }
        let until = Instant::now() + Duration::from_secs(self.printed.limit);
        let mut count = 0;
        while self.printed.count.is_none_or(|max| count < max) {
            let remaining = until.saturating_duration_since(Instant::now());
            let Some(envelope) = subscription.next_within(remaining) else {
                break;
            };
            count += 1;
            terminal.result(line(&envelope, self.printed.json));
        }
        if subscription.dropped() > 0 {
            let dropped = subscription.dropped();
            terminal.warn(format_args!(
                "{dropped} messages were not printed: there were too many"
            ));
        }
        if count > 0 {
            return Exit::Ok;
        }
        terminal.warn(format_args!(
            "no message on `/{name}` within {} s",
            self.printed.limit
        ));
        Exit::Findings
    }
}

fn line(envelope: &Envelope, is_json: bool) -> String {
    let content = envelope.payload.to_datum().unwrap_or(Datum::Null);
    if !is_json {
        return format!("{} {content}", envelope.source);
    }
    let content = asmotion_datum::json::encode(&content);
    let content = content.unwrap_or_else(|error| json!(error.to_string()).to_string());
    let about = json!({
        "topic": &*envelope.topic, "source": &*envelope.source, "sequence": envelope.sequence,
        "stamp": envelope.stamp, "type": &*envelope.type_name,
    });
    let about = about.to_string();
    let about = about.trim_end_matches('}');
    format!("{about},\"content\":{content}}}")
}
