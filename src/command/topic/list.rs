//! `asmotion topic list`: lists topics with type, publishers, subscribers and rate.

use crate::exit::Exit;
use crate::table;
use crate::terminal::TerminalOutput;
use asmotion_remote::{Presence, Remote};
use clap::Args;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

#[derive(Args)]
pub struct TopicList {}

/// The known facts about a topic.
#[derive(Default)]
struct TopicInfo {
    kind: String,
    publishers: BTreeSet<String>,
    subscribers: BTreeSet<String>,
    /// Number of received messages.
    count: u32,
}

impl TopicList {
    /// Collects descriptions and messages for a second and a half.
    pub fn run(self, remote: &Remote, terminal: &mut TerminalOutput) -> Result<Exit, String> {
        let everything = remote.listen("#").map_err(|error| error.to_string())?;
        let started = Instant::now();
        let presences = remote.processes();
        let mut topics: BTreeMap<String, TopicInfo> = BTreeMap::new();
        while let Some(envelope) = everything.try_next() {
            let known = topics.entry(envelope.topic.to_string()).or_default();
            known.count += 1;
            known.kind = envelope.type_name.to_string();
            known.publishers.insert(envelope.source.to_string());
        }
        let seconds = started.elapsed().as_secs_f64();
        for presence in &presences {
            for topic in &presence.presence.topics {
                let known = topics.entry(presence.key(&topic.name)).or_default();
                if let Some(kind) = &topic.kind {
                    known.kind.clone_from(kind);
                }
                let components = |ports| components(ports, &presence.presence);
                known.publishers.extend(components(&topic.publishers));
                known.subscribers.extend(components(&topic.subscribers));
            }
        }
        let names = |names: &BTreeSet<String>| {
            if names.is_empty() {
                "-".to_owned()
            } else {
                names.iter().cloned().collect::<Vec<_>>().join(" ")
            }
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

/// The components of these ports, by their names outside the composite.
fn components(ports: &[String], presence: &Presence) -> Vec<String> {
    let component = |port: &String| {
        let name = port.rsplit_once('.').map_or(&**port, |(it, _)| it);
        let mut known = presence.components.iter();
        let id = known.find(|it| it.name == name).map(|it| it.id.clone());
        id.filter(|id| !id.is_empty())
            .unwrap_or_else(|| name.to_owned())
    };
    ports.iter().map(component).collect()
}
