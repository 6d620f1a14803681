//! The receiving end of a queue: an input port to which an Orocos component writes.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use asmotion_datum::{Datum, DatumError, Sample};
use asmotion_runtime::{Source, SourceEvent};

use crate::claim::{QueueClaim, QueueEnd};
use crate::error::QueueCheckError;
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
    /// Keeps other processes from reading from the queue.
    _claim: Option<QueueClaim>,
}

/// The search for a queue that does not exist yet, or no longer.
struct QueueSearch {
    since: Instant,
    /// Last time at which the queue did not exist, so that it will be a new one; `None` if it has existed since this search
    /// began.
    absent_at: Option<Instant>,
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
    waiting: WaitingMessages,
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

/// The messages that may have waited in a queue, by the times at which the reader looked at it. Messages contain no time, but
/// leave the queue in the order in which they were sent, as writers use one priority for all data: what was not there at a look
/// was sent after it.
struct WaitingMessages {
    /// Time after which the counted messages were sent.
    since: Instant,
    /// Number of messages at the last look that have not been read.
    count: usize,
    /// Time of the last look.
    counted_at: Instant,
    /// Last time at which the queue's name had not been removed.
    linked_at: Instant,
}

/// A message that was read into the buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ReadMessage {
    bytes: usize,
    priority: QueuePriority,
    /// Longest time for which it may have waited in the queue.
    waited: Duration,
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

/// Shortest standstill of a reader that counts, as scheduling delays reading by some milliseconds as well.
const STANDSTILL: Duration = Duration::from_millis(10);
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
            search: QueueSearch::new(None),
            _claim: None,
        }
    }

    /// Claims the messages of the queue for this process.
    ///
    /// # Errors
    /// [`QueueCheckError::Claimed`] if another process of ours reads from it.
    pub fn claimed(self) -> Result<Self, QueueCheckError> {
        let _claim = Some(QueueClaim::new(&self.name, QueueEnd::Reader)?);
        Ok(Self { _claim, ..self })
    }

    /// Sets the age limit of messages (default: none). Messages contain no time, so a reader with a limit discards those
    /// that were in the queue before it opened it, and those that may have waited for longer than the limit (but at least
    /// 10 ms), because the reader did not look, for example while its process was stopped.
    #[must_use]
    pub fn max_age(self, max_age: Option<Duration>) -> Self {
        Self { max_age, ..self }
    }

    /// Waits up to `timeout` for the next event. Returns `None` if there is none.
    pub fn next(&mut self, timeout: Duration) -> Option<QueueEvent> {
        let limit = self.max_age.map(|limit| limit.max(STANDSTILL));
        let Some(open) = &mut self.queue else {
            return self.open_queue(timeout);
        };
        open.watch_writers();
        let mut read = open.read(limit);
        if read == Ok(None) {
            open.wait(timeout, limit);
            open.watch_writers();
            read = open.read(limit);
        }
        match read {
            Ok(Some(message)) => open.interpret(&self.layout, message, limit),
            Ok(None) => {
                if open.is_unlinked() {
                    // the next queue of this name is a new one, and may have been there for as long
                    self.search = QueueSearch::new(Some(open.waiting.linked_at));
                    self.queue = None;
                }
                None
            }
            Err(reason) => {
                self.queue = None;
                self.search = QueueSearch::new(None);
                Some(QueueEvent::Discarded { count: 1, reason })
            }
        }
    }

    /// Searches for the queue.
    fn open_queue(&mut self, timeout: Duration) -> Option<QueueEvent> {
        let now = Instant::now();
        let pause = self
            .max_age
            .map_or(SEARCH, |limit| look_period(limit).min(SEARCH));
        match KernelQueue::open_existing(&self.name) {
            Ok(Some(queue)) => self.found(queue),
            Ok(None) => {
                self.search.absent_at = Some(now);
                thread::sleep(timeout.min(pause));
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
        let absent_at = self.search.absent_at;
        let now = Instant::now();
        let open = self.queue.insert(OpenQueue {
            buffer: vec![0; queue.size()],
            queue,
            expected: match absent_at {
                Some(_) => ExpectedMessage::LayoutOfQueue,
                None => ExpectedMessage::LayoutUntil(now + SETTLING),
            },
            writers: WriterWatch {
                writers: Vec::new(),
                is_known: false,
                look_at: now,
                pause: LOOK,
            },
            waiting: WaitingMessages::since(absent_at.unwrap_or(now)),
        });
        match (self.max_age, absent_at) {
            (Some(_), None) => open.discard_waiting(),
            (Some(_) | None, Some(_)) | (None, None) => None,
        }
    }
}

impl QueueSearch {
    fn new(absent_at: Option<Instant>) -> Self {
        Self {
            since: Instant::now(),
            absent_at,
            is_reported: false,
            problem: None,
        }
    }
}

impl WaitingMessages {
    /// Nothing is known of the queue's messages except that they were sent after this time.
    fn since(time: Instant) -> Self {
        Self {
            since: time,
            count: 0,
            counted_at: time,
            linked_at: time,
        }
    }

    /// Counts the messages in a queue, unless some of those counted before have not been read.
    fn look(&mut self, queue: &KernelQueue) {
        if self.count == 0 {
            self.since = self.counted_at;
            // before it counts: what is not counted is sent later than this
            self.counted_at = Instant::now();
            self.count = queue.count();
        }
    }

    /// Notes that a message was read. Returns the longest time for which it may have waited.
    fn take(&mut self, priority: QueuePriority) -> Duration {
        // one that shows the layout overtakes those that were counted
        if priority != QueuePriority::Layout {
            self.count = self.count.saturating_sub(1);
        }
        self.since.elapsed()
    }

    /// Notes that the queue was empty at this time.
    fn note_empty(&mut self, at: Instant) {
        self.count = 0;
        self.counted_at = at;
    }
}

impl OpenQueue {
    /// Removes the oldest message. With an age limit, also finds out for how long it may have waited.
    fn read(&mut self, limit: Option<Duration>) -> Result<Option<ReadMessage>, DatumError> {
        if limit.is_some() {
            self.waiting.look(&self.queue);
        }
        let now = Instant::now();
        let popped = self.queue.pop(&mut self.buffer).map_err(to_datum_error)?;
        if popped.is_none() {
            self.waiting.note_empty(now);
        }
        Ok(popped.map(|(bytes, priority)| ReadMessage {
            bytes,
            priority,
            waited: self.waiting.take(priority),
        }))
    }

    /// Waits until there is a message, at most this long. With an age limit, looks at the queue often enough to tell a
    /// message that has just arrived from one that waited for a reader that was stopped.
    fn wait(&mut self, timeout: Duration, limit: Option<Duration>) {
        let Some(limit) = limit else {
            return self.queue.wait(timeout);
        };
        let until = Instant::now() + timeout;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            self.queue.wait(left.min(look_period(limit)));
            self.waiting.look(&self.queue);
            if self.waiting.count > 0 || left.is_zero() || self.is_unlinked() {
                return;
            }
        }
    }

    /// Returns whether the queue's name has been removed.
    fn is_unlinked(&mut self) -> bool {
        let now = Instant::now();
        let is_unlinked = self.queue.is_unlinked();
        if !is_unlinked {
            self.waiting.linked_at = now;
        }
        is_unlinked
    }

    /// Discards the messages in the queue, the age of which is unknown.
    fn discard_waiting(&mut self) -> Option<QueueEvent> {
        let mut count = 0;
        while let Ok(Some(message)) = self.read(None) {
            self.expected = ExpectedMessage::Data;
            count += u64::from(message.priority != QueuePriority::Layout);
        }
        let reason = problem("in the queue before reading began, of unknown age".to_owned());
        (count > 0).then_some(QueueEvent::Discarded { count, reason })
    }

    /// Decides what a message is that was read, and whether it may be too old.
    fn interpret(
        &mut self,
        layout: &QueueLayout,
        message: ReadMessage,
        limit: Option<Duration>,
    ) -> Option<QueueEvent> {
        let waited = message.waited;
        let event = self.interpret_content(layout, message)?;
        match (event, limit) {
            (QueueEvent::Message(_), Some(limit)) if waited > limit => {
                let reason = problem(format!(
                    "may have waited {waited:.1?} in the queue, which was not read for so long; the limit is {limit:?}"
                ));
                Some(QueueEvent::Discarded { count: 1, reason })
            }
            (event, Some(_) | None) => Some(event),
        }
    }

    /// Decides whether a message is data or only shows the layout.
    fn interpret_content(
        &mut self,
        layout: &QueueLayout,
        ReadMessage {
            bytes, priority, ..
        }: ReadMessage,
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

/// Longest time between two looks at a queue with this age limit.
fn look_period(limit: Duration) -> Duration {
    limit.max(STANDSTILL) / 2
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
