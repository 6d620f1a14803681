//! `asmotion ros list`: what a master of ROS 1 knows, or what is in a domain of ROS 2.

use asmotion_ros1::RosGraph;
use clap::Args;
use serde_json::json;

use super::domain::DomainArguments;
use super::generation::Generation;
use super::master::MasterArguments;
use crate::exit::Exit;
use crate::table;
use crate::terminal::TerminalOutput;

#[derive(Args)]
pub struct RosList {
    /// Generation of ROS
    #[arg(long, value_enum, default_value_t = Generation::One)]
    ros: Generation,

    #[command(flatten)]
    master: MasterArguments,

    #[command(flatten)]
    domain: DomainArguments,

    /// ROS 2: time in which nodes are discovered
    #[arg(long = "for", value_name = "SECONDS", default_value_t = 2)]
    limit: u64,

    /// ROS 2: also nodes, topics and services with a name that has a part with an underscore at its beginning, such as the
    /// topics of actions
    #[arg(long)]
    hidden: bool,

    /// Prints a JSON object
    #[arg(long)]
    json: bool,
}

impl RosList {
    /// Prints nodes, topics and services. A master that does not answer is a usage error.
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        if let Err(error) = self.domain.check(self.ros, &self.master, &[], self.hidden) {
            terminal.error(error);
            return Exit::Usage;
        }
        if self.ros == Generation::Two {
            let time = std::time::Duration::from_secs(self.limit);
            return super::ros2_list::run(&self.domain, time, (self.hidden, self.json), terminal);
        }
        let graph = match self.master.node() {
            Ok(node) => node.graph(),
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        let graph = match graph {
            Ok(graph) => graph,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        if self.json {
            terminal.result(as_json(&graph));
        } else {
            for line in as_tables(&graph) {
                terminal.result(line);
            }
        }
        Exit::Ok
    }
}

fn as_json(graph: &RosGraph) -> serde_json::Value {
    let topics = graph.topics.iter().map(|(name, topic)| {
        json!({
            "topic": name, "type": topic.type_name,
            "publishers": topic.publishers, "subscribers": topic.subscribers,
        })
    });
    let services = graph.services.iter();
    let services = services.map(|(name, nodes)| json!({ "service": name, "providers": nodes }));
    json!({
        "nodes": graph.nodes(),
        "topics": topics.collect::<Vec<_>>(),
        "services": services.collect::<Vec<_>>(),
    })
}

/// A table of topics and one of services, which contain every node.
fn as_tables(graph: &RosGraph) -> Vec<String> {
    let names = |names: &[String]| {
        if names.is_empty() {
            "-".to_owned()
        } else {
            names.join(" ")
        }
    };
    let topics = graph.topics.iter().map(|(name, topic)| {
        let type_name = match &*topic.type_name {
            "" => "-",
            name => name,
        };
        vec![
            name.clone(),
            type_name.to_owned(),
            names(&topic.publishers),
            names(&topic.subscribers),
        ]
    });
    let services = graph.services.iter();
    let services = services.map(|(name, nodes)| vec![name.clone(), names(nodes)]);
    let mut lines = table::lines(&["topic", "type", "from", "to"], topics);
    lines.push(String::new());
    lines.extend(table::lines(&["service", "node"], services));
    lines
}
