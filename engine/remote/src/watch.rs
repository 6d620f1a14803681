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

/// A sample of a watched output.
#[derive(Clone, Debug, PartialEq)]
pub struct WatchedSample {
    /// The sample, or the reason why it cannot be decoded.
    pub content: Result<Datum, DatumError>,
    /// Time for which it waited, for example because its reader stood still.
    pub age: Duration,
}

/// The samples of an output. If [`next_within`](Self::next_within) is not called for some seconds, the lease expires
/// and samples are missed.
pub struct OutputWatch {
    remote: Remote,
    component: ComponentLocation,
    port: String,
    samples: Subscription,
    renewed_at: Instant,
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
            component: of.clone(),
            port: port.to_owned(),
            samples,
            renewed_at: Instant::now(),
        })
    }

    /// Waits up to `timeout` for the next sample.
    pub fn next_within(&mut self, timeout: Duration) -> Option<WatchedSample> {
        let until = asmotion_bus::deadline_after(timeout);
        loop {
            if self.renewed_at.elapsed() >= AGAIN {
                self.renewed_at = Instant::now();
                // a renewal that is lost is repeated
                let _ = self
                    .remote
                    .send_order(&self.component, OrderKind::Watch(self.port.clone()));
            }
            let remaining = until.saturating_duration_since(Instant::now());
            let next = self.samples.next_within(remaining.min(AGAIN));
            if next.is_some() || remaining.is_zero() {
                return next.map(|envelope| WatchedSample {
                    content: envelope.payload.to_datum(),
                    age: envelope.age,
                });
            }
        }
    }
}
