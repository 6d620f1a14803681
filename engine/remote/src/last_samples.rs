//! The newest sample of each output, and the outputs that are watched.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use asmotion_bus::{Payload, Publisher};
use asmotion_component::Time;
use asmotion_datum::Sample;
use asmotion_runtime::{Event, Observer, ReportInterest};

/// Lease of a watch: the output is published until it expires, unless the watcher renews it.
const LEASE: Duration = Duration::from_secs(15);

/// The newest sample of each output. As an observer of the system, it also publishes the samples of watched outputs.
#[derive(Clone, Default)]
pub struct LastSamples(Arc<Mutex<LastSamplesState>>);

#[derive(Default)]
struct LastSamplesState {
    /// Newest samples by output, `Component.port`.
    samples: BTreeMap<String, Arc<dyn Sample>>,
    watched: BTreeMap<String, WatchedOutput>,
}

/// An output that is watched.
struct WatchedOutput {
    publisher: Box<dyn Publisher>,
    until: Instant,
}

impl Observer for LastSamples {
    fn reports(&self) -> ReportInterest {
        ReportInterest::NONE
    }

    fn observe(&mut self, _: Time, event: &Event<'_>) {
        let Event::Published {
            component,
            port,
            sample,
            ..
        } = event
        else {
            return;
        };
        let port = format!("{component}.{port}");
        let mut state = self.state();
        if let Some(watched) = state.watched.get_mut(&port) {
            if watched.until > Instant::now() {
                // a sample that the bus does not accept is lost; the next one is newer anyway
                let _ = watched
                    .publisher
                    .publish(now(), Payload::Sample(sample.to_shared()));
            } else {
                state.watched.remove(&port);
            }
        }
        state.samples.insert(port, sample.to_shared());
    }
}

impl LastSamples {
    /// The newest sample of an output, `Component.port`.
    pub(crate) fn of(&self, port: &str) -> Option<Arc<dyn Sample>> {
        self.state().samples.get(port).cloned()
    }

    /// Publishes the newest sample of an output, and later ones until the lease expires.
    pub(crate) fn watch<E>(
        &self,
        port: &str,
        publisher: impl FnOnce() -> Result<Box<dyn Publisher>, E>,
    ) -> Result<(), E> {
        let until = Instant::now() + LEASE;
        let mut state = self.state();
        if let Some(watched) = state.watched.get_mut(port) {
            watched.until = until;
            return Ok(());
        }
        let mut publisher = publisher()?;
        if let Some(sample) = state.samples.get(port) {
            let _ = publisher.publish(now(), Payload::Sample(Arc::clone(sample)));
        }
        state
            .watched
            .insert(port.to_owned(), WatchedOutput { publisher, until });
        Ok(())
    }

    fn state(&self) -> MutexGuard<'_, LastSamplesState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Current wall-clock time, in nanoseconds since the Unix epoch.
pub(crate) fn now() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    i64::try_from(now.unwrap_or_default().as_nanos()).unwrap_or(i64::MAX)
}
