//! `asmotion ros echo --ros 2`: prints the messages of a topic of ROS 2.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use asmotion_ros2::{Durability, Endpoint, EndpointKind, Graph, Node, Qos, Received, Reliability};
use serde_json::json;

use super::domain::DomainArguments;
use super::printed::Printed;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;

/// Messages that can wait to be printed.
const QUEUE: usize = 1000;
/// Time in which further publishers of a topic are discovered, whose quality of service counts, too.
const DISCOVERY: Duration = Duration::from_millis(500);

/// Prints each message on a line. Receiving none is a finding.
pub(super) fn run(
    (topic, domain, folders): (&str, &DomainArguments, &[PathBuf]),
    printed: &Printed,
    terminal: &mut TerminalOutput,
) -> Exit {
    let node = match domain.node(folders) {
        Ok(node) => node,
        Err(error) => {
            terminal.error(error);
            return Exit::Usage;
        }
    };
    let until = Instant::now() + Duration::from_secs(printed.limit);
    let name = format!("/{}", topic.trim_start_matches('/'));
    let Some((of, qos)) = publishers(&node, &name, until) else {
        let limit = printed.limit;
        terminal.warn(format_args!(
            "no node published `{name}` within {limit} s (`asmotion ros list --ros 2` shows the topics)"
        ));
        return Exit::Findings;
    };
    let parsed = of.parse().map_err(|error| format!("{error}"));
    let subscribed = parsed.and_then(|of| {
        let subscription = node.subscription(&name, &of, qos);
        subscription.map_err(|error| error.to_string())
    });
    let subscription = match subscribed {
        Ok(subscription) => subscription,
        Err(error) => {
            terminal.error(error);
            return Exit::Usage;
        }
    };
    let mut count = 0;
    while printed.count.is_none_or(|max| count < max) {
        let left = until.saturating_duration_since(Instant::now());
        let Some(received) = subscription.wait(left) else {
            break;
        };
        count += 1;
        let source = node.graph().node_of(received.writer);
        terminal.result(line(&received, source, (&name, &of), printed.json));
    }
    let counts = subscription.counts();
    if counts.dropped > 0 {
        let dropped = counts.dropped;
        terminal.warn(format_args!(
            "{dropped} messages were not printed: there were too many"
        ));
    }
    if let Some(error) = counts.last_error {
        let malformed = counts.malformed;
        terminal.warn(format_args!(
            "{malformed} messages were not of the type `{of}`: {error}"
        ));
    }
    if count > 0 {
        return Exit::Ok;
    }
    let limit = printed.limit;
    terminal.warn(format_args!("no message on `{name}` within {limit} s"));
    Exit::Findings
}

/// Waits for publishers of a topic. Returns their type, and a quality of service that matches all of them.
fn publishers(node: &Node, name: &str, until: Instant) -> Option<(String, Qos)> {
    let found = |graph: &Graph| of_topic(graph, name).next().is_some();
    let left = until.saturating_duration_since(Instant::now());
    if !node.wait_for_graph(left, found) {
        return None;
    }
    std::thread::sleep(DISCOVERY.min(until.saturating_duration_since(Instant::now())));
    let graph = node.graph();
    let first = of_topic(&graph, name).next()?;
    let (_, of) = first.ros.clone()?;
    let all = |has: fn(&Qos) -> bool| of_topic(&graph, name).all(|it| has(&it.qos));
    let qos = Qos {
        reliability: if all(|qos| qos.reliability == Reliability::Reliable) {
            Reliability::Reliable
        } else {
            Reliability::BestEffort
        },
        durability: if all(|qos| qos.durability == Durability::TransientLocal) {
            Durability::TransientLocal
        } else {
            Durability::Volatile
        },
        ..Qos::default().depth(QUEUE)
    };
    Some((of, qos))
}

fn of_topic<'g>(graph: &'g Graph, name: &'g str) -> impl Iterator<Item = &'g Endpoint> {
    let writers = graph.endpoints.values();
    let writers = writers.filter(|it| it.kind == EndpointKind::Writer);
    writers.filter(move |it| {
        let is_topic = it.topic.starts_with("rt");
        is_topic && it.ros.as_ref().is_some_and(|(topic, _)| topic == name)
    })
}

fn line(
    received: &Received,
    source: Option<String>,
    (topic, of): (&str, &str),
    is_json: bool,
) -> String {
    let content = &received.message;
    if !is_json {
        return format!("{} {content}", source.as_deref().unwrap_or("(no node)"));
    }
    let content = asmotion_datum::json::encode(content);
    let content = content.unwrap_or_else(|error| json!(error.to_string()).to_string());
    let about = json!({
        "topic": topic, "source": source, "sequence": received.sequence, "type": of,
    });
    let about = about.to_string();
    let about = about.trim_end_matches('}');
    format!("{about},\"content\":{content}}}")
}
