//! `asmotion topic pub`: publishes a message.

use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_bus::{Payload, PublishOptions, SenderId};
use asmotion_datum::{Codec, Datum, Schema};
use asmotion_remote::Remote;
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

    /// Type of the message, `geometry_msgs/Twist`; readers check the fields only
    #[arg(long = "type", default_value = "")]
    kind: String,

    /// Number of times to publish it
    #[arg(long, default_value_t = 1)]
    count: u64,

    /// Messages per second
    #[arg(long, default_value_t = 1.0)]
    rate: f64,
}

impl Pub {
    /// Publishes the message. A topic without subscribers earns a warning, not a failure.
    pub fn run(self, remote: &Remote, terminal: &mut TerminalOutput) -> Result<Exit, String> {
        let message: Datum = asmotion_datum::json::decode(&self.message)
            .map_err(|error| format!("`{}` is not JSON: {error}", self.message))?;
        let pause = Duration::try_from_secs_f64(1.0 / self.rate)
            .map_err(|_| format!("`--rate {}`: expected a number above zero", self.rate))?;
        let origin = SenderId::new("asmotion-tool", 0);
        let sending =
            PublishOptions::events(NonZeroUsize::MIN.saturating_add(255)).with_codec(Codec::Json);
        let kind = Schema::opaque(self.kind);
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
            terminal.warn(format_args!("`{}` has no subscriber", self.topic));
        }
        Ok(Exit::Ok)
    }
}

fn now() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    i64::try_from(now.unwrap_or_default().as_nanos()).unwrap_or(i64::MAX)
}
