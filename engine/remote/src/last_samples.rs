//! What left each output last, and who watches what leaves next.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use asmotion_bus::{Payload, Publisher};
use asmotion_component::Time;
use asmotion_datum::Sample;
use asmotion_runtime::{Event, Observer};

/// How long a port is watched, unless whoever watches asks again.
const LEASE: Duration = Duration::from_secs(15);

/// What left each output last. As an observer of the system it sends what is watched to those who watch it.
#[derive(Clone, Default)]
pub struct LastSamples(Arc<Mutex<LastSamplesState>>);

#[derive(Default)]
struct LastSamplesState {
    /// By `Component.port`.
    samples: BTreeMap<String, Arc<dyn Sample>>,
    watched: BTreeMap<String, WatchedOutput>,
}

/// A port that somebody watches.
struct WatchedOutput {
    publisher: Box<dyn Publisher>,
    until: Instant,
}

impl Observer for LastSamples {
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
        let mut kept = self.kept();
        if let Some(watched) = kept.watched.get_mut(&port) {
            match watched.until > Instant::now() {
                // What a bus does not take, whoever watches misses; the next one is newer.
                true => drop(
                    watched
                        .publisher
                        .publish(now(), Payload::Sample(sample.to_shared())),
                ),
                false => drop(kept.watched.remove(&port)),
            }
        }
        kept.samples.insert(port, sample.to_shared());
    }
}

impl LastSamples {
    /// The last sample of an output, `Component.port`.
    pub(crate) fn of(&self, port: &str) -> Option<Arc<dyn Sample>> {
        self.kept().samples.get(port).cloned()
    }

    /// From now on, and for some time, what leaves an output is published; and so is what left it last.
    pub(crate) fn watch<E>(
        &self,
        port: &str,
        publisher: impl FnOnce() -> Result<Box<dyn Publisher>, E>,
    ) -> Result<(), E> {
        let until = Instant::now() + LEASE;
        let mut kept = self.kept();
        if let Some(watched) = kept.watched.get_mut(port) {
            watched.until = until;
            return Ok(());
        }
        let mut publisher = publisher()?;
        if let Some(sample) = kept.samples.get(port) {
            let _ = publisher.publish(now(), Payload::Sample(Arc::clone(sample)));
        }
        kept.watched
            .insert(port.to_owned(), WatchedOutput { publisher, until });
        Ok(())
    }

    fn kept(&self) -> MutexGuard<'_, LastSamplesState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Now, on the wall, in nanoseconds.
pub(crate) fn now() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    i64::try_from(now.unwrap_or_default().as_nanos()).unwrap_or(i64::MAX)
}
