//! The receiving end of a queue: an input port to which an Orocos component writes.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use asmotion_datum::{Datum, DatumError, Sample};
use asmotion_runtime::{Source, SourceEvent};

use crate::layout::QueueLayout;
use crate::name::QueueName;
use crate::queue::{HolderAccess, KernelQueue, QueueHolder};
use crate::queue_priority::QueuePriority;
use crate::writer::{problem, to_datum_error};

/// Reads messages. The writer creates the queue; the reader searches for it until it exists, and again when it has been
/// removed.
///
/// The first message of a writer shows only what samples look like, and is no data. Our own writers mark it; of others it
/// is the first message in a new queue, after a writer was replaced, or within half a second after the reader opened the
/// queue, which is how long RTT waits for it.
pub struct QueueReader {
    name: QueueName,
    layout: QueueLayout,
    max_age: Option<Duration>,
    queue: Option<OpenQueue>,
    search: QueueSearch,
}

/// The search for a queue that does not exist yet, or no longer.
struct QueueSearch {
    since: Instant,
    /// The queue has not existed since this search began, so that it will be a new one.
    was_absent: bool,
    /// [`QueueEvent::Waiting`] has been reported.
    is_reported: bool,
    /// The last problem, so that it is reported once.
    problem: Option<DatumError>,
}

struct OpenQueue {
    queue: KernelQueue,
    buffer: Vec<u8>,
    expected: ExpectedMessage,
    writers: WriterWatch,
}

/// The meaning of the next message of a writer other than ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ExpectedMessage {
    Data,
    /// Layout: the queue is new.
    LayoutOfQueue,
    /// Layout, if it arrives until this time: the reader is new.
    LayoutUntil(Instant),
    /// Layout, after this many messages of data: the writers are gone, and the next one is new.
    LayoutOfWriterAfter(usize),
}

/// The processes that write to a queue, as far as they are visible.
struct WriterWatch {
    writers: Vec<QueueHolder>,
    /// A writer has been seen.
    is_known: bool,
    look_at: Instant,
    pause: Duration,
}

/// An event at the receiving end of a queue.
#[derive(Debug, Clone, PartialEq)]
pub enum QueueEvent {
    /// A message of data.
    Message(Datum),
    /// Messages that were not passed on.
    Discarded {
        /// Number of messages.
        count: u64,
        /// Why they were discarded.
        reason: DatumError,
    },
    /// The queue has not existed for five seconds. Reported once in a search.
    Waiting,
}

/// Period of the search for a queue.
const SEARCH: Duration = Duration::from_millis(50);
/// Duration of a search after which it is reported.
const REPORTED_AFTER: Duration = Duration::from_secs(5);
/// Time for which RTT waits for a first message that shows the layout.
const SETTLING: Duration = Duration::from_millis(500);
/// Period of the look at known writers, and first pause between two searches for writers.
const LOOK: Duration = Duration::from_millis(50);
/// Longest pause between two searches for writers.
const LONGEST_LOOK: Duration = Duration::from_secs(5);

impl QueueReader {
    /// Creates a reader. The queue need not exist yet.
    pub fn new(name: QueueName, layout: QueueLayout) -> Self {
        Self {
            name,
            layout,
            max_age: None,
            queue: None,
            search: QueueSearch::new(false),
        }
    }

    /// Sets the age limit of messages (default: none). With a limit, messages that were in the queue before the reader
    /// opened it are discarded, because their age is unknown.
    #[must_use]
    pub fn max_age(self, max_age: Option<Duration>) -> Self {
        Self { max_age, ..self }
    }

    /// Waits up to `timeout` for the next event. Returns `None` if there is none.
    pub fn next(&mut self, timeout: Duration) -> Option<QueueEvent> {
        let Some(open) = &mut self.queue else {
            return self.open_queue(timeout);
        };
        open.watch_writers();
        let mut read = open.read();
        if read == Ok(None) {
            open.queue.wait(timeout);
            open.watch_writers();
            read = open.read();
        }
        match read {
            Ok(Some((bytes, priority))) => open.interpret(&self.layout, bytes, priority),
            Ok(None) => {
                if open.queue.is_unlinked() {
                    self.queue = None;
                    // the next queue of this name is a new one
                    self.search = QueueSearch::new(true);
                }
                None
            }
            Err(reason) => {
                self.queue = None;
                self.search = QueueSearch::new(false);
                Some(QueueEvent::Discarded { count: 1, reason })
            }
        }
    }

    /// Searches for the queue.
    fn open_queue(&mut self, timeout: Duration) -> Option<QueueEvent> {
        match KernelQueue::open_existing(&self.name) {
            Ok(Some(queue)) => self.found(queue),
            Ok(None) => {
                self.search.was_absent = true;
                thread::sleep(timeout.min(SEARCH));
                let is_long = self.search.since.elapsed() >= REPORTED_AFTER;
                let is_first = is_long && !std::mem::replace(&mut self.search.is_reported, is_long);
                is_first.then_some(QueueEvent::Waiting)
            }
            Err(problem) => {
                thread::sleep(timeout.min(SEARCH));
                let reason = to_datum_error(problem);
                let previous = self.search.problem.replace(reason.clone());
                let is_new = previous.as_ref() != Some(&reason);
                is_new.then_some(QueueEvent::Discarded { count: 0, reason })
            }
        }
    }

    fn found(&mut self, queue: KernelQueue) -> Option<QueueEvent> {
        let was_absent = self.search.was_absent;
        let now = Instant::now();
        let open = self.queue.insert(OpenQueue {
            buffer: vec![0; queue.size()],
            queue,
            expected: if was_absent {
                ExpectedMessage::LayoutOfQueue
            } else {
                ExpectedMessage::LayoutUntil(now + SETTLING)
            },
            writers: WriterWatch {
                writers: Vec::new(),
                is_known: false,
                look_at: now,
                pause: LOOK,
            },
        });
        match self.max_age {
            Some(_) if !was_absent => open.discard_waiting(),
            Some(_) | None => None,
        }
    }
}

impl QueueSearch {
    fn new(was_absent: bool) -> Self {
        Self {
            since: Instant::now(),
            was_absent,
            is_reported: false,
            problem: None,
        }
    }
}

impl OpenQueue {
    fn read(&mut self) -> Result<Option<(usize, QueuePriority)>, DatumError> {
        self.queue.pop(&mut self.buffer).map_err(to_datum_error)
    }

    /// Discards the messages in the queue, the age of which is unknown.
    fn discard_waiting(&mut self) -> Option<QueueEvent> {
        let mut count = 0;
        while let Ok(Some((_, priority))) = self.read() {
            self.expected = ExpectedMessage::Data;
            count += u64::from(priority != QueuePriority::Layout);
        }
        let reason = problem("in the queue before reading began, of unknown age".to_owned());
        (count > 0).then_some(QueueEvent::Discarded { count, reason })
    }

    /// Decides what a message is that was read.
    fn interpret(
        &mut self,
        layout: &QueueLayout,
        bytes: usize,
        priority: QueuePriority,
    ) -> Option<QueueEvent> {
        let message = layout.decode(self.buffer.get(..bytes).unwrap_or(&[]));
        let expected = match (priority, self.expected) {
            (QueuePriority::Data, _) => ExpectedMessage::Data,
            (QueuePriority::Layout, _) => ExpectedMessage::LayoutOfQueue,
            (QueuePriority::Foreign, ExpectedMessage::LayoutUntil(until))
                if Instant::now() > until =>
            {
                ExpectedMessage::Data
            }
            (QueuePriority::Foreign, ExpectedMessage::LayoutOfWriterAfter(data @ 1..)) => {
                self.expected = ExpectedMessage::LayoutOfWriterAfter(data - 1);
                return Some(event(message));
            }
            (QueuePriority::Foreign, expected) => expected,
        };
        self.expected = ExpectedMessage::Data;
        let reason = match (message, expected) {
            (message, ExpectedMessage::Data) => return Some(event(message)),
            (message @ Err(_), _) => return Some(event(message)),
            (Ok(_), ExpectedMessage::LayoutOfQueue) => return None,
            (Ok(_), ExpectedMessage::LayoutUntil(_)) => {
                "the first message after reading began may only show the layout"
            }
            (Ok(_), ExpectedMessage::LayoutOfWriterAfter(_)) => {
                "the first message of a new writer only shows the layout"
            }
        };
        let reason = problem(reason.to_owned());
        Some(QueueEvent::Discarded { count: 1, reason })
    }

    /// Notices that the writers are gone, so that the next message is a new writer's first.
    fn watch_writers(&mut self) {
        let now = Instant::now();
        let watch = &mut self.writers;
        if now < watch.look_at {
            return;
        }
        if !watch.writers.is_empty() {
            watch.look_at = now + LOOK;
            if watch.writers.iter().any(|it| self.queue.is_held_by(it)) {
                return;
            }
            watch.writers.clear();
            watch.pause = LOOK;
            let waiting = self.queue.count();
            self.expected = ExpectedMessage::LayoutOfWriterAfter(waiting);
        }
        watch.writers = self.queue.find_holders(HolderAccess::Writing).found;
        if watch.writers.is_empty() {
            watch.pause = (2 * watch.pause).min(LONGEST_LOOK);
            watch.look_at = now + watch.pause;
        } else {
            watch.is_known = true;
            watch.pause = LOOK;
            watch.look_at = now + LOOK;
        }
    }
}

fn event(message: Result<Datum, DatumError>) -> QueueEvent {
    match message {
        Ok(datum) => QueueEvent::Message(datum),
        Err(reason) => QueueEvent::Discarded { count: 1, reason },
    }
}

/// Removes the queue's name if the last writer has left it to this reader, so that the queue does not stay for ever.
impl Drop for OpenQueue {
    fn drop(&mut self) {
        let others = self.queue.find_holders(HolderAccess::Any);
        let nobody = others.found.is_empty() && (others.complete || self.writers.is_known);
        if nobody && !self.queue.is_unlinked() {
            self.queue.unlink();
        }
    }
}

impl Source for QueueReader {
    fn name(&self) -> String {
        self.name.to_string()
    }

    fn next(&mut self, timeout: Duration) -> Option<SourceEvent> {
        Some(match QueueReader::next(self, timeout)? {
            QueueEvent::Message(datum) => SourceEvent::Sample(Arc::new(datum) as Arc<dyn Sample>),
            QueueEvent::Discarded { count, reason } => SourceEvent::Discarded { count, reason },
            QueueEvent::Waiting => SourceEvent::Waiting,
        })
    }
}
