//! `asmotion topic list`: the topics, their types, who writes and reads them, and how often.

use crate::broker;
use crate::exit::Exit;
use crate::table;
use crate::terminal::Terminal;
use amqp::AmqpBus;
use clap::Args;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

#[derive(Args)]
pub struct List {}

/// What is known of a topic.
#[derive(Default)]
struct Known {
    kind: String,
    publishers: BTreeSet<String>,
    subscribers: BTreeSet<String>,
    /// How many messages came.
    count: u32,
}

impl List {
    /// Asks and listens, for a second and a half.
    pub fn run(self, bus: &AmqpBus, terminal: &mut Terminal) -> Result<Exit, String> {
        let failed = |error: bus::BusError| error.to_string();
        let everything = broker::listen(bus, "#").map_err(failed)?;
        let began = Instant::now();
        let presences = broker::presences(bus).map_err(failed)?;
        let mut topics: BTreeMap<String, Known> = BTreeMap::new();
        while let Some(envelope) = everything.try_next() {
            let known = topics.entry(envelope.topic.to_string()).or_default();
            known.count += 1;
            known.kind = envelope.type_name.to_string();
            known.publishers.insert(envelope.source.to_string());
        }
        let seconds = began.elapsed().as_secs_f64();
        for ((robot, _), presence) in &presences {
            for topic in &presence.topics {
                let known = topics.entry(broker::key(robot, &topic.name)).or_default();
                if let Some(kind) = &topic.kind {
                    known.kind.clone_from(kind);
                }
                known.publishers.extend(components(&topic.publishers));
                known.subscribers.extend(components(&topic.subscribers));
            }
        }
        let names = |names: &BTreeSet<String>| match names.is_empty() {
            true => "-".to_owned(),
            false => names.iter().cloned().collect::<Vec<_>>().join(" "),
        };
        let rows = topics.iter().map(|(topic, known)| {
            vec![
                topic.clone(),
                known.kind.clone(),
                format!("{:.1}", f64::from(known.count) / seconds),
                names(&known.publishers),
                names(&known.subscribers),
            ]
        });
        let head = ["topic", "type", "Hz", "from", "to"];
        for line in table::lines(&head, rows) {
            terminal.result(line);
        }
        Ok(Exit::Ok)
    }
}

/// The components of ports.
fn components(ports: &[String]) -> impl Iterator<Item = String> {
    let component = |port: &String| {
        port.rsplit_once('.')
            .map_or(port.clone(), |(it, _)| it.to_owned())
    };
    ports.iter().map(component)
}
