//! `asmotion topic echo`: prints the messages of a topic.

use super::{OLD, unknown_topic};
use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_bus::Envelope;
use asmotion_composite::Catalogue;
use asmotion_datum::{Datum, Message};
use asmotion_remote::Remote;
use clap::Args;
use serde_json::json;
use std::time::{Duration, Instant};

/// Time without a message after which an unknown topic is reported.
const DISCOVERY: Duration = Duration::from_millis(500);

#[derive(Args)]
pub struct Echo {
    /// Key of the topic, `navigation.odom`; `*` matches one word, `#` any number of words
    topic: String,

    /// Ends after this many messages
    #[arg(long)]
    count: Option<u64>,

    /// Ends after this many seconds
    #[arg(long = "for", value_name = "SECONDS", default_value_t = 60)]
    limit: u64,
}

impl Echo {
    /// Prints each message as a JSON object on a line. Receiving none is a finding. If the topic is unknown, this warns and
    /// waits for it. No message that waited, because nobody read the output, is printed as a new one, and none is left out
    /// silently.
    pub fn run(
        self,
        remote: &Remote,
        build: &Build,
        terminal: &mut TerminalOutput,
    ) -> Result<Exit, String> {
        let subscription = remote
            .listen(&self.topic)
            .map_err(|error| error.to_string())?;
        let catalogue = build.catalogue();
        let until = Instant::now() + Duration::from_secs(self.limit);
        let (mut count, mut dropped) = (0, 0);
        let mut first = subscription.next_within(DISCOVERY.min(Duration::from_secs(self.limit)));
        if first.is_none()
            && let Some(warning) = unknown_topic(&self.topic, remote)
        {
            terminal.warn(format_args!("{warning}; waiting for {} s", self.limit));
        }
        while self.count.is_none_or(|max| count < max) {
            let remaining = until.saturating_duration_since(Instant::now());
            let next = || subscription.next_within(remaining);
            let Some(envelope) = first.take().or_else(next) else {
                break;
            };
            count += 1;
            terminal.result(line(&envelope, catalogue));
            let now = subscription.dropped();
            if now > dropped {
                let more = now - dropped;
                terminal.warn(format_args!(
                    "{more} messages not shown, because nobody read the output"
                ));
                dropped = now;
            }
        }
        Ok(if count > 0 { Exit::Ok } else { Exit::Findings })
    }
}

fn line(envelope: &Envelope, catalogue: &dyn Catalogue) -> String {
    // a codec that does not describe itself needs the schema of the type
    let schema = catalogue.schema(&envelope.type_name);
    let schema = schema.as_ref().unwrap_or(Datum::schema());
    let content = envelope.payload.to_datum_of(schema);
    let content = content.and_then(|datum| asmotion_datum::json::encode(&datum));
    // numbers keep the notation of the sender
    let content = content.unwrap_or_else(|error| json!(error.to_string()).to_string());
    let mut about = json!({
        "topic": &*envelope.topic, "source": &*envelope.source, "sequence": envelope.sequence,
        "stamp": envelope.stamp, "type": &*envelope.type_name,
    });
    if envelope.age >= OLD {
        about["age_s"] = json!(envelope.age.as_millis() as f64 / 1e3);
    }
    let about = about.to_string();
    let about = about.trim_end_matches('}');
    format!("{about},\"content\":{content}}}")
}
