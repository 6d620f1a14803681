//! Watches an output: its process publishes the output under a lease, which the watcher renews.

use std::time::{Duration, Instant};

use asmotion_bus::Subscription;
use asmotion_datum::{Datum, DatumError};

use crate::contact::watch_topic;
use crate::error::RemoteError;
use crate::order::OrderKind;
use crate::presence::key;
use crate::remote::Remote;
use crate::roster::ComponentLocation;

/// Period at which the lease is renewed.
const AGAIN: Duration = Duration::from_secs(5);

/// The samples of an output. If [`next_within`](Self::next_within) is not called for some seconds, the lease expires
/// and samples are missed.
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
        // subscribes before the order, so that no sample is missed
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

    /// Waits up to `at_most` for the next sample.
    pub fn next_within(&mut self, at_most: Duration) -> Option<Result<Datum, DatumError>> {
        let until = asmotion_bus::later(at_most);
        loop {
            if self.asked.elapsed() >= AGAIN {
                self.asked = Instant::now();
                // a renewal that is lost is repeated
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
