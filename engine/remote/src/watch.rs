//! An output watched from outside: its process publishes what leaves it, as long as it is asked again and again.

use std::time::{Duration, Instant};

use asmotion_bus::Subscription;
use asmotion_datum::{Datum, DatumError};

use crate::contact::watch_topic;
use crate::error::RemoteError;
use crate::order::OrderKind;
use crate::presence::key;
use crate::remote::Remote;
use crate::roster::ComponentLocation;

/// How often to ask again.
const AGAIN: Duration = Duration::from_secs(5);

/// All that leaves an output. Whoever does not look for some seconds misses what comes then.
pub struct OutputWatch {
    remote: Remote,
    of: ComponentLocation,
    port: String,
    samples: Subscription,
    asked: Instant,
}

impl OutputWatch {
    pub(crate) fn new(
        remote: &Remote,
        of: &ComponentLocation,
        port: &str,
    ) -> Result<Self, RemoteError> {
        let topic = watch_topic(&format!("{}.{port}", of.present.name));
        // first the ear, then the word
        let samples = remote.listen(&key(&of.robot, &topic))?;
        remote.order(of, OrderKind::Watch(port.to_owned()))?;
        Ok(Self {
            remote: remote.clone(),
            of: of.clone(),
            port: port.to_owned(),
            samples,
            asked: Instant::now(),
        })
    }

    /// The next message, waiting for it at the longest so long.
    pub fn next_within(&mut self, at_most: Duration) -> Option<Result<Datum, DatumError>> {
        let until = asmotion_bus::later(at_most);
        loop {
            if self.asked.elapsed() >= AGAIN {
                self.asked = Instant::now();
                // What does not get through is asked again.
                let _ = self
                    .remote
                    .tell(&self.of, OrderKind::Watch(self.port.clone()));
            }
            let left = until.saturating_duration_since(Instant::now());
            let next = self.samples.next_within(left.min(AGAIN));
            if next.is_some() || left.is_zero() {
                return next.map(|envelope| envelope.payload.to_datum());
            }
        }
    }
}
