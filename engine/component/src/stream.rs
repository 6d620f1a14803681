//! Streams: single ports joined to what is beyond the system and speaks a language of its own (RTT `createStream`).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_connection::Delivery;
use asmotion_datum::{DatumError, Sample};

use crate::Time;
use crate::door::Door;
use crate::live::World;
use crate::port::AnySender;

/// Where the samples of an output go.
pub trait Sink: Send + 'static {
    /// Its name, for people: `mqueue:/jointStatus`.
    fn name(&self) -> String;

    /// Sends a sample, or drops it. Never waits: it is called in the writer's cycle.
    ///
    /// # Errors
    /// The sample cannot be sent at all.
    fn send(&mut self, sample: Arc<dyn Sample>) -> Result<Delivery, DatumError>;
}

/// Where the samples of an input come from.
pub trait Source: Send + 'static {
    /// Its name, for people: `mqueue:/commands`.
    fn name(&self) -> String;

    /// The next sample, waited for so long at most. `None` if none came; an error for one that cannot be read.
    fn next(&mut self, at_most: Duration) -> Option<Result<Arc<dyn Sample>, DatumError>>;
}

/// A sink as the reading end of a connection.
pub(crate) struct Outgoing(pub Box<dyn Sink>);

impl AnySender for Outgoing {
    fn accepts(&self, _: &Arc<dyn Sample>) -> Result<(), DatumError> {
        Ok(())
    }

    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        _: Time,
        _: u64,
    ) -> Result<Delivery, DatumError> {
        self.0.send(sample)
    }
}

/// A source and the port it leads to.
pub(crate) struct Incoming {
    pub source: Box<dyn Source>,
    pub door: Door,
}

/// The longest wait for a sample, so that an end is noticed.
const NAP: Duration = Duration::from_millis(100);

/// The threads that let in what sources have; they end with this.
pub(crate) struct Letting {
    ended: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Letting {
    pub(crate) fn new(streams: Vec<Incoming>, world: &World) -> Self {
        let ended = Arc::new(AtomicBool::new(false));
        let thread = |stream: Incoming| {
            let (ended, world) = (Arc::clone(&ended), world.clone());
            let thread = std::thread::Builder::new().name(stream.source.name());
            thread.spawn(move || stream.let_in(&ended, world)).ok()
        };
        Self {
            threads: streams.into_iter().filter_map(thread).collect(),
            ended,
        }
    }
}

impl Drop for Letting {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        for thread in self.threads.drain(..) {
            // each looks up at every nap
            let _ = thread.join();
        }
    }
}

impl Incoming {
    fn let_in(mut self, ended: &AtomicBool, mut world: World) {
        while !ended.load(Ordering::Acquire) {
            let sample = self.source.next(NAP);
            let now = world.now();
            match sample {
                Some(Ok(sample)) => self.door.let_in(&sample, now, &mut world),
                Some(Err(reason)) => self.door.drop_some(1, Some(&reason), now, &mut world),
                None => {}
            }
        }
    }
}
