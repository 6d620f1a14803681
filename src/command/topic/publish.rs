//! `asmotion topic pub`: publishes a message.

use super::unknown_topic;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_bus::{Payload, PublishOptions, SenderId};
use asmotion_datum::{Codec, Datum, Schema};
use asmotion_remote::{Remote, check_message};
use clap::Args;
use std::num::NonZeroUsize;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

#[derive(Args)]
pub struct Pub {
    /// Key of the topic, `navigation.goal`
    topic: String,

    /// Message as JSON; omitted fields have their default values
    #[arg(default_value = "{}")]
    message: String,

    /// Type of the message, `geometry_msgs/Twist`; readers check the fields only [default: the type of the topic]
    #[arg(long = "type")]
    kind: Option<String>,

    /// Number of times to publish it
    #[arg(long, default_value_t = 1)]
    count: u64,

    /// Publishes the message even if its readers refuse it
    #[arg(long)]
    unchecked: bool,

    /// Messages per second
    #[arg(long, default_value_t = 1.0)]
    rate: f64,
}

impl Pub {
    /// Publishes the message, if it fits the type that each reader expects. A topic without subscribers earns a warning, not
    /// a failure.
    pub fn run(self, remote: &Remote, terminal: &mut TerminalOutput) -> Result<Exit, String> {
        let message: Datum = asmotion_datum::json::decode(&self.message)
            .map_err(|error| format!("`{}` is not JSON: {error}", self.message))?;
        let pause = Duration::try_from_secs_f64(1.0 / self.rate)
            .map_err(|_| format!("`--rate {}`: expected a number above zero", self.rate))?;
        let origin = SenderId::new("asmotion-tool", 0);
        let sending =
            PublishOptions::events(NonZeroUsize::MIN.saturating_add(255)).with_codec(Codec::Json);
        let readers = readers(&self.topic, remote);
        if !self.unchecked {
            check(&message, &self.topic, &readers)?;
        }
        let known = readers.first().map(|(_, schema)| schema.name.to_string());
        let kind = Schema::opaque(self.kind.or(known).unwrap_or_default());
        let bus = remote.bus();
        let mut publisher = bus
            .publisher(&self.topic, &origin, &kind, sending)
            .map_err(|error| error.to_string())?;
        for number in 0..self.count {
            if number > 0 {
                std::thread::sleep(pause);
            }
            publisher
                .publish(now(), Payload::of(message.clone()))
                .map_err(|error| error.to_string())?;
        }
        if !bus.drain(Duration::from_secs(5)) {
            return Err("the broker has not confirmed all messages".to_owned());
        }
        let sent = publisher.counts();
        if sent.refused + sent.lost > 0 {
            return Err(format!("{} refused, {} lost", sent.refused, sent.lost));
        }
        if sent.unrouted > 0 {
            let unknown = unknown_topic(&self.topic, remote);
            let reason = unknown.map_or_else(String::new, |unknown| format!(": {unknown}"));
            terminal.warn(format_args!("`{}` has no subscriber{reason}", self.topic));
        }
        Ok(Exit::Ok)
    }
}

/// The inputs that subscribe to a topic, with the types that they expect. Inputs of processes that do not reply are left
/// out.
fn readers(topic: &str, remote: &Remote) -> Vec<(String, Schema)> {
    let mut readers = Vec::new();
    for presence in remote.processes() {
        let topics = presence.presence.topics.iter();
        let subscribers = topics.filter(|known| presence.key(&known.name) == topic);
        for input in subscribers.flat_map(|topic| &topic.subscribers) {
            readers.extend(expected(&presence.key(input), remote));
        }
    }
    readers
}

/// The type of an input, `robot.Component.port`.
fn expected(input: &str, remote: &Remote) -> Option<(String, Schema)> {
    let (component, port) = input.rsplit_once('.')?;
    let declared = remote.component(component).ok()?.declaration().ok()?;
    let schema = declared.input(port)?.schema.clone();
    Some((input.to_owned(), schema))
}

/// Checks a message against the types of all readers.
fn check(message: &Datum, topic: &str, readers: &[(String, Schema)]) -> Result<(), String> {
    for (input, schema) in readers {
        check_message(message, input, schema).map_err(|error| {
            format!("a reader of `{topic}` refuses the message: {error} (`--unchecked` publishes it anyway)")
        })?;
    }
    Ok(())
}

fn now() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    i64::try_from(now.unwrap_or_default().as_nanos()).unwrap_or(i64::MAX)
}
