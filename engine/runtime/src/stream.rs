//! Streams: single ports connected to another middleware (RTT `createStream`).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_datum::{Datum, DatumError, Sample};
use asmotion_port::{AnySender, PushOutcome, Time};

use crate::context::LiveContext;
use crate::effects::Effects;
use crate::event::Event;
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

    /// Returns the sink's work between samples, which a live system does in a thread of its own. Called once. The
    /// default has none.
    fn upkeep(&mut self) -> Option<Box<dyn SinkUpkeep>> {
        None
    }
}

/// The work of a sink between samples.
pub trait SinkUpkeep: Send + 'static {
    /// Called about ten times a second. Reports samples that were discarded after they had been sent, by number and
    /// reason; a problem that costs no sample has the number 0.
    fn tend(&mut self, report: &mut dyn FnMut(u64, &DatumError));
}

/// The origin of an input's samples.
pub trait Source: Send + 'static {
    /// Name for messages, for example `mqueue:/commands`.
    fn name(&self) -> String;

    /// Waits up to `timeout` for the next event. Returns `None` if there is none.
    fn next(&mut self, timeout: Duration) -> Option<SourceEvent>;
}

/// An event of a source.
#[derive(Debug, Clone)]
pub enum SourceEvent {
    /// A sample.
    Sample(Arc<dyn Sample>),
    /// Samples that cannot be decoded or must not be passed on.
    Discarded {
        /// Number of samples; 0 for a problem that costs none.
        count: u64,
        /// Why they were discarded.
        reason: DatumError,
    },
    /// The other side has not been there for some time. Reported to observers as
    /// [`WAITING_REPORT`].
    Waiting,
}

/// Kind of the report ([`Event::Report`]) of an input whose source waits for the other side; its content is the
/// source's name.
pub const WAITING_REPORT: &str = "stream/Waiting";

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

/// A sink's upkeep, and the connection of its samples.
pub(crate) struct SinkStream {
    pub upkeep: Box<dyn SinkUpkeep>,
    /// Name of the writing component.
    pub component: Arc<str>,
    /// Name of its output port.
    pub port: String,
    /// Name of the sink.
    pub to: String,
    /// Counter of the connection, shared with the port.
    pub dropped: Arc<AtomicU64>,
}

/// A source, and the port that its samples go to.
pub(crate) struct SourceStream {
    pub source: Box<dyn Source>,
    pub port: InjectionPort,
}

/// Longest wait of a thread, which bounds the time until it notices its end.
const NAP: Duration = Duration::from_millis(100);

/// The thread that does the upkeep of all sinks. Dropping this ends it: it checks `ended` after every pause.
pub(crate) struct SinkThread {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl SinkThread {
    pub(crate) fn new(mut streams: Vec<SinkStream>, mut context: LiveContext) -> Self {
        let ended = Arc::new(AtomicBool::new(false));
        let ending = Arc::clone(&ended);
        let work = move || {
            while !ending.load(Ordering::Acquire) {
                for stream in &mut streams {
                    stream.tend(&mut context);
                }
                std::thread::park_timeout(NAP);
            }
        };
        let thread = std::thread::Builder::new().name("sinks".to_owned());
        Self {
            ended,
            thread: thread.spawn(work).ok(),
        }
    }
}

impl Drop for SinkThread {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // fails if an upkeep has panicked, which ended the thread
            let _ = thread.join();
        }
    }
}

impl SinkStream {
    fn tend(&mut self, context: &mut LiveContext) {
        let now = context.now();
        self.upkeep.tend(&mut |count, reason| {
            let total = self.dropped.fetch_add(count, Ordering::Relaxed) + count;
            let event = Event::Dropped {
                component: &self.component,
                port: &self.port,
                to: &self.to,
                total,
                reason: Some(reason),
            };
            context.emit(now, &event);
        });
    }
}

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
            let event = self.source.next(NAP);
            let now = context.now();
            match event {
                Some(SourceEvent::Sample(sample)) => self.port.inject(&sample, now, &mut context),
                Some(SourceEvent::Discarded { count, reason }) => {
                    self.port
                        .count_dropped(count, Some(&reason), now, &mut context);
                }
                Some(SourceEvent::Waiting) => {
                    let data = Datum::text(self.source.name());
                    let component = self.port.component_name();
                    let event = Event::Report {
                        component,
                        kind: WAITING_REPORT,
                        data: &data,
                    };
                    context.emit(now, &event);
                }
                None => {}
            }
        }
    }
}
