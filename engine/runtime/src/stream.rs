//! Streams: single ports connected to another middleware (RTT `createStream`).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_datum::{DatumError, Sample};
use asmotion_port::{AnySender, PushOutcome, Time};

use crate::context::LiveContext;
use crate::injection::InjectionPort;

/// The destination of an output's samples.
pub trait Sink: Send + 'static {
    /// Name for messages, for example `mqueue:/jointStatus`.
    fn name(&self) -> String;

    /// Sends or drops a sample. Must not block: it is called in the writer's cycle.
    ///
    /// # Errors
    /// Returns an error if the sample cannot be encoded.
    fn send(&mut self, sample: Arc<dyn Sample>) -> Result<PushOutcome, DatumError>;
}

/// The origin of an input's samples.
pub trait Source: Send + 'static {
    /// Name for messages, for example `mqueue:/commands`.
    fn name(&self) -> String;

    /// Waits up to `timeout` for the next sample. Returns `None` if none arrives, and an error for a sample that cannot
    /// be decoded.
    fn next(&mut self, timeout: Duration) -> Option<Result<Arc<dyn Sample>, DatumError>>;
}

/// Adapts a sink to the reading end of a connection.
pub(crate) struct SinkSender(pub Box<dyn Sink>);

impl AnySender for SinkSender {
    fn check(&self, _: &Arc<dyn Sample>) -> Result<(), DatumError> {
        Ok(())
    }

    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        _: Time,
        _: u64,
    ) -> Result<PushOutcome, DatumError> {
        self.0.send(sample)
    }
}

/// A source, and the port that its samples go to.
pub(crate) struct SourceStream {
    pub source: Box<dyn Source>,
    pub port: InjectionPort,
}

/// Longest wait for a sample, which bounds the time until a thread notices its end.
const NAP: Duration = Duration::from_millis(100);

/// The threads that read sources, one each. Dropping this ends them: each checks `ended` after every wait.
pub(crate) struct SourceThreads {
    ended: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl SourceThreads {
    pub(crate) fn new(streams: Vec<SourceStream>, context: &LiveContext) -> Self {
        let ended = Arc::new(AtomicBool::new(false));
        let thread = |stream: SourceStream| {
            let (ended, context) = (Arc::clone(&ended), context.clone());
            let thread = std::thread::Builder::new().name(stream.source.name());
            thread
                .spawn(move || stream.inject_all(&ended, context))
                .ok()
        };
        Self {
            threads: streams.into_iter().filter_map(thread).collect(),
            ended,
        }
    }
}

impl Drop for SourceThreads {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        for thread in self.threads.drain(..) {
            // fails if the source has panicked, which ended the thread
            let _ = thread.join();
        }
    }
}

impl SourceStream {
    fn inject_all(mut self, ended: &AtomicBool, mut context: LiveContext) {
        while !ended.load(Ordering::Acquire) {
            let sample = self.source.next(NAP);
            let now = context.now();
            match sample {
                Some(Ok(sample)) => self.port.inject(&sample, now, &mut context),
                Some(Err(reason)) => self.port.count_dropped(1, Some(&reason), now, &mut context),
                None => {}
            }
        }
    }
}
